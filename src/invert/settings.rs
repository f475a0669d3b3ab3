//! Settings of the inversion.

use serde::{Deserialize, Serialize};

/// What the row at speed 0 holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ZeroRow {
    /// The torque that a wheel which has just begun to move needs, for every acceleration: interpolation between this row and the next is
    /// what a moving vehicle needs. The default.
    #[default]
    Moving,
    /// The same for a > 0, and 0 for a ≤ 0.
    Hold,
}

impl ZeroRow {
    /// `moving` or `hold`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Moving => "moving",
            Self::Hold => "hold",
        }
    }
}

/// Settings of the inversion, with their defaults.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Settings {
    /// Speed breaks [m/s]; by default those of Table 1.
    pub speed_breaks_mps: Option<Vec<f64>>,
    /// Breaks of the desired acceleration [m/s²]; by default every 0.1 over what the tested torques reach, rounded outward.
    pub accel_breaks_mps2: Option<Vec<f64>>,
    /// Places this many breaks on each axis where they serve best, instead of evenly.
    pub place: Option<usize>,
    /// What the row at speed 0 holds.
    pub zero_row: ZeroRow,
    /// Exact at the nodes instead of best over the whole. Default false: exact nodes cost more than the estimation error.
    pub node_exact: bool,
}
