//! Degrees.

/// Radians in one degree.
pub const RAD_PER_DEG: f64 = core::f64::consts::PI / 180.0;
