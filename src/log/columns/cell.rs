//! One cell of a table, and the numbers that are written in text.

use std::borrow::Cow;

/// What a cell holds.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum TableCell<'a> {
    /// No new value.
    Empty,
    Number(f64),
    Integer(i64),
    /// A time with its own unit [ns since 1970].
    Instant(i64),
    Text(Cow<'a, str>),
}

impl TableCell<'_> {
    /// The number, also one that is written as text. A word for "no value", such as `nan` or `null`, is none.
    pub(crate) fn number(&self) -> Option<f64> {
        match self {
            Self::Number(value) => Some(*value),
            Self::Integer(value) => Some(*value as f64),
            Self::Text(text) => number(text),
            Self::Empty | Self::Instant(_) => None,
        }
    }

    /// Whether the cell says that there is no value. NaN says so too: programs that have no holes write it in their place.
    pub(crate) fn is_hole(&self) -> bool {
        const WORDS: [&str; 9] = ["", "nan", "na", "n/a", "#n/a", "null", "none", "nat", "-"];
        match self {
            Self::Empty => true,
            Self::Number(value) => value.is_nan(),
            Self::Text(text) => WORDS.iter().any(|word| text.trim().eq_ignore_ascii_case(word)),
            Self::Integer(_) | Self::Instant(_) => false,
        }
    }

    /// The cell as it is shown.
    pub(crate) fn shown(&self) -> String {
        match self {
            Self::Empty => String::new(),
            Self::Number(value) => value.to_string(),
            Self::Integer(value) | Self::Instant(value) => value.to_string(),
            Self::Text(text) => crate::text::name_from_outside(text).into_owned(),
        }
    }
}

/// A number with a decimal point or, without any point, with a decimal comma.
pub(crate) fn number(text: &str) -> Option<f64> {
    let text = text.trim();
    text.parse().ok().or_else(|| with_point(text)?.parse().ok())
}

/// The text with its only comma as a point.
pub(crate) fn with_point(text: &str) -> Option<String> {
    (!text.contains('.') && text.matches(',').count() == 1).then(|| text.replace(',', "."))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_a_point_or_a_comma_but_not_both() {
        assert_eq!([" 1.5", "1,5", "-2e3", "1.234,5", "1,2,3", ""].map(number), [Some(1.5), Some(1.5), Some(-2000.0), None, None, None]);
    }

    #[test]
    fn words_for_no_value_and_nan_are_holes_and_infinity_is_not() {
        for word in ["", "NaN", "null", "N/A"] {
            assert!(TableCell::Text(word.into()).is_hole(), "{word}");
        }
        assert!(
            TableCell::Number(f64::NAN).is_hole() && !TableCell::Number(f64::INFINITY).is_hole() && !TableCell::Text("0".into()).is_hole()
        );
    }
}
