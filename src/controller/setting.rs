//! One setting of a controller file: its key, its value, its range, and what it means.

use crate::controller::or_word::{Or, Word};
use std::ops::RangeInclusive;

/// A value as it is written.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Shown {
    /// A number.
    Number(f64),
    /// A word, without quotation marks.
    Word(&'static str),
}

impl std::fmt::Display for Shown {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Number(value) => write!(f, "{value:?}"),
            Self::Word(word) => write!(f, "\"{word}\""),
        }
    }
}

/// A type that a setting may have.
pub(crate) trait Settable: Copy {
    /// The words that are allowed, beside numbers if there are some.
    const WORDS: &'static [&'static str];

    /// The value as it is written.
    fn shown(self) -> Shown;
}

impl Settable for f64 {
    const WORDS: &'static [&'static str] = &[];

    fn shown(self) -> Shown {
        Shown::Number(self)
    }
}

impl<W: Word> Settable for Or<W> {
    const WORDS: &'static [&'static str] = &[W::WORD];

    fn shown(self) -> Shown {
        self.value().map_or(Shown::Word(W::WORD), Shown::Number)
    }
}

/// One setting.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Setting {
    /// Its key in its section.
    pub(crate) key: &'static str,
    /// Its meaning, with the unit.
    pub(crate) about: &'static str,
    /// Its value.
    pub(crate) value: Shown,
    /// The words that are allowed.
    pub(crate) words: &'static [&'static str],
    /// The numbers that are allowed; `None` if only words are.
    pub(crate) range: Option<RangeInclusive<f64>>,
}

impl Setting {
    /// A setting that is a number, or a number or a word.
    pub(crate) fn number<T: Settable>(key: &'static str, value: T, range: RangeInclusive<f64>, about: &'static str) -> Self {
        Self { key, about, value: value.shown(), words: T::WORDS, range: Some(range) }
    }

    /// A setting that is a word.
    pub(crate) fn word<T: Settable>(key: &'static str, value: T, about: &'static str) -> Self {
        Self { key, about, value: value.shown(), words: T::WORDS, range: None }
    }

    /// The allowed values, in words.
    pub(crate) fn allowed(&self) -> String {
        let words = self.words.iter().map(|word| format!("\"{word}\""));
        let numbers = self.range.as_ref().map(|range| format!("{} to {}", range.start(), range.end()));
        words.chain(numbers).collect::<Vec<_>>().join(", ")
    }

    /// The number, if it is out of its range.
    pub(crate) fn outside(&self) -> Option<f64> {
        match (self.value, &self.range) {
            (Shown::Number(value), Some(range)) if !range.contains(&value) => Some(value),
            _ => None,
        }
    }
}
