//! Campaigns, logs, signal maps and command lines with one mistake each, and whether a verdict passes the wrong maps made from them.
//!
//! A [`mistakes::Mistake`] changes a good [`case::Case`]; the [`chain`] makes and judges its map as `calibrate` does; [`judge`] compares the
//! map with the exact one; the [`table`] counts.

#![allow(dead_code)] // the test and the example take what they need

pub(crate) mod campaign;
pub(crate) mod case;
pub(crate) mod chain;
pub(crate) mod good;
pub(crate) mod judge;
pub(crate) mod log;
pub(crate) mod mistakes;
pub(crate) mod table;
#[path = "../vehicle_text.rs"]
pub(crate) mod vehicle_text;
pub(crate) mod vehicles;

/// What may fail in making a case.
pub(crate) type Fallible<T> = Result<T, Box<dyn std::error::Error + Send + Sync>>;
