//! Protobuf payloads: a walk over the wire format that enters only what is wanted.
//!
//! Fields may come in any order; the last occurrence of a single field counts, occurrences of a single message are merged. A field
//! without presence that is absent has its default value; an absent member of a `oneof`, `optional` field or message is missing.
//! Source: <https://protobuf.dev/programming-guides/encoding>.

use super::cdr::position;
use super::wish::{Check, Pick, Wish};
use super::{PlanError, Raw, Taken};
use prost_reflect::{FieldDescriptor, Kind, MessageDescriptor, Value};
use std::borrow::Cow;

/// Groups and messages within each other at most.
const MAX_DEPTH: usize = 64;

/// A compiled walk over a message type.
#[derive(Debug)]
pub(super) struct Program {
    fields: Vec<Field>,
    /// Values of fields that are absent when they have them.
    defaults: Vec<(usize, Raw<'static>)>,
    checks: Vec<Check>,
}

#[derive(Debug)]
struct Field {
    number: u32,
    scalar: Option<Scalar>,
    slots: Vec<usize>,
    /// What is wanted of a single message.
    message: Option<Program>,
    /// What is wanted of a repeated field.
    picks: Vec<(Pick, Program)>,
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

/// A field as it stands on the wire.
#[derive(Debug, Clone, Copy)]
enum Wire<'a> {
    Varint(u64),
    Fixed64([u8; 8]),
    Bytes(&'a [u8]),
    Fixed32([u8; 4]),
}

impl Program {
    pub(super) fn compile(message: &MessageDescriptor, wish: &Wish) -> Result<Self, PlanError> {
        Self::message(message, wish, "the message", 0)
    }

    fn message(message: &MessageDescriptor, wish: &Wish, within: &str, depth: usize) -> Result<Self, PlanError> {
        if depth > MAX_DEPTH {
            return Err(PlanError::TooLarge);
        }
        let known = || message.fields().map(|field| field.name().to_owned()).collect::<Vec<_>>();
        if !wish.take.is_empty() {
            return Err(PlanError::WholeMessage { field: within.to_owned(), known: known() });
        }
        if wish.elements.iter().any(|element| !matches!(element.pick, Pick::First { .. })) {
            return Err(PlanError::NotAnArray { field: within.to_owned() });
        }
        let (merged, checks) = wish.on_message();
        let mut program = Self { fields: Vec::new(), defaults: Vec::new(), checks };
        for (name, wish) in &merged.fields {
            let field = message
                .get_field_by_name(name)
                .or_else(|| message.get_field_by_json_name(name))
                .ok_or_else(|| PlanError::NoField { field: name.clone(), within: message.full_name().to_owned(), known: known() })?;
            program.add(&field, wish, depth)?;
        }
        Ok(program)
    }

    fn add(&mut self, field: &FieldDescriptor, wish: &Wish, depth: usize) -> Result<(), PlanError> {
        let name = field.name();
        let mut found =
            Field { number: field.number(), scalar: scalar(&field.kind()), slots: Vec::new(), message: None, picks: Vec::new() };
        let one = |wish: &Wish| -> Result<Self, PlanError> {
            match field.kind() {
                Kind::Message(inner) => Self::message(&inner, wish, name, depth + 1),
                _ if !wish.fields.is_empty() || !wish.elements.is_empty() => Err(match wish.fields.first() {
                    Some((field, _)) => PlanError::NoField { field: field.clone(), within: name.to_owned(), known: Vec::new() },
                    None => PlanError::NotAnArray { field: name.to_owned() },
                }),
                _ => Ok(Self { fields: Vec::new(), defaults: Vec::new(), checks: Vec::new() }),
            }
        };
        if field.is_list() || field.is_map() {
            if !wish.take.is_empty() || !wish.fields.is_empty() {
                return Err(PlanError::WholeArray { field: name.to_owned() });
            }
            for element in &wish.elements {
                let is_message = matches!(field.kind(), Kind::Message(_));
                let fits = match element.pick {
                    Pick::Index(_) => true,
                    Pick::First { .. } => is_message,
                    Pick::Find { .. } | Pick::At { .. } => !is_message,
                };
                if !fits {
                    return Err(PlanError::WholeMessage { field: name.to_owned(), known: Vec::new() });
                }
                let mut program = one(&element.wish)?;
                if !is_message {
                    // a single value is a message of one nameless field
                    program.fields.push(Field {
                        number: 0,
                        scalar: found.scalar,
                        slots: element.wish.take.clone(),
                        message: None,
                        picks: Vec::new(),
                    });
                }
                found.picks.push((element.pick.clone(), program));
            }
        } else if let Kind::Message(_) = field.kind() {
            found.message = Some(one(wish)?);
        } else {
            one(wish)?;
            found.slots.clone_from(&wish.take);
            let absent = (!field.supports_presence() || has_own_default(field)).then(|| default(&field.default_value()));
            if let Some(Some(value)) = absent {
                self.defaults.extend(wish.take.iter().map(|slot| (*slot, value.clone())));
            }
        }
        self.fields.push(found);
        Ok(())
    }

