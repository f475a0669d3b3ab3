//! Gains and preview for one map and vehicle, found on the plant that Table 1 identified and on its perturbations.
//!
//! In: [`Maps`](crate::verify::Maps) and [`TuneSettings`]. Out: [`Tuning`], the settings of a controller with the margins of every limit, or the
//! reason why none keeps the gate. Each candidate drives the pivots of `verify` with the same draws; the one that is wanted keeps every
//! limit with a reserve, and is the fastest of those.

mod knob;
mod limit_margin;
mod loop_margins;
mod search;
mod settings;
mod trial;
mod tuning;

pub(crate) use limit_margin::LimitMargin;
pub(crate) use search::tune;
pub(crate) use settings::{PlanFreedom, TuneSettings};
pub(crate) use tuning::{SettingChange, Tuning};
