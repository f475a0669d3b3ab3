//! Settings of making a map.

use crate::controller::ControllerFile;
use crate::fit::FitSettings;
use crate::invert::InvertSettings;
use crate::log::{Source, VehicleOverrides};

/// Settings of making a map from logs. The defaults are those of `pivot-cal calibrate`.
#[derive(Debug, Clone, Default)]
pub struct CalibrateSettings {
    /// Settings of reading and fitting logs.
    pub fit: FitStage,
    /// Settings of inverting Table 1.
    pub invert: InvertStage,
    /// Names of checks whose objections a person overrules. Default none.
    pub accept: Vec<String>,
    /// Settings of the controller that drives in the verdict. Default `data/controllers/default.toml`.
    pub controller: Option<ControllerFile>,
}

/// Sources of the signals and of the vehicle's data.
#[derive(Debug, Clone)]
pub struct LogSource {
    /// Places of the signals. Default: they are detected.
    pub signals: Source,
    /// Known data of the vehicle; they override logs and signal map. Default none.
    pub vehicle: VehicleOverrides,
}

impl Default for LogSource {
    fn default() -> Self {
        Self { signals: Source::Detect, vehicle: VehicleOverrides::default() }
    }
}

/// Settings of reading and fitting logs.
#[derive(Debug, Clone, Default)]
pub struct FitStage {
    /// Sources of the signals and of the vehicle's data.
    pub source: LogSource,
    /// Wheel angles whose runs are used [°]; by default all at which at least three torques were held.
    pub wheel_angles_deg: Vec<f64>,
    /// Settings of the estimator.
    pub settings: FitSettings,
}

/// Settings of inverting Table 1.
#[derive(Debug, Clone, Default)]
pub struct InvertStage {
    /// Wheel angles whose maps are inverted [°]; by default all of them.
    pub wheel_angles_deg: Vec<f64>,
    /// Settings of the inversion.
    pub settings: InvertSettings,
    /// Whether a CSV that is not the one that `table1.json` describes is accepted. Default no.
    pub force: bool,
}