    pub(super) fn run<'a>(&self, payload: &'a [u8], taken: &mut Taken<'a>) -> Option<()> {
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

impl Field {
    /// Fills what one pick wants of a repeated field of the message `payload`.
    fn pick<'a>(&self, pick: &Pick, program: &Program, payload: &'a [u8], taken: &mut Taken<'a>, depth: usize) -> Option<()> {
        let wanted = match pick {
            Pick::Index(index) if *index < 0 => {
                let mut count = 0;
                self.each(payload, |_, _| {
                    count += 1;
                    Some(false)
                })?;
                match position(*index, count) {
                    Some(index) => Some(index as u64),
                    None => return Some(()),
                }
            }
            Pick::Index(index) => Some(*index as u64),
            Pick::At { register } => match taken.register(*register) {
                Some(index) => Some(index),
                None => return Some(()),
            },
            Pick::First { .. } | Pick::Find { .. } => None,
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
                for slot in program.fields.iter().flat_map(|field| &field.slots) {
                    taken.set(*slot, value.clone());
                }
                return Some(true);
            }
            let Wire::Bytes(inner) = wire else { return None };
            for (slot, value) in &program.defaults {
                taken.set(*slot, value.clone());
            }
            program.merge(inner, taken, depth + 1)?;
            if let Pick::First { test, tested, slots } = pick
                && !taken.get(*tested).passes(test)
            {
                taken.clear(slots);
                return Some(false);
            }
            Some(true)
        })
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
    Some(match kind {
        Kind::Double => Scalar::Double,
        Kind::Float => Scalar::Float,
        Kind::Int32 | Kind::Int64 => Scalar::Signed,
        Kind::Uint32 | Kind::Uint64 => Scalar::Unsigned,
        Kind::Sint32 | Kind::Sint64 => Scalar::ZigZag,
        Kind::Fixed32 => Scalar::Fixed32,
        Kind::Fixed64 => Scalar::Fixed64,
        Kind::Sfixed32 => Scalar::SignedFixed32,
        Kind::Sfixed64 => Scalar::SignedFixed64,
        Kind::Bool => Scalar::Bool,
        Kind::Enum(_) => Scalar::Enum,
        Kind::String | Kind::Bytes => Scalar::Text,
        Kind::Message(_) => return None,
    })
}

/// Whether a field with presence (proto2) declares a default.
fn has_own_default(field: &FieldDescriptor) -> bool {
    field.containing_oneof().is_none() && field.field_descriptor_proto().default_value.is_some()
}

fn default(value: &Value) -> Option<Raw<'static>> {
    Some(match value {
        Value::Bool(value) => Raw::Integer(i64::from(*value)),
        Value::I32(value) | Value::EnumNumber(value) => Raw::Integer(i64::from(*value)),
        Value::I64(value) => Raw::Integer(*value),
        Value::U32(value) => Raw::Integer(i64::from(*value)),
        Value::U64(value) => Raw::unsigned(*value),
        Value::F32(value) => Raw::Number(f64::from(*value)),
        Value::F64(value) => Raw::Number(*value),
        Value::String(text) => Raw::Text(Cow::Owned(text.clone())),
        _ => return None,
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

/// The next field: its number and value, no value for a group.
fn next<'a>(rest: &mut &'a [u8]) -> Option<(u32, Option<Wire<'a>>)> {
    let (number, wire) = tag(rest)?;
    let value = match wire {
        0 => Wire::Varint(varint(rest)?),
        1 => Wire::Fixed64(array(rest)?),
        2 => Wire::Bytes(block(rest)?),
        3 => {
            skip_group(rest, number)?;
            return Some((number, None));
        }
        5 => Wire::Fixed32(array(rest)?),
        _ => return None,
    };
    Some((number, Some(value)))
}

fn tag(rest: &mut &[u8]) -> Option<(u32, u8)> {
    let tag = varint(rest)?;
    let number = u32::try_from(tag >> 3).ok().filter(|number| *number != 0)?;
    Some((number, (tag & 7) as u8))
}

/// Skips to behind the end of group `number`.
fn skip_group(rest: &mut &[u8], number: u32) -> Option<()> {
    let mut open = vec![number];
    while let Some(innermost) = open.last() {
        let (number, wire) = tag(rest)?;
        match wire {
            0 => {
                varint(rest)?;
            }
            1 => {
                array::<8>(rest)?;
            }
            2 => {
                block(rest)?;
            }
            3 if open.len() < MAX_DEPTH => open.push(number),
            4 if number == *innermost => {
                open.pop();
            }
            5 => {
                array::<4>(rest)?;
            }
            _ => return None,
        }
    }
    Some(())
}

fn varint(rest: &mut &[u8]) -> Option<u64> {
    let mut value = 0;
    for place in 0..10 {
        let (byte, tail) = rest.split_first()?;
        *rest = tail;
        value |= u64::from(byte & 0x7f) << (7 * place);
        if byte & 0x80 == 0 {
            return Some(value);
        }
    }
    None
}

fn array<const N: usize>(rest: &mut &[u8]) -> Option<[u8; N]> {
    let (head, tail) = rest.split_first_chunk::<N>()?;
    *rest = tail;
    Some(*head)
}

fn block<'a>(rest: &mut &'a [u8]) -> Option<&'a [u8]> {
    let length = usize::try_from(varint(rest)?).ok()?;
    let (head, tail) = rest.split_at_checked(length)?;
    *rest = tail;
    Some(head)
}
