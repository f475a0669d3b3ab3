//! What the units of a file may leave open.

/// What a file may not say itself.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct FullScale {
    /// Torque that is 100 % [N·m], if it is known.
    pub(crate) torque_nm: Option<f64>,
    /// Rolling radius of the wheel [m], for speeds of a turning wheel.
    pub(crate) wheel_radius_m: f64,
}
