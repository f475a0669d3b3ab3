//! CDR and ROS 1 payloads: a program of skips and takes, compiled from the schema.
//!
//! CDR aligns each number to its own size, counted from behind the four bytes of the encapsulation header; ROS 1 is the same with an
//! alignment of one. Source: OMG DDS-XTYPES 1.3, section 7.4 (XCDR1, and XCDR2 for final types, where 8-byte numbers align to 4).

use super::super::schema::{Kind, Shape, Size, Structure};
use super::wish::{Check, Element, Pick, Wish};
use super::{PlanError, Raw, Taken};
use std::borrow::Cow;

/// Instructions of one program at most: far above any real schema.
const MAX_OPERATIONS: usize = 100_000;

/// A compiled walk over a payload.
#[derive(Debug)]
pub(super) struct Program {
    operations: Vec<Operation>,
}

#[derive(Debug)]
enum Operation {
    /// Skip `count` numbers of one size.
    Skip {
        size: usize,
        count: usize,
    },
    SkipText {
        wide: bool,
    },
    /// Skip an array of numbers with its count before it.
    SkipNumbers {
        size: usize,
    },
    SkipTexts {
        size: Size,
        wide: bool,
    },
    SkipMessages {
        size: Size,
        each: Vec<Operation>,
    },
    Take {
        kind: Kind,
        slot: usize,
    },
    TakeText {
        slot: usize,
    },
    /// Elements of an array of numbers.
    Numbers {
        size: Size,
        kind: Kind,
        picks: Vec<(Pick, Vec<usize>)>,
    },
    /// Elements of an array of texts.
    Texts {
        size: Size,
        picks: Vec<(Pick, Vec<usize>)>,
    },
    /// Elements of an array of messages: `skip` passes over one, each pick has its own program.
    Messages {
        size: Size,
        skip: Vec<Operation>,
        picks: Vec<(Pick, Vec<Operation>)>,
    },
    Check(Check),
}

impl Program {
    pub(super) fn compile(structure: &Structure, wish: &Wish) -> Result<Self, PlanError> {
        let mut compiler = Compiler { operations: 0 };
        let mut operations = compiler.structure(structure, wish, "the message")?;
        // nothing behind the last wanted field need be read
        let useful = operations.iter().rposition(Operation::is_wanted).map_or(0, |last| last + 1);
        operations.truncate(useful);
        Ok(Self { operations })
    }

    pub(super) fn run_cdr<'a>(&self, payload: &'a [u8], taken: &mut Taken<'a>) -> Option<()> {
        let (header, data) = payload.split_at_checked(4)?;
        match (header[0], header[1]) {
            (0, 0) => Walk::<true> { data, at: 0, max_align: 8 }.run(&self.operations, taken),
            (0, 1) => Walk::<false> { data, at: 0, max_align: 8 }.run(&self.operations, taken),
            (0, 6 | 0x10) => Walk::<true> { data, at: 0, max_align: 4 }.run(&self.operations, taken),
            (0, 7 | 0x11) => Walk::<false> { data, at: 0, max_align: 4 }.run(&self.operations, taken),
            _ => None,
        }
    }

    pub(super) fn run_ros1<'a>(&self, payload: &'a [u8], taken: &mut Taken<'a>) -> Option<()> {
        Walk::<false> { data: payload, at: 0, max_align: 1 }.run(&self.operations, taken)
    }
}

impl Operation {
    fn is_wanted(&self) -> bool {
        !matches!(
            self,
            Self::Skip { .. } | Self::SkipText { .. } | Self::SkipNumbers { .. } | Self::SkipTexts { .. } | Self::SkipMessages { .. }
        )
    }
}

struct Compiler {
    operations: usize,
}

impl Compiler {
    fn structure(&mut self, structure: &Structure, wish: &Wish, within: &str) -> Result<Vec<Operation>, PlanError> {
        let (fields, checks) = wish.on_message();
        if let Some(element) = wish.elements.iter().find(|element| !matches!(element.pick, Pick::First { .. })) {
            debug_assert!(!matches!(element.pick, Pick::First { .. }));
            return Err(PlanError::NotAnArray { field: within.to_owned() });
        }
        let known = || structure.fields.iter().map(|(name, _)| name.clone()).collect::<Vec<_>>();
        if !wish.take.is_empty() {
            return Err(PlanError::WholeMessage { field: within.to_owned(), known: known() });
        }
        if let Some((field, _)) = fields.fields.iter().find(|(name, _)| structure.fields.iter().all(|(known, _)| known != name)) {
            let within = if structure.name.is_empty() { within } else { &structure.name };
            return Err(PlanError::NoField { field: field.clone(), within: within.to_owned(), known: known() });
        }
        let mut operations = Vec::new();
        let none = Wish::default();
        for (name, shape) in &structure.fields {
            let wish = fields.fields.iter().find(|(field, _)| field == name).map_or(&none, |(_, wish)| wish);
            self.shape(shape, wish, name, &mut operations)?;
        }
        operations.extend(checks.into_iter().map(Operation::Check));
        Ok(operations)
    }

