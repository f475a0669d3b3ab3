//! From surveyed logs to Table 1.
//!
//! In: [`Survey`](crate::campaign::Survey)s of the logs of one vehicle. Out: a [`Fit`]: `table1.json` and its CSVs, and the final verdict on
//! every sample. The method is a prediction-error identification: the speed is integrated, never differentiated; what is random is
//! whitened by a Kalman filter; the surface a(v, τ) is a penalised lattice whose smoothness the data choose; dead time and lag are
//! estimated with it. A drive that a lag does not explain is followed by its torque feedback instead.

pub(crate) mod angles;
pub(crate) mod calibration;
pub(crate) mod drive;
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

pub use angles::{Fit, fit, fit_angles, fit_traced};
pub use error::{Error, Result};
pub use known_calibration::KnownCalibration;
pub use settings::FitSettings;
