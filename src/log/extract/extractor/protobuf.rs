//! Protobuf payloads: a walk over the wire format that enters only what is wanted.
//!
//! Fields may come in any order; the last occurrence of a single field counts, occurrences of a single message are merged. A field
//! without presence that is absent has its default value; an absent member of a `oneof`, `optional` field or message is missing.
//! Source: <https://protobuf.dev/programming-guides/encoding>.

#[cfg(test)]
mod tests;
mod wire;

use crate::log::extract::extractor::index::position;
use crate::log::extract::extractor::request_tree::{ElementCheck, Pick, Wish};
use crate::log::extract::extractor::slice::elements;
use crate::log::extract::extractor::taken::Taken;
use crate::log::extractor_error::PlanError;
use crate::log::schema::{ProtobufField, ProtobufKind as Kind, ProtobufMessage};
use crate::log::value::Raw;
use prost_types::field_descriptor_proto::Type;
use wire::{MAX_DEPTH, Wire, array, next, varint};

/// A compiled walk over a message type.
#[derive(Debug)]
pub(crate) struct ProtobufProgram {
    fields: Vec<WireField>,
    /// Values of fields that are absent when they have them.
    defaults: Vec<(usize, Raw<'static>)>,
    checks: Vec<ElementCheck>,
}

#[derive(Debug)]
struct WireField {
    number: u32,
    scalar: Option<Scalar>,
    slots: Vec<usize>,
    /// What is wanted of a single message.
    message: Option<ProtobufProgram>,
    /// What is wanted of a repeated field.
    picks: Vec<(Pick, ProtobufProgram)>,
}

/// How a single value is encoded.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Scalar {
    Double,
    Float,
    Signed,
    Unsigned,
    ZigZag,
    Bool,
    Enum,
    Fixed32,
    Fixed64,
    SignedFixed32,
    SignedFixed64,
    Text,
}

impl ProtobufProgram {
    pub(crate) fn compile(message: &ProtobufMessage, wish: &Wish) -> Result<Self, PlanError> {
        Self::message(message, wish, "the message", 0)
    }

    fn message(message: &ProtobufMessage, wish: &Wish, within: &str, depth: usize) -> Result<Self, PlanError> {
        if depth > MAX_DEPTH {
            return Err(PlanError::TooLarge);
        }
        let known = || message.fields().iter().map(|field| field.name.clone()).collect::<Vec<_>>();
        if !wish.take.is_empty() {
            return Err(PlanError::WholeMessage { field: within.to_owned(), known: known() });
        }
        if wish.elements.iter().any(|element| !matches!(element.pick, Pick::First { .. })) {
            return Err(PlanError::NotAnArray { field: within.to_owned() });
        }
        let (merged, checks) = wish.on_message();
        let mut program = Self { fields: Vec::new(), defaults: Vec::new(), checks };
        let mut wanted: Vec<(&ProtobufField, Wish)> = Vec::new();
        for (name, wish) in merged.fields {
            let field = message.field(&name).ok_or_else(|| PlanError::NoField {
                field: name,
                within: message.full_name().to_owned(),
                known: known(),
            })?;
            // one field may be named in two ways
            match wanted.iter_mut().find(|(known, _)| known.number == field.number) {
                Some((_, all)) => all.merge(wish),
                None => wanted.push((field, wish)),
            }
        }
        for (field, wish) in &wanted {
            program.add(message, field, wish, depth)?;
        }
        Ok(program)
    }

    fn add(&mut self, within: &ProtobufMessage, field: &ProtobufField, wish: &Wish, depth: usize) -> Result<(), PlanError> {
        let name = field.name.as_str();
        let mut found =
            WireField { number: field.number, scalar: scalar(&field.kind), slots: Vec::new(), message: None, picks: Vec::new() };
        let one = |wish: &Wish| -> Result<Self, PlanError> {
            match field.kind {
                Kind::Message(inner) => Self::message(&within.other(inner), wish, name, depth + 1),
                _ if !wish.fields.is_empty() || !wish.elements.is_empty() => Err(match wish.fields.first() {
                    Some((field, _)) => PlanError::NoField { field: field.clone(), within: name.to_owned(), known: Vec::new() },
                    None => PlanError::NotAnArray { field: name.to_owned() },
                }),
                _ => Ok(Self { fields: Vec::new(), defaults: Vec::new(), checks: Vec::new() }),
            }
        };
        if field.repeated {
            if !wish.take.is_empty() || !wish.fields.is_empty() {
                return Err(PlanError::WholeArray { field: name.to_owned() });
            }
            for element in &wish.elements {
                let is_message = matches!(field.kind, Kind::Message(_));
                let fits = match element.pick {
                    Pick::Index(_) | Pick::Each { .. } => true,
                    Pick::First { .. } => is_message,
                    Pick::Find { .. } | Pick::At { .. } => !is_message,
                };
                if !fits {
                    return Err(PlanError::WholeMessage { field: name.to_owned(), known: Vec::new() });
                }
                let mut program = one(&element.wish)?;
                if !is_message {
                    // a single value is a message of one nameless field
                    program.fields.push(WireField {
                        number: 0,
                        scalar: found.scalar,
                        slots: element.wish.take.clone(),
                        message: None,
                        picks: Vec::new(),
                    });
                }
                found.picks.push((element.pick.clone(), program));
            }
        } else if let Kind::Message(_) = field.kind {
            found.message = Some(one(wish)?);
        } else {
            one(wish)?;
            found.slots.clone_from(&wish.take);
            if let Some(value) = &field.absent {
                self.defaults.extend(wish.take.iter().map(|slot| (*slot, value.clone())));
            }
        }
        self.fields.push(found);
        Ok(())
    }