    fn shape(&mut self, shape: &Shape, wish: &Wish, name: &str, into: &mut Vec<Operation>) -> Result<(), PlanError> {
        let before = into.len();
        match shape {
            Shape::Message(inner) => into.extend(self.structure(inner, wish, name)?),
            Shape::List(of, size) => self.list(of, *size, wish, name, into)?,
            _ if !wish.fields.is_empty() || !wish.elements.is_empty() => {
                return Err(match wish.fields.first() {
                    Some((field, _)) => PlanError::NoField { field: field.clone(), within: name.to_owned(), known: Vec::new() },
                    None => PlanError::NotAnArray { field: name.to_owned() },
                });
            }
            Shape::Number(kind) => {
                // all but the last wish for the same value read it and step back: a rare case, kept simple by reading it once
                match wish.take[..] {
                    [] => skip_numbers(kind.size(), 1, into),
                    [slot] => into.push(Operation::Take { kind: *kind, slot }),
                    [..] => {
                        let picks = wish.take.iter().map(|slot| (Pick::Index(0), vec![*slot])).collect();
                        into.push(Operation::Numbers { size: Size::Fixed(1), kind: *kind, picks });
                    }
                }
            }
            Shape::Text => match wish.take[..] {
                [] => into.push(Operation::SkipText { wide: false }),
                [slot] => into.push(Operation::TakeText { slot }),
                [..] => {
                    let picks = wish.take.iter().map(|slot| (Pick::Index(0), vec![*slot])).collect();
                    into.push(Operation::Texts { size: Size::Fixed(1), picks });
                }
            },
            Shape::WideText => into.push(Operation::SkipText { wide: true }),
        }
        self.operations += into.len() - before;
        if self.operations > MAX_OPERATIONS { Err(PlanError::TooLarge) } else { Ok(()) }
    }

    fn list(&mut self, of: &Shape, size: Size, wish: &Wish, name: &str, into: &mut Vec<Operation>) -> Result<(), PlanError> {
        if !wish.take.is_empty() || !wish.fields.is_empty() {
            return Err(PlanError::WholeArray { field: name.to_owned() });
        }
        let leaf = |element: &Element| -> Result<(Pick, Vec<usize>), PlanError> {
            let inner = &element.wish;
            match (&element.pick, inner.fields.first()) {
                (Pick::First { .. }, _) => Err(PlanError::WholeMessage { field: name.to_owned(), known: Vec::new() }),
                (_, Some((field, _))) => {
                    Err(PlanError::NoField { field: field.clone(), within: format!("an element of {name}"), known: Vec::new() })
                }
                _ if !inner.elements.is_empty() => Err(PlanError::NotAnArray { field: format!("an element of {name}") }),
                (pick, None) => Ok((pick.clone(), inner.take.clone())),
            }
        };
        let wanted = !wish.elements.is_empty();
        match (of, size) {
            (Shape::Number(kind), _) if wanted => {
                let picks = wish.elements.iter().map(leaf).collect::<Result<_, _>>()?;
                into.push(Operation::Numbers { size, kind: *kind, picks });
            }
            (Shape::Number(kind), Size::Fixed(count)) => skip_numbers(kind.size(), count, into),
            (Shape::Number(kind), Size::Counted) => into.push(Operation::SkipNumbers { size: kind.size() }),
            (Shape::Text, _) if wanted => {
                let picks = wish.elements.iter().map(leaf).collect::<Result<_, _>>()?;
                into.push(Operation::Texts { size, picks });
            }
            (Shape::Text | Shape::WideText, _) => into.push(Operation::SkipTexts { size, wide: *of == Shape::WideText }),
            (of, _) => {
                let mut skip = Vec::new();
                self.shape(of, &Wish::default(), name, &mut skip)?;
                if wish.elements.is_empty() {
                    into.push(Operation::SkipMessages { size, each: skip });
                    return Ok(());
                }
                let mut picks = Vec::new();
                for element in &wish.elements {
                    if let Pick::Find { .. } | Pick::At { .. } = element.pick {
                        return Err(PlanError::WholeMessage { field: format!("an element of {name}"), known: Vec::new() });
                    }
                    let mut program = Vec::new();
                    self.shape(of, &element.wish, name, &mut program)?;
                    picks.push((element.pick.clone(), program));
                }
                into.push(Operation::Messages { size, skip, picks });
            }
        }
        Ok(())
    }
}

