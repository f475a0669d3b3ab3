//! Settings of the lateral fit.

use serde::Serialize;

/// Weighting of means.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Weighting {
    /// By distance: all pieces of the path have the same weight, for any duration.
    Distance,
    /// By control periods: all readings have the same weight.
    Periods,
}

/// Settings of the fit.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub(crate) struct LateralFitSettings {
    /// Entries at or beyond this are dropped [m]. Default 0.3: at larger errors the tracking law is at its limits.
    pub threshold_m: f64,
    /// Weighting of means. Default: by distance.
    pub weighting: Weighting,
    /// Length of a piece of the path [m]. Default 0.5.
    pub piece_m: f64,
    /// Skipped distance after every start [m]. Default 4.
    pub settle_m: f64,
    /// Shortest remaining distance [m]. Default 10.
    pub least_m: f64,
    /// Largest difference between the distances of two runs of one task, as a share. Default 0.05.
    pub same_task: f64,
}

impl Default for LateralFitSettings {
    fn default() -> Self {
        Self { threshold_m: 0.3, weighting: Weighting::Distance, piece_m: 0.5, settle_m: 4.0, least_m: 10.0, same_task: 0.05 }
    }
}
