//! Running a program over one payload.

use crate::log::extract::extractor::cdr::number::{bytes, ended, number, shown};
use crate::log::extract::extractor::cdr::operation::Operation;
use crate::log::extract::extractor::cdr::shortcut::Trace;
use crate::log::extract::extractor::index::position;
use crate::log::extract::extractor::request_tree::Pick;
use crate::log::extract::extractor::slice::elements;
use crate::log::extract::extractor::taken::Taken;
use crate::log::schema::{Kind, Size};
use crate::log::value::Raw;

/// How numbers and arrays stand in a payload.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Form {
    /// Where the data begin: alignment counts from here.
    pub(crate) start: usize,
    /// Numbers are aligned to their size, but to no more than this.
    pub(crate) max_align: usize,
    /// A count of bytes stands before arrays of texts and of messages.
    pub(crate) delimited: bool,
}

/// A position in a payload. `BE`: big-endian.
pub(crate) struct Walk<'a, const BE: bool> {
    payload: &'a [u8],
    at: usize,
    form: Form,
    trace: Option<Trace>,
}

impl<'a, const BE: bool> Walk<'a, BE> {
    pub(crate) fn new(payload: &'a [u8], form: Form, trace: Option<Trace>) -> Self {
        Self { payload, at: form.start, form, trace }
    }

    /// Runs the whole program.
    pub(crate) fn all(&mut self, operations: &[Operation], taken: &mut Taken<'a>) -> Option<()> {
        if let Some(trace) = &mut self.trace {
            trace.depends_on(0, self.form.start.min(2)); // byte order and alignment
        }
        self.run(operations, taken)?;
        if let Some(trace) = &mut self.trace {
            trace.close(self.at, BE);
        }
        Some(())
    }

