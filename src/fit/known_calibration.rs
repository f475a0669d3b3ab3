//! Delays and encoder calibration known before a fit, from a fit of other runs of the same logs: the runs at other wheel angles.

use crate::fit::drive_form::drive_model::DriveModel;
use std::collections::BTreeMap;

/// Values that the estimator holds instead of estimating them.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct KnownCalibration {
    /// Dead time [s] of logs, by their SHA-256.
    pub dead_time_s: BTreeMap<String, f64>,
    /// The drive.
    pub(crate) drive: Option<DriveModel>,
    /// The encoder's scale, and how much later it reads than the yaw rate [s].
    pub encoder: Option<(f64, f64)>,
}
