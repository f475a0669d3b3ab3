//! What is known about one cell of a table.

use serde::{Deserialize, Serialize};
use std::fmt;

/// Where a cell's value comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum CellStatus {
    /// Samples of the log lie around the cell.
    Measured,
    /// No sample near enough, but measured cells on both sides.
    Interpolated,
    /// Beyond what was measured: an informed guess.
    Extrapolated,
    /// No torque within the limits gives this acceleration; the value is the nearest torque that can be given (Table 2 only).
    Unreachable,
}

impl fmt::Display for CellStatus {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Measured => "measured",
            Self::Interpolated => "interpolated",
            Self::Extrapolated => "extrapolated",
            Self::Unreachable => "unreachable",
        })
    }
}