/// Skips numbers, together with those skipped just before if they have the same size.
fn skip_numbers(size: usize, count: usize, into: &mut Vec<Operation>) {
    match into.last_mut() {
        Some(Operation::Skip { size: last, count: sum }) if *last == size => *sum = sum.saturating_add(count),
        _ => into.push(Operation::Skip { size, count }),
    }
}

/// A position in a payload. `BE`: big-endian.
struct Walk<'a, const BE: bool> {
    data: &'a [u8],
    at: usize,
    max_align: usize,
}

impl<'a, const BE: bool> Walk<'a, BE> {
    fn run(&mut self, operations: &[Operation], taken: &mut Taken<'a>) -> Option<()> {
        for operation in operations {
            match operation {
                Operation::Skip { size, count } => self.skip(*size, *count)?,
                Operation::SkipText { wide } => self.skip_text(*wide)?,
                Operation::SkipNumbers { size } => {
                    let count = self.count()?;
                    self.skip(*size, count)?;
                }
                Operation::SkipTexts { size, wide } => {
                    for _ in 0..self.elements(*size, 4)? {
                        self.skip_text(*wide)?;
                    }
                }
                Operation::SkipMessages { size, each } => self.skip_messages(*size, each, taken)?,
                Operation::Take { kind, slot } => {
                    let value = self.number(*kind)?;
                    taken.set(*slot, value);
                }
                Operation::TakeText { slot } => {
                    let text = self.text()?;
                    taken.set(*slot, Raw::Text(String::from_utf8_lossy(text)));
                }
                Operation::Numbers { size, kind, picks } => self.numbers(*size, *kind, picks, taken)?,
                Operation::Texts { size, picks } => self.texts(*size, picks, taken)?,
                Operation::Messages { size, skip, picks } => self.messages(*size, skip, picks, taken)?,
                Operation::Check(check) => {
                    if !taken.get(check.tested).passes(&check.test) {
                        taken.clear(&check.slots);
                    }
                }
            }
        }
        Some(())
    }

    fn align(&mut self, size: usize) {
        let mask = size.min(self.max_align) - 1;
        self.at = (self.at + mask) & !mask;
    }

