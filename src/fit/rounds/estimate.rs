//! The estimate: speeds, torques and noise, surface and delays, each from the others, until the surface stands still.

use crate::fit::calibration::Calibration;
use crate::fit::drive::effective_torque::EffectiveTorque;
use crate::fit::motion::log_data::LogData;
use crate::fit::motion::lookup_speeds::Speeds;
use crate::fit::motion::segment::Segment;
use crate::fit::noise::kalman::Noise;
use crate::fit::rounds::cross_validation::Validation;
use crate::fit::solve::penalised_least_squares::System;
use crate::fit::solve::shrinkage::Stacked;
use crate::fit::surface::design::Design;
use crate::fit::surface::lattice::LatticeSurface;
use crate::map::Gear;

/// How sure the calibration is.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct CalibrationErrors {
    /// Standard error of each log's dead time [s].
    pub(crate) dead_time_s: Vec<f64>,
    /// Standard error of the lag [s].
    pub(crate) lag_s: f64,
    /// Standard error of the encoder's scale.
    pub(crate) encoder_scale: f64,
}

/// Everything that the estimator found out.
pub(crate) struct Estimate<'a> {
    pub(crate) logs: Vec<LogData<'a>>,
    pub(crate) design: Design,
    pub(crate) calibration: Calibration,
    pub(crate) calibration_errors: CalibrationErrors,
    pub(crate) noise: Noise,
    pub(crate) noise_bounds: Vec<&'static str>,
    pub(crate) gears: Vec<Gear>,
    pub(crate) surfaces: [LatticeSurface; 2],
    /// The physics form with a share of the surface.
    pub(crate) stacked: Stacked,
    pub(crate) system: System,
    pub(crate) segments: Vec<Segment>,
    /// Speeds along the segments, smoothed [m/s]: the best that is known of them.
    pub(crate) speeds: Vec<Vec<f64>>,
    /// The segments with merged readings, as they were fitted, and where the surface was looked up along them.
    pub(crate) fitted: (Vec<Segment>, Vec<Speeds>),
    /// Offset of each segment [m/s²].
    pub(crate) offsets: Vec<f64>,
    /// Whitened residuals of the segments.
    pub(crate) white: Vec<Vec<f64>>,
    pub(crate) transients: Vec<Vec<(f64, f64)>>,
    pub(crate) iterations: usize,
    pub(crate) converged: bool,
    pub(crate) has_yaw: bool,
    /// What runs left out say; absent with fewer than two runs.
    pub(crate) validation: Option<Validation>,
}

impl Estimate<'_> {
    /// The surface of a gear.
    pub(crate) fn surface(&self, gear: Gear) -> &LatticeSurface {
        &self.surfaces[usize::from(gear == Gear::Reverse)]
    }

    /// The effective torque of a log.
    pub(crate) fn lagged(&self, log: usize) -> EffectiveTorque {
        self.logs[log].torque(self.calibration.lag_s)
    }

    /// The effective torques of all logs.
    pub(crate) fn lagged_commands(&self) -> Vec<EffectiveTorque> {
        (0..self.logs.len()).map(|k| self.lagged(k)).collect()
    }
}
