//! Effective torque at one moment, and its derivatives by dead time and drive.

use crate::fit::drive_form::parameters::PARAMETERS;

/// Effective torque and its derivatives at one moment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Torque {
    /// u [N·m].
    pub(crate) torque_nm: f64,
    /// ∂u/∂T_d [N·m/s].
    pub(crate) by_dead_time: f64,
    /// Derivatives by the parameters of the drive [N·m/s]; of a first-order lag, ∂u/∂T_c and zeros.
    pub(crate) by_drive: [f64; PARAMETERS],
}

impl Torque {
    /// A constant torque.
    pub(crate) fn constant(torque_nm: f64) -> Self {
        Self { torque_nm, by_dead_time: 0.0, by_drive: [0.0; PARAMETERS] }
    }

    /// In the frame of a gear, whose sign this is.
    pub(crate) fn in_gear(self, sign: f64) -> Self {
        Self { torque_nm: sign * self.torque_nm, by_dead_time: sign * self.by_dead_time, by_drive: self.by_drive.map(|d| sign * d) }
    }

    /// Whether delays and drive matter at this moment.
    pub(crate) fn is_moving(&self) -> bool {
        self.by_dead_time != 0.0 || self.by_drive != [0.0; PARAMETERS]
    }
}
