//! The ranges of a scene's numbers, and the check against them.

use crate::map::toml_line;
use crate::scene::{Error, Result};

/// One number of a section with its range.
pub(crate) struct Ranged {
    /// Its key in the section.
    pub(crate) key: &'static str,
    /// Its value.
    pub(crate) value: f64,
    /// Lowest and highest allowed value.
    pub(crate) range: [f64; 2],
}

/// A number with its range.
pub(crate) fn ranged(key: &'static str, value: f64, low: f64, high: f64) -> Ranged {
    Ranged { key, value, range: [low, high] }
}

/// Checks the numbers of the `nth` section of this name, from 0, in a text.
///
/// # Errors
/// The first number out of its range, with its line.
pub(crate) fn check(text: &str, (section, nth): (&str, usize), numbers: &[Ranged]) -> Result<()> {
    match numbers.iter().find(|n| !(n.range[0]..=n.range[1]).contains(&n.value)) {
        Some(Ranged { key, value, range: [low, high] }) => Err(Error::Range {
            line: toml_line(text, (section, nth), key),
            key: format!("{section}.{key}"),
            found: *value,
            allowed: format!("{low} to {high}"),
        }),
        None => Ok(()),
    }
}

/// Checks a range that is itself a setting, each end within `low` to `high`.
///
/// # Errors
/// An end out of its range, or the ends in the wrong order.
pub(crate) fn check_pair(text: &str, section: &'static str, key: &'static str, pair: [f64; 2], [low, high]: [f64; 2]) -> Result<()> {
    check(text, (section, 0), &pair.map(|value| ranged(key, value, low, high)))?;
    if pair[0] > pair[1] {
        let line = toml_line(text, (section, 0), key);
        return Err(Error::Order { line, key: format!("{section}.{key}"), low: pair[0], high: pair[1] });
    }
    Ok(())
}
