//! What an IDL text defines.

use crate::log::schema::shape::Shape;
use std::collections::BTreeMap;

/// What a text defines.
pub(crate) struct Definitions {
    /// Types by full name.
    pub(crate) types: BTreeMap<String, IdlDefinition>,
    /// Constants by the module that holds them.
    pub(crate) constants: BTreeMap<String, Vec<(String, i64)>>,
}

/// A name or type as written.
#[derive(Debug, Clone)]
pub(crate) enum IdlName {
    Scalar(Shape),
    /// A defined type, and the scope in which it is named.
    Type {
        name: String,
        scope: String,
    },
    Sequence(Box<IdlName>),
}

#[derive(Debug, Clone)]
pub(crate) enum IdlDefinition {
    Structure(Vec<Member>),
    Alias(IdlName, Vec<usize>),
    Enumeration,
}

#[derive(Debug, Clone)]
pub(crate) struct Member {
    pub(crate) name: String,
    pub(crate) kind: IdlName,
    /// Lengths of a fixed array, the outermost first.
    pub(crate) lengths: Vec<usize>,
}
