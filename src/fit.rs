//! From surveyed logs to Table 1.
//!
//! In: [`Survey`](crate::campaign::Survey)s of the logs of one vehicle. Out: a [`Fit`]: `table1.json` and its CSVs, and the final verdict
//! on every sample. The method is a prediction-error identification. The speed is integrated, never differentiated. A Kalman filter whitens
//! the random part. The surface a(v, τ) is a penalised lattice whose smoothness the data choose; dead time and lag are estimated with it.
//! If a lag does not explain the drive, the fit uses its torque feedback instead.

pub(crate) mod angles;
pub(crate) mod calibration;
pub(crate) mod drive;
pub(crate) mod drive_form;
mod error;
mod known_calibration;
pub(crate) mod motion;
pub(crate) mod noise;
pub(crate) mod nuisance;
pub(crate) mod rounds;
mod settings;
pub(crate) mod solve;
pub(crate) mod surface;
pub(crate) mod table1;

pub(crate) use angles::fit_traced;
pub use angles::{Fit, fit, fit_angles};
pub use error::Error;
pub(crate) use error::Result;
pub(crate) use known_calibration::KnownCalibration;
pub use settings::{CampaignTime, FitSettings};
