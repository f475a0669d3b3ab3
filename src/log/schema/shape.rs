//! The shape of a message, common to the schema languages.

use super::descriptor::{Kind as ProtobufKind, Message};
use prost_types::field_descriptor_proto::Type;
use std::sync::Arc;

/// Places listed of one message at most; a schema with more is no robot's.
const MAX_LEAVES: usize = 2000;
/// Messages within messages at most.
pub(in super::super) const MAX_DEPTH: usize = 32;

/// A message type.
#[derive(Debug, Clone, PartialEq)]
pub(in super::super) struct Structure {
    pub name: String,
    pub fields: Vec<(String, Shape)>,
    /// Named numbers of the type, which its fields may hold.
    pub constants: Vec<(String, i64)>,
}

/// What stands in a field.
#[derive(Debug, Clone, PartialEq)]
pub(in super::super) enum Shape {
    Number(Kind),
    Text,
    /// Characters of four bytes.
    WideText,
    Message(Arc<Structure>),
    List(Box<Shape>, Size),
}

/// How many elements an array has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in super::super) enum Size {
    Fixed(usize),
    /// The count stands before the elements.
    Counted,
}

/// Kinds of number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in super::super) enum Kind {
    Bool,
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    I64,
    U64,
    F32,
    F64,
}

impl Kind {
    /// Size and natural alignment [bytes].
    pub(in super::super) fn size(self) -> usize {
        match self {
            Self::Bool | Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::I64 | Self::U64 | Self::F64 => 8,
        }
    }
}

/// A place of a message that holds a single value.
#[derive(Debug, Clone, PartialEq)]
pub(in super::super) struct Leaf {
    /// The way to it behind the topic, beginning with a dot.
    pub path: String,
    pub kind: LeafKind,
    /// Numbers that the schema names.
    pub names: Vec<(String, i64)>,
    /// The value stands in an array: `path` ends before the index.
    pub list: Option<ListLeaf>,
}

/// An array of single values.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(in super::super) struct ListLeaf {
    /// Name of a text array beside it, such as `name` of a joint state.
    pub names: Option<String>,
    /// Number of elements, if fixed.
    pub length: Option<usize>,
}

/// What kind of value a leaf holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in super::super) enum LeafKind {
    Bool,
    Integer,
    Float,
    Text,
}

/// Every place of a message that holds a single value.
pub(super) fn leaves(structure: &Structure) -> Vec<Leaf> {
    let mut found = Vec::new();
    descend(structure, "", 0, &mut found);
    found
}

fn descend(structure: &Structure, at: &str, depth: usize, found: &mut Vec<Leaf>) {
    if depth > MAX_DEPTH {
        return;
    }
    let names = structure.fields.iter().find(|(_, shape)| matches!(shape, Shape::List(of, _) if **of == Shape::Text));
    for (field, shape) in &structure.fields {
        if found.len() >= MAX_LEAVES {
            return;
        }
        let path = format!("{at}.{field}");
        let leaf = |kind, list| Leaf { path: path.clone(), kind, names: structure.constants.clone(), list };
        match shape {
            Shape::Number(kind) => found.push(leaf(leaf_kind(*kind), None)),
            Shape::Text => found.push(leaf(LeafKind::Text, None)),
            Shape::WideText => {}
            Shape::Message(inner) => descend(inner, &path, depth + 1, found),
            Shape::List(of, size) => {
                if let Shape::Number(kind) = **of {
                    let length = if let Size::Fixed(length) = size { Some(*length) } else { None };
                    found.push(leaf(leaf_kind(kind), Some(ListLeaf { names: names.map(|(name, _)| name.clone()), length })));
                }
            }
        }
    }
}

fn leaf_kind(kind: Kind) -> LeafKind {
    match kind {
        Kind::Bool => LeafKind::Bool,
        Kind::F32 | Kind::F64 => LeafKind::Float,
        _ => LeafKind::Integer,
    }
}

/// Every place of a protobuf message that holds a single value.
pub(super) fn protobuf_leaves(message: &Message) -> Vec<Leaf> {
    let mut found = Vec::new();
    descend_protobuf(message, "", 0, &mut found);
    found
}

fn descend_protobuf(message: &Message, at: &str, depth: usize, found: &mut Vec<Leaf>) {
    if depth > 8 {
        return; // protobuf messages may contain themselves
    }
    for field in message.fields() {
        if found.len() >= MAX_LEAVES {
            return;
        }
        let path = format!("{at}.{}", field.name);
        if field.is_map {
            continue;
        }
        let list = field.repeated.then_some(ListLeaf { names: None, length: None });
        let mut names = Vec::new();
        let kind = match &field.kind {
            ProtobufKind::Message(inner) => {
                if list.is_none() {
                    descend_protobuf(&message.other(*inner), &path, depth + 1, found);
                }
                continue;
            }
            ProtobufKind::Scalar(Type::Bool) => LeafKind::Bool,
            ProtobufKind::Scalar(Type::Double | Type::Float) => LeafKind::Float,
            ProtobufKind::Scalar(Type::String) => LeafKind::Text,
            ProtobufKind::Scalar(Type::Bytes) => continue,
            ProtobufKind::Enum(values) => {
                names.clone_from(values);
                LeafKind::Integer
            }
            ProtobufKind::Scalar(_) => LeafKind::Integer,
        };
        found.push(Leaf { path, kind, names, list });
    }
}
