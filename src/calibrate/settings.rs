//! How a map is made.

use crate::fit::FitSettings;
use crate::invert::InvertSettings;
use crate::log::{Source, VehicleOverrides};

/// How a map is made from logs. The defaults are those of `pivot-cal calibrate`.
#[derive(Debug, Clone, Default)]
pub struct CalibrateSettings {
    /// How logs are read and fitted.
    pub fit: FitStage,
    /// How Table 1 is inverted.
    pub invert: InvertStage,
}

/// Where signals and vehicle come from.
#[derive(Debug, Clone)]
pub struct LogSource {
    /// Where the signals are. Default: they are detected.
    pub signals: Source,
    /// What is known of the vehicle, over what logs and signal map say. Default nothing.
    pub vehicle: VehicleOverrides,
}

impl Default for LogSource {
    fn default() -> Self {
        Self { signals: Source::Detect, vehicle: VehicleOverrides::default() }
    }
}

/// How logs are read and fitted.
#[derive(Debug, Clone, Default)]
pub struct FitStage {
    /// Where signals and vehicle come from.
    pub source: LogSource,
    /// Wheel angles whose runs are used [°]; by default all at which at least three torques were held.
    pub wheel_angles_deg: Vec<f64>,
    /// Settings of the estimator.
    pub settings: FitSettings,
}

/// How Table 1 is inverted.
#[derive(Debug, Clone, Default)]
pub struct InvertStage {
    /// Wheel angles whose maps are inverted [°]; by default all of them.
    pub wheel_angles_deg: Vec<f64>,
    /// Settings of the inversion.
    pub settings: InvertSettings,
    /// Whether a CSV that is not the one that `table1.json` describes is let pass. Default no.
    pub force: bool,
}