    fn take(&mut self, count: usize) -> Option<&'a [u8]> {
        let end = self.at.checked_add(count)?;
        let taken = self.data.get(self.at..end)?;
        self.at = end;
        Some(taken)
    }

    /// Skips `count` numbers; none need no alignment.
    fn skip(&mut self, size: usize, count: usize) -> Option<()> {
        if count > 0 {
            self.align(size);
            self.take(size.checked_mul(count)?)?;
        }
        Some(())
    }

    fn bytes<const N: usize>(&mut self) -> Option<[u8; N]> {
        self.align(N);
        let bytes = self.data.get(self.at..)?.first_chunk::<N>()?;
        self.at += N;
        let mut bytes = *bytes;
        if BE {
            bytes.reverse();
        }
        Some(bytes)
    }

    fn count(&mut self) -> Option<usize> {
        self.bytes().map(|bytes| u32::from_le_bytes(bytes) as usize)
    }

    /// Number of elements of at least `least` bytes each; `None` when the payload cannot hold so many.
    fn elements(&mut self, size: Size, least: usize) -> Option<usize> {
        let count = match size {
            Size::Fixed(count) => count,
            Size::Counted => self.count()?,
        };
        (count.checked_mul(least)? <= self.data.len().checked_sub(self.at)?).then_some(count)
    }

    fn number(&mut self, kind: Kind) -> Option<Raw<'a>> {
        Some(match kind {
            Kind::Bool | Kind::U8 => Raw::Integer(i64::from(self.take(1)?[0])),
            Kind::I8 => Raw::Integer(i64::from(self.take(1)?[0].cast_signed())),
            Kind::I16 => Raw::Integer(i64::from(i16::from_le_bytes(self.bytes()?))),
            Kind::U16 => Raw::Integer(i64::from(u16::from_le_bytes(self.bytes()?))),
            Kind::I32 => Raw::Integer(i64::from(i32::from_le_bytes(self.bytes()?))),
            Kind::U32 => Raw::Integer(i64::from(u32::from_le_bytes(self.bytes()?))),
            Kind::I64 => Raw::Integer(i64::from_le_bytes(self.bytes()?)),
            Kind::U64 => Raw::unsigned(u64::from_le_bytes(self.bytes()?)),
            Kind::F32 => Raw::Number(f64::from(f32::from_le_bytes(self.bytes()?))),
            Kind::F64 => Raw::Number(f64::from_le_bytes(self.bytes()?)),
        })
    }

    /// A text without the zero byte that CDR puts behind it.
    fn text(&mut self) -> Option<&'a [u8]> {
        let length = self.count()?;
        let text = self.take(length)?;
        Some(text.strip_suffix(&[0]).unwrap_or(text))
    }

    fn skip_text(&mut self, wide: bool) -> Option<()> {
        let length = self.count()?;
        self.take(if wide { length.checked_mul(4)? } else { length })?;
        Some(())
    }

    fn skip_messages(&mut self, size: Size, each: &[Operation], taken: &mut Taken<'a>) -> Option<()> {
        let count = self.elements(size, 0)?;
        self.skip_elements(count, each, taken)
    }

    fn skip_elements(&mut self, count: usize, each: &[Operation], taken: &mut Taken<'a>) -> Option<()> {
        for _ in 0..count {
            let before = self.at;
            self.run(each, taken)?;
            if self.at == before {
                break; // elements without content: any number of them takes no room
            }
        }
        Some(())
    }

    fn numbers(&mut self, size: Size, kind: Kind, picks: &[(Pick, Vec<usize>)], taken: &mut Taken<'a>) -> Option<()> {
        let count = self.elements(size, kind.size())?;
        if count == 0 {
            return Some(());
        }
        self.align(kind.size());
        let start = self.at;
        for (pick, slots) in picks {
            let index = match pick {
                Pick::Index(index) => position(*index, count),
                Pick::At { register } => taken.register(*register).filter(|index| *index < count as u64).map(|index| index as usize),
                Pick::Find { test, register } => {
                    let mut found = None;
                    for index in 0..count {
                        self.at = start + index * kind.size();
                        if self.number(kind)?.passes(test) {
                            found = Some(index);
                            break;
                        }
                    }
                    if let Some(found) = found {
                        taken.set(*register, Raw::Integer(found as i64));
                    }
                    None
                }
                Pick::First { .. } => None,
            };
            if let Some(index) = index {
                self.at = start + index * kind.size();
                let value = self.number(kind)?;
                for slot in slots {
                    taken.set(*slot, value.clone());
                }
            }
        }
        self.at = start;
        self.take(kind.size() * count)?;
        Some(())
    }

    fn texts(&mut self, size: Size, picks: &[(Pick, Vec<usize>)], taken: &mut Taken<'a>) -> Option<()> {
        let count = self.elements(size, 4)?;
        for index in 0..count {
            let text = self.text()?;
            for (pick, slots) in picks {
                match pick {
                    Pick::Find { test, register } if taken.slots[*register] == Raw::Missing && test.text(text) => {
                        taken.set(*register, Raw::Integer(index as i64));
                    }
                    Pick::Index(wanted) if position(*wanted, count) == Some(index) => {
                        for slot in slots {
                            taken.set(*slot, Raw::Text(String::from_utf8_lossy(text)));
                        }
                    }
                    Pick::At { register } if taken.register(*register) == Some(index as u64) => {
                        for slot in slots {
                            taken.set(*slot, Raw::Text(Cow::Owned(String::from_utf8_lossy(text).into_owned())));
                        }
                    }
                    _ => {}
                }
            }
        }
        Some(())
    }

    fn messages(&mut self, size: Size, skip: &[Operation], picks: &[(Pick, Vec<Operation>)], taken: &mut Taken<'a>) -> Option<()> {
        let count = self.elements(size, 0)?;
        let start = self.at;
        for (pick, program) in picks {
            self.at = start;
            for index in 0..count {
                let before = self.at;
                match pick {
                    Pick::Index(wanted) if position(*wanted, count) == Some(index) => {
                        self.run(program, taken)?;
                        break;
                    }
                    Pick::First { test, tested, slots } => {
                        self.run(program, taken)?;
                        if taken.get(*tested).passes(test) {
                            break;
                        }
                        taken.clear(slots);
                    }
                    _ => self.run(skip, taken)?,
                }
                if self.at == before {
                    break;
                }
            }
        }
        self.at = start;
        self.skip_elements(count, skip, taken)
    }
}

/// The element that an index means, if the array has it.
pub(super) fn position(index: i64, count: usize) -> Option<usize> {
    let index = if index < 0 { index + count as i64 } else { index };
    usize::try_from(index).ok().filter(|index| *index < count)
}
