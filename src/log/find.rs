//! Finds the message path of each signal: by signal map, by preset, or by type, name and unit.

pub(crate) mod candidates;
pub(crate) mod detect;
pub(crate) mod infer_units;
mod named_stamp;
pub(crate) mod presets;
pub(crate) mod resolve;
pub(crate) mod series;
