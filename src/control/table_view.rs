//! Table 2 as the controller reads it: three slices, in read-only memory or borrowed from whoever holds the table.

use crate::lookup;

/// τ(v, a) [N·m] in the gear's frame, borrowed. Slices that do not fit together have no answer anywhere.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TableView<'a> {
    /// Speed breaks [m/s], rising: the rows.
    pub speed_mps: &'a [f64],
    /// Breaks of the desired acceleration [m/s²], rising: the columns.
    pub accel_mps2: &'a [f64],
    /// Torques [N·m], row-major by speed.
    pub torque_nm: &'a [f64],
}

impl TableView<'_> {
    /// Torque [N·m] by bilinear interpolation; `None` outside the axes and for NaN.
    pub fn torque(&self, speed_mps: f64, accel_mps2: f64) -> Option<f64> {
        lookup::bilinear(self.speed_mps, self.accel_mps2, self.torque_nm, speed_mps, accel_mps2)
    }

    /// The same with speed and acceleration clamped to the axes; `None` only for NaN.
    pub fn torque_clamped(&self, speed_mps: f64, accel_mps2: f64) -> Option<f64> {
        lookup::bilinear_clamped(self.speed_mps, self.accel_mps2, self.torque_nm, speed_mps, accel_mps2)
    }
}
