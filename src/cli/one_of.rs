//! Values that are one of some names: completion scripts offer the names.

use clap::builder::{PossibleValue, StringValueParser, TypedValueParser};
use clap::{Arg, Command};
use std::ffi::OsStr;

/// Parser of a value that is one of some names.
#[derive(Clone)]
pub(crate) struct OneOf<T> {
    names: Vec<String>,
    parse: fn(&str) -> Result<T, String>,
}

impl<T> OneOf<T> {
    /// `names` are those that completion offers; `parse` decides, and words the error about any other.
    pub(crate) fn new(names: impl IntoIterator<Item = impl Into<String>>, parse: fn(&str) -> Result<T, String>) -> Self {
        Self { names: names.into_iter().map(Into::into).collect(), parse }
    }
}

impl<T: Clone + Send + Sync + 'static> TypedValueParser for OneOf<T> {
    type Value = T;

    fn parse_ref(&self, command: &Command, argument: Option<&Arg>, value: &OsStr) -> Result<T, clap::Error> {
        let parse = self.parse;
        StringValueParser::new().try_map(move |text| parse(&text)).parse_ref(command, argument, value)
    }

    fn possible_values(&self) -> Option<Box<dyn Iterator<Item = PossibleValue> + '_>> {
        Some(Box::new(self.names.iter().map(PossibleValue::new)))
    }
}
