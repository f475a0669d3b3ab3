//! Tolerances of the parked pose.

use crate::guidance::Result;
use crate::guidance::body::within;
use serde::Serialize;

/// Tolerances of the parked pose.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub(crate) struct Tolerance {
    /// Distance from the goal [m]. Default 0.05.
    pub position_m: f64,
    /// Heading error [rad]. Default 1°.
    pub heading_rad: f64,
    /// Least distance of the body from an obstacle [m]. Default 0.1: half of the safety distance remains for the drive.
    pub clearance_m: f64,
}

impl Default for Tolerance {
    fn default() -> Self {
        Self { position_m: 0.05, heading_rad: 1.0_f64.to_radians(), clearance_m: 0.1 }
    }
}

impl Tolerance {
    /// Checks every number.
    ///
    /// # Errors
    /// The first out of its range.
    pub(crate) fn checked(self) -> Result<Self> {
        within("tolerance.position_m", self.position_m, 1e-3, 1.0, "0.001 to 1")?;
        within("tolerance.heading_rad", self.heading_rad, 1e-4, 0.5, "0.0001 to 0.5")?;
        within("tolerance.clearance_m", self.clearance_m, 0.0, 5.0, "0 to 5").map(|()| self)
    }
}
