//! The places of a message that hold a single value, for suggestions and detection.
//!
//! The nearest places come first, so that a limit on a large schema only cuts the deepest ones. A type is not entered again inside itself.
//! For any schema, at most [`MAX_LEAVES`] places are listed and [`MAX_FIELDS`] fields are examined.

use crate::log::schema::descriptor::{ProtobufKind, ProtobufMessage};
use crate::log::schema::shape::{Kind, MAX_DEPTH, Names, Shape, Size, Structure};
use prost_types::field_descriptor_proto::Type;
use std::collections::VecDeque;
use std::sync::Arc;

/// Largest number of places listed for one message; no robot's schema has more.
const MAX_LEAVES: usize = 2000;
/// Largest number of fields examined, over all messages nested in one.
const MAX_FIELDS: usize = 20_000;

/// Longest path that is listed [bytes]: names of megabytes are nobody's signals.
pub(crate) const LONGEST_PATH: usize = 1024;

/// A place of a message that holds a single value.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Leaf {
    /// Its path after the topic, beginning with a dot.
    pub path: String,
    pub kind: LeafKind,
    /// Numbers that the schema names.
    pub names: Names,
    /// The value is in an array: `path` ends before the index.
    pub list: Option<ListLeaf>,
}

/// An array of single values.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct ListLeaf {
    /// Name of a parallel array of strings, such as `name` of a joint state.
    pub names: Option<String>,
    /// Number of elements, if fixed.
    pub length: Option<usize>,
}

/// Kind of a leaf's value.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum LeafKind {
    Bool,
    Integer,
    Float,
    Text,
}

/// A message to be entered.
struct Ahead<T> {
    message: T,
    path: String,
    depth: usize,
}

/// The leaves found, and the messages to be entered.
struct Search<T> {
    found: Vec<Leaf>,
    ahead: VecDeque<Ahead<T>>,
    fields: usize,
}

impl<T> Search<T> {
    fn new(message: T) -> Self {
        Self { found: Vec::new(), ahead: VecDeque::from([Ahead { message, path: String::new(), depth: 0 }]), fields: 0 }
    }

    fn next(&mut self) -> Option<Ahead<T>> {
        self.ahead.pop_front()
    }

    fn add(&mut self, leaf: Leaf) {
        if leaf.path.len() <= LONGEST_PATH {
            self.found.push(leaf);
        }
    }

    /// Whether one more field may be examined.
    fn may_look(&mut self) -> bool {
        self.fields += 1;
        self.found.len() < MAX_LEAVES && self.fields <= MAX_FIELDS
    }

    fn enter(&mut self, message: T, path: String, depth: usize) {
        if depth <= MAX_DEPTH && path.len() <= LONGEST_PATH {
            self.ahead.push_back(Ahead { message, path, depth });
        }
    }
}

/// Every place of a message that holds a single value.
pub(crate) fn leaves(structure: &Structure) -> Vec<Leaf> {
    let mut search = Search::new(structure);
    while let Some(Ahead { message, path: at, depth }) = search.next() {
        let names = message.fields.iter().find(|(_, shape)| matches!(shape, Shape::List(of, _) if **of == Shape::Text));
        for (field, shape) in &message.fields {
            if !search.may_look() {
                return search.found;
            }
            let path = format!("{at}.{field}");
            let (kind, list) = match shape {
                Shape::Number(kind) => (leaf_kind(*kind), None),
                Shape::Text => (LeafKind::Text, None),
                Shape::WideText => continue,
                Shape::Message(inner) => {
                    search.enter(inner, path, depth + 1);
                    continue;
                }
                Shape::List(of, size) => {
                    let Shape::Number(kind) = **of else { continue };
                    let length = if let Size::Fixed(length) = size { Some(*length) } else { None };
                    (leaf_kind(kind), Some(ListLeaf { names: names.map(|(name, _)| name.clone()), length }))
                }
            };
            search.add(Leaf { path, kind, names: message.constants.clone(), list });
        }
    }
    search.found
}

fn leaf_kind(kind: Kind) -> LeafKind {
    match kind {
        Kind::Bool => LeafKind::Bool,
        Kind::F32 | Kind::F64 => LeafKind::Float,
        _ => LeafKind::Integer,
    }
}

/// Every place of a protobuf message that holds a single value.
pub(crate) fn protobuf_leaves(message: &ProtobufMessage) -> Vec<Leaf> {
    let nameless = Names::default();
    // each message with its enclosing types
    let mut search = Search::new((message.clone(), Arc::new(Within { index: message.index(), outer: None })));
    while let Some(Ahead { message: (message, within), path: at, depth }) = search.next() {
        for field in message.fields().iter().filter(|field| !field.is_map) {
            if !search.may_look() {
                return search.found;
            }
            let path = format!("{at}.{}", field.name);
            let mut names = &nameless;
            let kind = match &field.kind {
                ProtobufKind::Message(inner) => {
                    if !field.repeated && !within.has(*inner) {
                        let within = Arc::new(Within { index: *inner, outer: Some(within.clone()) });
                        search.enter((message.other(*inner), within), path, depth + 1);
                    }
                    continue;
                }
                ProtobufKind::Scalar(Type::Bool) => LeafKind::Bool,
                ProtobufKind::Scalar(Type::Double | Type::Float) => LeafKind::Float,
                ProtobufKind::Scalar(Type::String) => LeafKind::Text,
                ProtobufKind::Scalar(Type::Bytes) => continue,
                ProtobufKind::Enum(values) => {
                    names = values;
                    LeafKind::Integer
                }
                ProtobufKind::Scalar(_) => LeafKind::Integer,
            };
            let list = field.repeated.then_some(ListLeaf { names: None, length: None });
            search.add(Leaf { path, kind, names: names.clone(), list });
        }
    }
    search.found
}

/// A message type and those around it.
struct Within {
    index: usize,
    outer: Option<Arc<Within>>,
}

impl Within {
    fn has(&self, index: usize) -> bool {
        std::iter::successors(Some(self), |within| within.outer.as_deref()).any(|within| within.index == index)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A message of `width` messages of the next level, `depth` levels deep, with `inside` at the bottom.
    fn tree(width: usize, depth: usize, inside: Vec<(String, Shape)>) -> Structure {
        let bottom = Structure { name: String::new(), fields: inside, constants: Names::default() };
        (0..depth).fold(bottom, |below, _| {
            let below = Arc::new(below);
            let fields = (0..width).map(|n| (format!("m{n}"), Shape::Message(below.clone()))).collect();
            Structure { name: String::new(), fields, constants: Names::default() }
        })
    }

    #[test]
    fn near_places_come_before_deep_ones() {
        let mut message = tree(2, 20, vec![("x".into(), Shape::Number(Kind::F64))]);
        message.fields.push(("near".into(), Shape::Text));
        let found = leaves(&message);
        assert_eq!(found[0].path, ".near");
        assert!(found.len() <= MAX_LEAVES);
    }

    #[test]
    fn messages_without_values_that_multiply_are_not_all_entered() {
        assert_eq!(leaves(&tree(3, 30, Vec::new())), []);
    }
}
