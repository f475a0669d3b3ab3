//! TOML with a fault that names the line, the found and the allowed values, and for a misspelt name the nearest one; and the line of a key.

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

/// The line of a key in the `nth` section of this name, from 0, counted from 1; `None` if it is written in another way. The keys before any
/// section have the name "".
pub(crate) fn toml_line(text: &str, (section, nth): (&str, usize), key: &str) -> Option<usize> {
    let (mut current, mut count) = ("", 0);
    for (k, line) in text.lines().enumerate() {
        let line = line.trim();
        if let Some(name) = line.strip_prefix('[').and_then(|rest| rest.trim_start_matches('[').split(']').next()) {
            current = name.trim();
            count += usize::from(current == section);
        }
        let is_key = line.split_once('=').is_some_and(|(name, _)| name.trim() == key);
        let is_section = current == section && (section.is_empty() || count == nth + 1);
        if is_section && is_key {
            return Some(k + 1);
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_key_is_found_in_its_section_and_in_the_one_of_several() {
        let text = "a = 1\n[s]\na = 2\n[[t]]\na = 3\n[[ t ]]\n b = 4 # a = 5\na = 6\n";
        let lines = [("", 0), ("s", 0), ("t", 0), ("t", 1), ("t", 2)].map(|section| toml_line(text, section, "a"));
        assert_eq!(lines, [Some(1), Some(3), Some(5), Some(8), None]);
    }
}
