//! Paths merged into one tree of wishes, so that a message is walked once however many values are wanted of it.

use crate::log::extractor_error::PlanError;
use crate::log::path::{PathStep, Test};

/// What is wanted of a message.
#[derive(Debug)]
pub(crate) struct Wishes {
    pub root: Wish,
    pub slots: usize,
    pub registers: Vec<usize>,
}

/// What is wanted at one place of a message.
#[derive(Debug, Clone, Default)]
pub(crate) struct Wish {
    /// Slots that take the value that stands here.
    pub take: Vec<usize>,
    /// What is wanted of the fields, if a message stands here.
    pub fields: Vec<(String, Wish)>,
    /// What is wanted of the elements, if an array stands here.
    pub elements: Vec<Element>,
}

/// What is wanted of an array's elements.
#[derive(Debug, Clone)]
pub(crate) struct Element {
    pub pick: Pick,
    pub wish: Wish,
}

/// Which element is wanted.
#[derive(Debug, Clone)]
pub(crate) enum Pick {
    /// This one; negative counts from the end.
    Index(i64),
    /// The first in which the value in slot `tested` passes; all of `slots` are emptied for those that fail. On a message that is
    /// no array: the message itself, if it passes.
    First { test: Test, tested: usize, slots: Vec<usize> },
    /// The first that passes: its index goes into `register`.
    Find { test: Test, register: usize },
    /// The one whose index stands in `register`.
    At { register: usize },
    /// All from the first to the last, both included: what each of them puts into `slots` is kept as a list.
    Each { first: i64, last: i64, slots: Vec<usize> },
}

/// A condition on a message: `slots` are emptied unless slot `tested` passes.
#[derive(Debug, Clone)]
pub(crate) struct ElementCheck {
    pub test: Test,
    pub tested: usize,
    pub slots: Vec<usize>,
}

impl Wishes {
    pub(crate) fn new(paths: usize) -> Self {
        Self { root: Wish::default(), slots: paths, registers: Vec::new() }
    }

    /// Adds the path `steps`, whose value goes into `slot`.
    pub(crate) fn add(&mut self, steps: &[PathStep], slot: usize) -> Result<(), PlanError> {
        let mut root = std::mem::take(&mut self.root);
        let added = self.extend(&mut root, steps, slot);
        self.root = root;
        added
    }

    fn extend(&mut self, wish: &mut Wish, steps: &[PathStep], slot: usize) -> Result<(), PlanError> {
        match steps {
            [] => wish.take.push(slot),
            // a filter with nothing behind it picks from parallel arrays
            [PathStep::Field(name), PathStep::Filter(test)] => {
                let register = self.slots;
                self.slots += 1;
                self.registers.push(register);
                let sibling = test.field.iter().fold(&mut *wish, |at, name| at.field(name));
                sibling.elements.push(Element { pick: Pick::Find { test: test.clone(), register }, wish: Wish::default() });
                let leaf = Wish { take: vec![slot], ..Wish::default() };
                wish.field(name).elements.push(Element { pick: Pick::At { register }, wish: leaf });
            }
            [PathStep::Field(name), rest @ ..] => {
                let mut child = std::mem::take(wish.field(name));
                let added = self.extend(&mut child, rest, slot);
                *wish.field(name) = child;
                added?;
            }
            [PathStep::Index(index), rest @ ..] => self.element(wish, *index, rest, slot)?,
            [PathStep::Slice(first, last), rest @ ..] => match (first.unwrap_or(0), last.unwrap_or(-1)) {
                (first, last) if first == last => self.element(wish, first, rest, slot)?,
                (first, last) => self.each(wish, first, last, rest, slot)?,
            },
            [PathStep::Filter(_)] => return Err(PlanError::WholeMessage { field: "the filtered message".into(), known: Vec::new() }),
            [PathStep::Filter(test), rest @ ..] => {
                let tested = self.slots;
                self.slots += 1;
                let before = self.slots;
                let mut inner = Wish::default();
                test.field.iter().fold(&mut inner, |at, name| at.field(name)).take.push(tested);
                self.extend(&mut inner, rest, slot)?;
                let slots = [slot, tested].into_iter().chain(before..self.slots).collect();
                wish.elements.push(Element { pick: Pick::First { test: test.clone(), tested, slots }, wish: inner });
            }
        }
        Ok(())
    }

    fn element(&mut self, wish: &mut Wish, index: i64, rest: &[PathStep], slot: usize) -> Result<(), PlanError> {
        let mut inner = Wish::default();
        self.extend(&mut inner, rest, slot)?;
        wish.elements.push(Element { pick: Pick::Index(index), wish: inner });
        Ok(())
    }
}

impl Wishes {
    /// Every element of a slice. Slices of the same elements are one, so that the array is walked once for all of them.
    fn each(&mut self, wish: &mut Wish, first: i64, last: i64, rest: &[PathStep], slot: usize) -> Result<(), PlanError> {
        if rest.iter().any(|step| matches!(step, PathStep::Slice(..) | PathStep::Filter(_))) {
            return Err(PlanError::ListWithin);
        }
        let mut inner = Wish::default();
        self.extend(&mut inner, rest, slot)?;
        let same = |element: &&mut Element| matches!(element.pick, Pick::Each { first: f, last: l, .. } if (f, l) == (first, last));
        match wish.elements.iter_mut().find(same) {
            Some(Element { pick: Pick::Each { slots, .. }, wish }) => {
                slots.push(slot);
                wish.merge(inner);
            }
            _ => wish.elements.push(Element { pick: Pick::Each { first, last, slots: vec![slot] }, wish: inner }),
        }
        Ok(())
    }
}

impl Wish {
    fn field(&mut self, name: &str) -> &mut Wish {
        let index = self.fields.iter().position(|(known, _)| known == name).unwrap_or_else(|| {
            self.fields.push((name.to_owned(), Wish::default()));
            self.fields.len() - 1
        });
        &mut self.fields[index].1
    }

    /// Adds what another wish for the same place wants.
    pub(crate) fn merge(&mut self, other: Wish) {
        self.take.extend(other.take);
        self.elements.extend(other.elements);
        for (name, wish) in other.fields {
            self.field(&name).merge(wish);
        }
    }

    /// The wish for the case that a single message stands here: filters become checks on it.
    pub(crate) fn on_message(&self) -> (Wish, Vec<ElementCheck>) {
        let mut fields = Wish { fields: self.fields.clone(), ..Wish::default() };
        let mut checks = Vec::new();
        for element in &self.elements {
            if let Pick::First { test, tested, slots } = &element.pick {
                let (inner, mut deeper) = element.wish.on_message();
                fields.merge(inner);
                checks.append(&mut deeper);
                checks.push(ElementCheck { test: test.clone(), tested: *tested, slots: slots.clone() });
            }
        }
        (fields, checks)
    }
}
