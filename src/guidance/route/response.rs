//! How fast a vehicle answers a command: what the laws of a manoeuvre must know of the vehicle that they drive.

use serde::Serialize;

/// Dimensions and times of a vehicle.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub(crate) struct VehicleResponse {
    /// Wheelbase [m].
    pub wheelbase_m: f64,
    /// Dead time of the drive [s].
    pub dead_time_s: f64,
    /// Time constant of the drive's lag [s].
    pub lag_s: f64,
    /// Largest rate of the wheel angle [rad/s].
    pub steering_rate_rad_s: f64,
    /// Time constant of the steering near its target [s].
    pub steering_lag_s: f64,
}

/// Control period of every manoeuvre [s].
pub(crate) const PERIOD_S: f64 = 0.02;

impl VehicleResponse {
    /// Time from a torque command to its effect [s]: dead time, lag and one control period.
    pub(crate) fn reaction_s(&self) -> f64 {
        self.dead_time_s + self.lag_s + PERIOD_S
    }

    /// A vehicle of a wheelbase [m] as quick as the bundled scrubber, for tests.
    #[cfg(test)]
    pub(crate) fn quick(wheelbase_m: f64) -> Self {
        Self { wheelbase_m, dead_time_s: 0.05, lag_s: 0.05, steering_rate_rad_s: 1.0, steering_lag_s: 0.08 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_reaction_is_dead_time_lag_and_a_period() {
        assert!((VehicleResponse::quick(0.9).reaction_s() - 0.12).abs() < 1e-12);
    }
}
