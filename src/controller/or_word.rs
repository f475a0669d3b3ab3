//! A number of a controller file, or a word in its place: `off`, `coast`, or where the value comes from.

use serde::de::{self, Deserialize, Deserializer, Visitor};
use serde::{Serialize, Serializer};
use std::fmt;
use std::marker::PhantomData;

/// A word that may stand in place of a number.
pub(crate) trait Word: Copy + fmt::Debug + PartialEq {
    /// The word.
    const WORD: &'static str;
}

/// Nothing is added.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Off;

/// No torque.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Coast;

/// The value is that of the map.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct OfMap;

/// The value is the mirror of another.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Mirrored;

/// The value follows from the vehicle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct OfVehicle;

impl Word for Off {
    const WORD: &'static str = "off";
}

impl Word for Coast {
    const WORD: &'static str = "coast";
}

impl Word for OfMap {
    const WORD: &'static str = "map";
}

impl Word for Mirrored {
    const WORD: &'static str = "mirror";
}

impl Word for OfVehicle {
    const WORD: &'static str = "vehicle";
}

/// A number, or the word `W`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Or<W> {
    value: Option<f64>,
    word: PhantomData<W>,
}

impl<W: Word> Or<W> {
    /// A number.
    pub(crate) const fn number(value: f64) -> Self {
        Self { value: Some(value), word: PhantomData }
    }

    /// The word.
    pub(crate) const fn word() -> Self {
        Self { value: None, word: PhantomData }
    }

    /// The number; `None` for the word.
    pub(crate) fn value(self) -> Option<f64> {
        self.value
    }
}

impl<W: Word> Serialize for Or<W> {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        match self.value {
            Some(value) => to.serialize_f64(value),
            None => to.serialize_str(W::WORD),
        }
    }
}

impl<'de, W: Word> Deserialize<'de> for Or<W> {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        struct Either<W>(PhantomData<W>);

        impl<W: Word> Visitor<'_> for Either<W> {
            type Value = Or<W>;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                write!(f, "a number or \"{}\"", W::WORD)
            }

            fn visit_f64<E: de::Error>(self, value: f64) -> Result<Or<W>, E> {
                Ok(Or::number(value))
            }

            fn visit_i64<E: de::Error>(self, value: i64) -> Result<Or<W>, E> {
                Ok(Or::number(value as f64))
            }

            fn visit_u64<E: de::Error>(self, value: u64) -> Result<Or<W>, E> {
                Ok(Or::number(value as f64))
            }

            fn visit_str<E: de::Error>(self, text: &str) -> Result<Or<W>, E> {
                if text == W::WORD { Ok(Or::word()) } else { Err(E::invalid_value(de::Unexpected::Str(text), &self)) }
            }
        }
        from.deserialize_any(Either(PhantomData))
    }
}
