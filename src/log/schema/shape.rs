//! The shape of a message, common to the schema languages.

use std::sync::Arc;

/// Largest nesting depth of messages.
pub(crate) const MAX_DEPTH: usize = 32;

/// Numbers that a schema names.
pub(crate) type Names = Arc<Vec<(String, i64)>>;

/// A message type.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Structure {
    pub name: String,
    pub fields: Vec<(String, Shape)>,
    /// Named numbers of the type, which its fields may hold.
    pub constants: Names,
}

impl Structure {
    /// The numbers named for the value at the end of `fields`; arrays on the path are entered.
    pub(crate) fn names<'s>(&self, fields: &mut impl Iterator<Item = &'s str>) -> Names {
        let Some(field) = fields.next() else { return Names::default() };
        let mut shape = self.fields.iter().find(|(name, _)| name == field).map(|(_, shape)| shape);
        while let Some(Shape::List(of, _)) = shape {
            shape = Some(of);
        }
        match shape {
            Some(Shape::Message(inner)) => inner.names(fields),
            Some(Shape::Number(_)) => self.constants.clone(),
            _ => Names::default(),
        }
    }
}

/// Content of a field.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Shape {
    Number(Kind),
    Text,
    /// Characters of four bytes.
    WideText,
    Message(Arc<Structure>),
    List(Box<Shape>, Size),
}

/// Number of elements of an array.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Size {
    Fixed(usize),
    /// The count precedes the elements.
    Counted,
}

/// Kinds of number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
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
    pub(crate) fn size(self) -> usize {
        match self {
            Self::Bool | Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::I64 | Self::U64 | Self::F64 => 8,
        }
    }
}
