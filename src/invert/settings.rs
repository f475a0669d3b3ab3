//! Settings of the inversion.

use crate::invert::raw::RawSettings;
use crate::map::ZeroRow;
use serde::{Deserialize, Serialize};

/// Settings of the inversion, with their defaults.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct InvertSettings {
    /// Speed breaks [m/s]; by default those of Table 1.
    pub speed_breaks_mps: Option<Vec<f64>>,
    /// Breaks of the desired acceleration [m/s²]; by default every 0.1 over the range of the tested torques, rounded outward.
    pub accel_breaks_mps2: Option<Vec<f64>>,
    /// Number of breaks of the speed axis and of the acceleration axis, to be placed where they reduce the error most, instead of evenly.
    pub place: Option<[usize; 2]>,
    /// Raw units of a controller that stores whole counts. Default none.
    #[serde(default, skip_serializing_if = "RawSettings::is_none")]
    pub raw: RawSettings,
    /// Values of the row at speed 0.
    pub zero_row: ZeroRow,
    /// Whether the table is exact at its nodes instead of best over the whole. Default false: exact nodes cost more than the estimation
    /// error.
    pub node_exact: bool,
}