    /// What the walk noted.
    pub(crate) fn into_trace(self) -> Option<Trace> {
        self.trace
    }

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
                    self.delimiter()?;
                    for _ in 0..self.elements(*size, 4)? {
                        self.skip_text(*wide)?;
                    }
                }
                Operation::SkipMessages { size, each } => {
                    self.delimiter()?;
                    let count = self.elements(*size, 0)?;
                    self.skip_elements(count, each, taken)?;
                }
                Operation::Take { kind, slot } => {
                    self.align(kind.size());
                    let from = self.at;
                    self.take(kind.size())?;
                    self.give(from, *kind, &[*slot], taken)?;
                }
                Operation::TakeText { slot } => {
                    let (from, to) = self.text()?;
                    self.give_text(from, to, &[*slot], taken);
                }
                Operation::Numbers { size, kind, picks } => self.numbers(*size, *kind, picks, taken)?,
                Operation::Texts { size, picks } => self.texts(*size, picks, taken)?,
                Operation::Messages { size, skip, picks } => self.messages(*size, skip, picks, taken)?,
                Operation::Check(check) => {
                    self.give_up();
                    if !taken.get(check.tested).passes(&check.test) {
                        taken.clear(&check.slots);
                    }
                }
            }
        }
        Some(())
    }

    fn align(&mut self, size: usize) {
        let mask = size.min(self.form.max_align) - 1;
        self.at = ((self.at - self.form.start + mask) & !mask) + self.form.start;
    }

    fn take(&mut self, count: usize) -> Option<&'a [u8]> {
        let end = self.at.checked_add(count)?;
        let taken = self.payload.get(self.at..end)?;
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

    /// A count or a length.
    fn count(&mut self) -> Option<usize> {
        self.align(4);
        let count = u32::from_le_bytes(bytes::<BE, 4>(self.take(4)?)?);
        if let Some(trace) = &mut self.trace {
            trace.depends_on(self.at - 4, self.at);
        }
        Some(count as usize)
    }

    /// Skips the count of bytes before an array of texts or messages, in a form that has one.
    fn delimiter(&mut self) -> Option<()> {
        if self.form.delimited { self.skip(4, 1) } else { Some(()) }
    }

    /// Number of elements of at least `least` bytes each; `None` when the payload cannot hold so many.
    fn elements(&mut self, size: Size, least: usize) -> Option<usize> {
        let count = match size {
            Size::Fixed(count) => count,
            Size::Counted => self.count()?,
        };
        (count.checked_mul(least)? <= self.payload.len().checked_sub(self.at)?).then_some(count)
    }

    /// Puts the number at `from` into `slots`.
    fn give(&mut self, from: usize, kind: Kind, slots: &[usize], taken: &mut Taken<'a>) -> Option<()> {
        let value = number::<BE>(kind, self.payload.get(from..)?)?;
        for slot in slots {
            taken.set(*slot, value.clone());
            if let Some(trace) = &mut self.trace {
                trace.number(from, kind, *slot);
            }
        }
        Some(())
    }

    /// Puts the text between `from` and `to` into `slots`.
    fn give_text(&mut self, from: usize, to: usize, slots: &[usize], taken: &mut Taken<'a>) {
        for slot in slots {
            taken.set(*slot, shown(&self.payload[from..to]));
            if let Some(trace) = &mut self.trace {
                trace.text(from, to - from, *slot);
            }
        }
    }

    fn give_up(&mut self) {
        if let Some(trace) = &mut self.trace {
            trace.give_up();
        }
    }

    /// Where a text begins and ends.
    fn text(&mut self) -> Option<(usize, usize)> {
        let length = self.count()?;
        let from = self.at;
        self.take(length)?;
        Some((from, self.at))
    }

    fn skip_text(&mut self, wide: bool) -> Option<()> {
        let length = self.count()?;
        self.take(if wide { length.checked_mul(4)? } else { length })?;
        Some(())
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
        let all = self.take(kind.size() * count)?;
        for (pick, slots) in picks {
            let index = match pick {
                Pick::Index(index) => position(*index, count),
                Pick::At { register } => taken.register(*register).filter(|index| *index < count as u64).map(|index| index as usize),
                Pick::Find { test, register } => {
                    self.give_up();
                    let mut elements = all.chunks_exact(kind.size());
                    if let Some(found) = elements.position(|element| number::<BE>(kind, element).is_some_and(|value| value.passes(test))) {
                        taken.set(*register, Raw::Integer(found as i64));
                    }
                    None
                }
                Pick::Each { first, last, slots: kept } => {
                    self.give_up();
                    for index in elements(*first, *last, count) {
                        self.give(start + index * kind.size(), kind, slots, taken)?;
                        taken.keep(kept);
                    }
                    None
                }
                Pick::First { .. } => None,
            };
            if let Some(index) = index {
                self.give(start + index * kind.size(), kind, slots, taken)?;
            }
        }
        Some(())
    }

    fn texts(&mut self, size: Size, picks: &[(Pick, Vec<usize>)], taken: &mut Taken<'a>) -> Option<()> {
        self.delimiter()?;
        let count = self.elements(size, 4)?;
        for index in 0..count {
            let (from, to) = self.text()?;
            for (pick, slots) in picks {
                match pick {
                    Pick::Find { test, register } if taken.slots[*register] == Raw::Missing => {
                        if let Some(trace) = &mut self.trace {
                            trace.depends_on(from, to);
                        }
                        if test.text(ended(&self.payload[from..to])) {
                            taken.set(*register, Raw::Integer(index as i64));
                        }
                    }
                    Pick::Index(wanted) if position(*wanted, count) == Some(index) => self.give_text(from, to, slots, taken),
                    Pick::At { register } if taken.register(*register) == Some(index as u64) => self.give_text(from, to, slots, taken),
                    Pick::Each { first, last, slots: kept } if elements(*first, *last, count).contains(&index) => {
                        self.give_up();
                        self.give_text(from, to, slots, taken);
                        taken.keep(kept);
                    }
                    _ => {}
                }
            }
        }
        Some(())
    }

    fn messages(&mut self, size: Size, skip: &[Operation], picks: &[(Pick, Vec<Operation>)], taken: &mut Taken<'a>) -> Option<()> {
        self.delimiter()?;
        let count = self.elements(size, 0)?;
        let start = self.at;
        for (pick, program) in picks {
            self.at = start;
            let wanted = if let Pick::Each { first, last, .. } = pick {
                self.give_up();
                elements(*first, *last, count)
            } else {
                0..0
            };
            for index in 0..count {
                let before = self.at;
                match pick {
                    Pick::Index(wanted) if position(*wanted, count) == Some(index) => {
                        self.run(program, taken)?;
                        break;
                    }
                    Pick::First { test, tested, slots } => {
                        self.give_up();
                        self.run(program, taken)?;
                        if taken.get(*tested).passes(test) {
                            break;
                        }
                        taken.clear(slots);
                    }
                    Pick::Each { slots, .. } if wanted.contains(&index) => {
                        self.run(program, taken)?;
                        taken.keep(slots);
                    }
                    Pick::Each { .. } if index >= wanted.end => break,
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
