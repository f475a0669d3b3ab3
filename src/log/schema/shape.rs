//! The shape of a message, common to the schema languages.

use std::sync::Arc;

/// Messages within messages at most.
pub(in super::super) const MAX_DEPTH: usize = 32;

/// Numbers that a schema names.
pub(in super::super) type Names = Arc<Vec<(String, i64)>>;

/// A message type.
#[derive(Debug, Clone, PartialEq)]
pub(in super::super) struct Structure {
    pub name: String,
    pub fields: Vec<(String, Shape)>,
    /// Named numbers of the type, which its fields may hold.
    pub constants: Names,
}

impl Structure {
    /// The numbers named for the value that `fields` lead to, through whatever arrays lie on the way.
    pub(super) fn names<'s>(&self, fields: &mut impl Iterator<Item = &'s str>) -> Names {
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
