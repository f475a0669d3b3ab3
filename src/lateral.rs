//! Lateral error compensation, the calibration: logs with known compensation angles → which mean lateral error an angle adds.
//!
//! In: [`Recording`](crate::log::Recording)s of one task, read by [`crate::log::read_lateral`], one without compensation and the others with one
//! angle each. Out: a [`LateralTableFile`](crate::map::LateralTableFile) and a [`LateralReport`]. The law that uses it at run time is
//! [`crate::control::lateral_compensation`].

mod bins;
mod error;
mod fit;
mod isotonic;
mod nearest;
mod newey_west;
mod settings;

pub use bins::{Bin, CompensationRun};
pub use error::{Error, Result};
pub use fit::{LateralReport, fit};
pub use isotonic::isotonic;
pub use newey_west::{Mean, newey_west};
pub use settings::{LateralFitSettings, Weighting};
