//! The columns of a table that are no signals, as a signal map may name them: `[columns]`.

use crate::log::{Error, Result};
use crate::units::{Dimension, NS_PER_S, Unit};
use serde::Deserialize;

/// Which columns hold time, signal name and value. What is not named is found in the header.
#[derive(Debug, Clone, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct TableColumns {
    /// The column of the times.
    pub time: Option<String>,
    /// Unit of the times if they are numbers: s, ms, us or ns.
    pub time_unit: Option<String>,
    /// In long form, the column of the signals' names.
    pub name: Option<String>,
    /// In long form, the column of the values.
    pub value: Option<String>,
}

impl TableColumns {
    /// The keys in a signal map.
    pub(crate) const KEYS: [&'static str; 4] = ["time", "time_unit", "name", "value"];

    /// Nanoseconds in one unit of time, if the unit is given.
    ///
    /// # Errors
    /// It is not a unit of time.
    pub(crate) fn time_scale(&self) -> Result<Option<i64>> {
        let Some(text) = &self.time_unit else { return Ok(None) };
        match text.parse::<Unit>().ok().and_then(ns_per_unit) {
            Some(scale) => Ok(Some(scale)),
            None => Err(Error::TimeUnit { found: text.clone() }),
        }
    }
}

/// Nanoseconds in one unit, if it is a unit of time.
pub(crate) fn ns_per_unit(unit: Unit) -> Option<i64> {
    (unit.dimension() == Dimension::Time).then(|| (unit.factor() * NS_PER_S).round() as i64)
}
