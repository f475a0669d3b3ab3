//! From a schema and what is wanted of it to the operations of a program.

use crate::log::extract::extractor::cdr::operation::Operation;
use crate::log::extract::extractor::request_tree::{Element, Pick, Wish};
use crate::log::extractor_error::PlanError;
use crate::log::schema::{Shape, Size, Structure};

/// Instructions and types of one program at most: far above any real schema.
const MAX_WORK: usize = 100_000;

/// The operations that take what `wish` wants of a message: nothing behind the last wanted field is looked at.
pub(crate) fn compile(structure: &Structure, wish: &Wish) -> Result<Vec<Operation>, PlanError> {
    Compiler { work: 0 }.structure(structure, wish, "the message", true)
}

struct Compiler {
    /// Instructions made and types entered: types without content make none, and may be many all the same.
    work: usize,
}

impl Compiler {
    /// `last`: nothing that stands behind this message is wanted.
    fn structure(&mut self, structure: &Structure, wish: &Wish, within: &str, last: bool) -> Result<Vec<Operation>, PlanError> {
        let (fields, checks) = wish.on_message();
        if wish.elements.iter().any(|element| !matches!(element.pick, Pick::First { .. })) {
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
        let wish = |name: &String| fields.fields.iter().find(|(field, _)| field == name).map(|(_, wish)| wish);
        let end = if last { structure.fields.iter().rposition(|(name, _)| wish(name).is_some()) } else { None };
        let end = end.unwrap_or(structure.fields.len());
        for (place, (name, shape)) in structure.fields.iter().enumerate().take(end.saturating_add(1)) {
            self.shape(shape, wish(name).unwrap_or(&none), name, last && place == end, &mut operations)?;
        }
        operations.extend(checks.into_iter().map(Operation::Check));
        Ok(operations)
    }

    fn shape(&mut self, shape: &Shape, wish: &Wish, name: &str, last: bool, into: &mut Vec<Operation>) -> Result<(), PlanError> {
        self.work += 1;
        if self.work > MAX_WORK {
            return Err(PlanError::TooLarge);
        }
        match shape {
            Shape::Message(inner) => into.extend(self.structure(inner, wish, name, last)?),
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
        Ok(())
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
                self.shape(of, &Wish::default(), name, false, &mut skip)?;
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
                    self.shape(of, &element.wish, name, false, &mut program)?;
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

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::log::extract::extractor::request_tree::Wishes;
    use crate::log::path::MessagePath;
    use crate::log::schema::{Kind, Names};
    use std::sync::Arc;

    /// `value` beside two empty messages of two empty messages of … 30 levels deep.
    fn hollow(value_first: bool) -> Structure {
        let message = |fields| Structure { name: "a/M".into(), fields, constants: Names::default() };
        let hollow = (0..30).fold(Arc::new(message(Vec::new())), |below, _| {
            Arc::new(message(["l", "r"].map(|name| (name.to_owned(), Shape::Message(below.clone()))).into()))
        });
        let mut fields = vec![("hollow".to_owned(), Shape::Message(hollow)), ("value".to_owned(), Shape::Number(Kind::F64))];
        if value_first {
            fields.reverse();
        }
        message(fields)
    }

    fn operations(structure: &Structure) -> Result<usize, PlanError> {
        let path: MessagePath = "/t.value".parse().unwrap();
        let mut wishes = Wishes::new(1);
        wishes.add(&path.steps, 0).unwrap();
        compile(structure, &wishes.root).map(|operations| operations.len())
    }

    #[test]
    fn messages_without_content_that_multiply_are_refused_where_they_must_be_passed() {
        assert_eq!(operations(&hollow(false)), Err(PlanError::TooLarge));
    }

    #[test]
    fn what_stands_behind_the_last_wanted_field_is_not_looked_at() {
        assert_eq!(operations(&hollow(true)), Ok(1));
    }
}
