//! Settings of the lateral fit.

use serde::Serialize;

/// Over what a mean is taken.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Weighting {
    /// The way: every piece of it counts alike, however long it took.
    Distance,
    /// The control periods: every reading counts alike.
    Periods,
}

/// Settings of the fit.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct LateralFitSettings {
    /// Entries at or beyond this are dropped [m]. Default 0.3: further out the tracking law is at its limits.
    pub threshold_m: f64,
    /// Over what means are taken. Default the way.
    pub weighting: Weighting,
    /// Length of a piece of the way [m]. Default 0.5.
    pub piece_m: f64,
    /// Way after every start that is left out [m]. Default 4.
    pub settle_m: f64,
    /// Shortest way that may remain [m]. Default 10.
    pub least_m: f64,
    /// How much the ways of two runs of one task may differ, as a share. Default 0.05.
    pub same_task: f64,
}

impl Default for LateralFitSettings {
    fn default() -> Self {
        Self { threshold_m: 0.3, weighting: Weighting::Distance, piece_m: 0.5, settle_m: 4.0, least_m: 10.0, same_task: 0.05 }
    }
}
