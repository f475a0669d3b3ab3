//! Calibration of the lateral error compensation: logs with known compensation angles → mean lateral error added by each angle.
//!
//! In: [`Recording`](crate::log::Recording)s of one task, read by [`crate::log::read_lateral`]: one without compensation and the others
//! with one angle each. Out: a [`LateralTableFile`](crate::map::LateralTableFile) and a [`LateralReport`]. The run-time law
//! [`crate::control::lateral_compensation`] uses the table.

mod bins;
mod error;
mod fit;
mod isotonic;
mod nearest;
mod newey_west;
mod settings;

pub(crate) use error::{Error, Result};
pub(crate) use fit::fit;
pub(crate) use settings::{LateralFitSettings, Weighting};
