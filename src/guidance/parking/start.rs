//! The start of parking.

use serde::Serialize;

/// Start of parking: pose of the rear axle's middle.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub(crate) struct ParkingStart {
    /// Along the row [m].
    pub x_m: f64,
    /// Away from the row's edge [m].
    pub y_m: f64,
    /// Heading [rad]; 0 along the row, the slot to the right.
    pub heading_rad: f64,
    /// Wheel angle [rad].
    pub wheel_angle_rad: f64,
}
