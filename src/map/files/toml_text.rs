//! TOML with a fault that names the line, the found and the allowed values, and for a misspelt name the nearest one.

use crate::spelling::nearest;
use serde::de::DeserializeOwned;

/// What is wrong in a TOML text.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct TomlFault {
    /// Line, from 1.
    pub(crate) line: usize,
    /// What was found and what is allowed.
    pub(crate) message: String,
    /// The nearest known name, if one was misspelt.
    pub(crate) nearest: Option<String>,
}

/// Reads TOML.
///
/// # Errors
/// The text is not valid TOML of this form.
pub(crate) fn toml_text<T: DeserializeOwned>(text: &str) -> Result<T, TomlFault> {
    toml::from_str(text).map_err(|error| {
        let line = error.span().map_or(1, |span| 1 + text[..span.start.min(text.len())].matches('\n').count());
        let message = error.message().to_owned();
        // serde's wording: unknown field `x`, expected one of `a`, `b`
        let mut names = message.split('`').skip(1).step_by(2);
        let nearest =
            if message.starts_with("unknown ") { names.next().and_then(|found| nearest(found, names)).map(str::to_owned) } else { None };
        TomlFault { line, message, nearest }
    })
}
