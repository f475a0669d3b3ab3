//! One value of a message.

use crate::log::path::Test;
use std::borrow::Cow;

/// A value of a message.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) enum Raw<'a> {
    /// The message does not hold the value.
    #[default]
    Missing,
    Number(f64),
    Integer(i64),
    Text(Cow<'a, str>),
}

impl Raw<'_> {
    pub(crate) fn unsigned(value: u64) -> Self {
        i64::try_from(value).map_or(Self::Number(value as f64), Self::Integer)
    }

    pub(crate) fn passes(&self, test: &Test) -> bool {
        match self {
            Self::Missing => false,
            Self::Number(value) => test.number(*value),
            Self::Integer(value) => test.number(*value as f64),
            Self::Text(text) => test.text(text.as_bytes()),
        }
    }
}