    pub(crate) fn run<'a>(&self, payload: &'a [u8], taken: &mut Taken<'a>) -> Option<()> {
        for (slot, value) in &self.defaults {
            taken.set(*slot, value.clone());
        }
        self.merge(payload, taken, 0)
    }

    fn merge<'a>(&self, payload: &'a [u8], taken: &mut Taken<'a>, depth: usize) -> Option<()> {
        let mut rest = payload;
        let mut entered = 0_u64; // single messages met before, by place in `fields`: only the first sets defaults
        while !rest.is_empty() {
            let (number, wire) = next(&mut rest)?;
            let Some(wire) = wire else { continue };
            let Some((place, field)) = self.fields.iter().enumerate().find(|(_, field)| field.number == number) else { continue };
            if let Some(program) = &field.message {
                let Wire::Bytes(inner) = wire else { return None };
                let bit = 1_u64.checked_shl(place as u32).unwrap_or(0);
                if entered & bit == 0 {
                    entered |= bit;
                    for (slot, value) in &program.defaults {
                        taken.set(*slot, value.clone());
                    }
                }
                program.merge(inner, taken, depth + 1)?;
            } else if field.picks.is_empty() {
                let value = value(field.scalar?, last_of(field.scalar?, wire)?)?;
                for slot in &field.slots {
                    taken.set(*slot, value.clone());
                }
            }
        }
        for field in &self.fields {
            for (pick, program) in &field.picks {
                field.pick(pick, program, payload, taken, depth)?;
            }
        }
        for check in &self.checks {
            if !taken.get(check.tested).passes(&check.test) {
                taken.clear(&check.slots);
            }
        }
        Some(())
    }
}

impl WireField {
    /// Fills what one pick wants of a repeated field of the message `payload`.
    fn pick<'a>(&self, pick: &Pick, program: &ProtobufProgram, payload: &'a [u8], taken: &mut Taken<'a>, depth: usize) -> Option<()> {
        let count = || {
            let mut count = 0;
            self.each(payload, |_, _| {
                count += 1;
                Some(false)
            })?;
            Some(count)
        };
        if let Pick::Each { first, last, slots } = pick {
            let wanted = elements(*first, *last, count()?);
            return self.each(payload, |index, wire| {
                if !wanted.contains(&(index as usize)) {
                    return Some(index as usize >= wanted.end);
                }
                self.one(program, wire, taken, depth)?;
                taken.keep(slots);
                Some(false)
            });
        }
        let wanted = match pick {
            Pick::Index(index) if *index < 0 => match position(*index, count()?) {
                Some(index) => Some(index as u64),
                None => return Some(()),
            },
            Pick::Index(index) => Some(*index as u64),
            Pick::At { register } => match taken.register(*register) {
                Some(index) => Some(index),
                None => return Some(()),
            },
            Pick::First { .. } | Pick::Find { .. } | Pick::Each { .. } => None,
        };
        self.each(payload, |index, wire| {
            if wanted.is_some_and(|wanted| wanted != index) {
                return Some(false);
            }
            if let Some(scalar) = self.scalar {
                let value = value(scalar, wire)?;
                if let Pick::Find { test, register } = pick {
                    let found = value.passes(test);
                    if found {
                        taken.set(*register, Raw::Integer(index as i64));
                    }
                    return Some(found);
                }
            }
            self.one(program, wire, taken, depth)?;
            if let Pick::First { test, tested, slots } = pick
                && !taken.get(*tested).passes(test)
            {
                taken.clear(slots);
                return Some(false);
            }
            Some(true)
        })
    }

    /// Fills what is wanted of one element.
    fn one<'a>(&self, program: &ProtobufProgram, wire: Wire<'a>, taken: &mut Taken<'a>, depth: usize) -> Option<()> {
        if let Some(scalar) = self.scalar {
            let value = value(scalar, wire)?;
            for slot in program.fields.iter().flat_map(|field| &field.slots) {
                taken.set(*slot, value.clone());
            }
            return Some(());
        }
        let Wire::Bytes(inner) = wire else { return None };
        for (slot, value) in &program.defaults {
            taken.set(*slot, value.clone());
        }
        program.merge(inner, taken, depth + 1)
    }

    /// Calls `visit` for each element of the repeated field, packed or not, until it says `true`.
    fn each<'a>(&self, payload: &'a [u8], mut visit: impl FnMut(u64, Wire<'a>) -> Option<bool>) -> Option<()> {
        let mut rest = payload;
        let mut index = 0;
        while !rest.is_empty() {
            let (number, wire) = next(&mut rest)?;
            let Some(wire) = wire.filter(|_| number == self.number) else { continue };
            match (self.scalar, wire) {
                (Some(scalar), Wire::Bytes(mut packed)) if scalar != Scalar::Text => {
                    while !packed.is_empty() {
                        if visit(index, unpack(scalar, &mut packed)?)? {
                            return Some(());
                        }
                        index += 1;
                    }
                }
                (_, wire) => {
                    if visit(index, wire)? {
                        return Some(());
                    }
                    index += 1;
                }
            }
        }
        Some(())
    }
}

