//! What is known of delays and encoder before a fit begins, from a fit of other runs of the same logs: the runs at other wheel angles.

use crate::fit::motion::segment::{Calibration, LogData};
use std::collections::BTreeMap;

/// Values that the estimator holds instead of estimating them.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct KnownCalibration {
    /// Dead time [s] of logs, by their SHA-256.
    pub dead_time_s: BTreeMap<String, f64>,
    /// Time constant of the drive's lag [s].
    pub lag_s: Option<f64>,
    /// The encoder's scale, and how much later it reads than the yaw rate [s].
    pub encoder: Option<(f64, f64)>,
}

impl KnownCalibration {
    /// Puts the known values into `calibration`, whose logs are `logs`.
    pub(crate) fn hold(&self, calibration: &mut Calibration, logs: &[LogData]) {
        for (dead_time_s, log) in calibration.dead_time_s.iter_mut().zip(logs) {
            if let Some(known) = self.dead_time_s.get(&log.survey.track.source.sha256) {
                *dead_time_s = *known;
            }
        }
        if let Some(lag_s) = self.lag_s {
            calibration.lag_s = lag_s;
        }
        if let Some((scale, delay_s)) = self.encoder {
            calibration.encoder_scale = scale;
            calibration.encoder_delay_s = delay_s;
        }
    }
}
