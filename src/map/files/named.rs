//! Values that a JSON file spells as text, from a list of allowed ones.
//!
//! Used as `#[serde(with = "named")]` on a field: the error for any other text gives the field and the allowed values, which serde's own
//! error for an unknown variant cannot.

use serde::{Deserialize, Deserializer, Serializer};

/// A value with a fixed text.
pub(crate) trait FixedText: Copy + PartialEq + 'static {
    /// The name of its field in errors.
    const FIELD: &'static str;
    /// Every value with its text.
    const NAMES: &'static [(Self, &'static str)];

    /// The text of the value.
    fn name(self) -> &'static str {
        Self::NAMES.iter().find(|(value, _)| *value == self).map_or("", |(_, name)| name)
    }

    /// The value of a text.
    ///
    /// # Errors
    /// A text that no value has; the message gives the field and the allowed texts.
    fn from_name(text: &str) -> Result<Self, String> {
        Self::NAMES.iter().find(|(_, name)| *name == text).map(|(value, _)| *value).ok_or_else(|| {
            let allowed: Vec<&str> = Self::NAMES.iter().map(|(_, name)| *name).collect();
            format!("{} is {text:?}; allowed: {}", Self::FIELD, allowed.join(", "))
        })
    }
}

pub(crate) fn serialize<T: FixedText, S: Serializer>(value: &T, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(value.name())
}

pub(crate) fn deserialize<'de, T: FixedText, D: Deserializer<'de>>(deserializer: D) -> Result<T, D::Error> {
    let text = String::deserialize(deserializer)?;
    T::from_name(&text).map_err(serde::de::Error::custom)
}