fn scalar(kind: &Kind) -> Option<Scalar> {
    let kind = match kind {
        Kind::Message(_) => return None,
        Kind::Enum(_) => return Some(Scalar::Enum),
        Kind::Scalar(kind) => kind,
    };
    Some(match kind {
        Type::Double => Scalar::Double,
        Type::Float => Scalar::Float,
        Type::Int32 | Type::Int64 => Scalar::Signed,
        Type::Uint32 | Type::Uint64 => Scalar::Unsigned,
        Type::Sint32 | Type::Sint64 => Scalar::ZigZag,
        Type::Fixed32 => Scalar::Fixed32,
        Type::Fixed64 => Scalar::Fixed64,
        Type::Sfixed32 => Scalar::SignedFixed32,
        Type::Sfixed64 => Scalar::SignedFixed64,
        Type::Bool => Scalar::Bool,
        Type::String | Type::Bytes => Scalar::Text,
        Type::Enum | Type::Message | Type::Group => return None,
    })
}

/// The value of a single field; writers may pack it all the same, and then the last element counts.
fn last_of(scalar: Scalar, wire: Wire<'_>) -> Option<Wire<'_>> {
    let Wire::Bytes(mut packed) = wire else { return Some(wire) };
    if scalar == Scalar::Text {
        return Some(wire);
    }
    let mut last = None;
    while !packed.is_empty() {
        last = Some(unpack(scalar, &mut packed)?);
    }
    last
}

fn unpack<'a>(scalar: Scalar, packed: &mut &'a [u8]) -> Option<Wire<'a>> {
    Some(match scalar {
        Scalar::Double | Scalar::Fixed64 | Scalar::SignedFixed64 => Wire::Fixed64(array(packed)?),
        Scalar::Float | Scalar::Fixed32 | Scalar::SignedFixed32 => Wire::Fixed32(array(packed)?),
        Scalar::Text => return None,
        _ => Wire::Varint(varint(packed)?),
    })
}

fn value(scalar: Scalar, wire: Wire<'_>) -> Option<Raw<'_>> {
    Some(match (scalar, wire) {
        (Scalar::Double, Wire::Fixed64(bytes)) => Raw::Number(f64::from_le_bytes(bytes)),
        (Scalar::Float, Wire::Fixed32(bytes)) => Raw::Number(f64::from(f32::from_le_bytes(bytes))),
        (Scalar::Signed, Wire::Varint(value)) => Raw::Integer(value.cast_signed()),
        // an enum or int32 may be written in 32 or in 64 bits: the low ones count
        (Scalar::Enum, Wire::Varint(value)) => Raw::Integer(i64::from((value as u32).cast_signed())),
        (Scalar::Unsigned, Wire::Varint(value)) => Raw::unsigned(value),
        (Scalar::ZigZag, Wire::Varint(value)) => Raw::Integer((value >> 1).cast_signed() ^ -(value & 1).cast_signed()),
        (Scalar::Bool, Wire::Varint(value)) => Raw::Integer(i64::from(value != 0)),
        (Scalar::Fixed32, Wire::Fixed32(bytes)) => Raw::Integer(i64::from(u32::from_le_bytes(bytes))),
        (Scalar::Fixed64, Wire::Fixed64(bytes)) => Raw::unsigned(u64::from_le_bytes(bytes)),
        (Scalar::SignedFixed32, Wire::Fixed32(bytes)) => Raw::Integer(i64::from(i32::from_le_bytes(bytes))),
        (Scalar::SignedFixed64, Wire::Fixed64(bytes)) => Raw::Integer(i64::from_le_bytes(bytes)),
        (Scalar::Text, Wire::Bytes(bytes)) => Raw::Text(String::from_utf8_lossy(bytes)),
        _ => return None,
    })
}
