//! Faults and disturbances of the world, injected while it runs.

/// A fault or a disturbance; it lasts until its opposite or [`Fault::Cleared`] is injected.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Fault {
    /// Ends every fault below.
    Cleared,
    /// The steering is stuck.
    SteeringStuck,
    /// The steering's rate limit is multiplied by this factor.
    SteeringSlow {
        /// 0 to 1.
        rate_factor: f64,
    },
    /// The steering angle sensor has an offset to the left.
    SteeringOffset {
        /// Offset [rad]; with some radians the reading is implausible.
        offset_rad: f64,
    },
    /// The speed sensor gives no more readings.
    SpeedSensorLost,
    /// The floor slopes.
    Slope {
        /// Angle of the slope [rad].
        grade_rad: f64,
        /// Uphill direction [rad].
        uphill_heading_rad: f64,
    },
    /// The torque that the floor transmits is limited; beyond the limit the wheel slips.
    WetFloor {
        /// Grip [N·m] at the wheel.
        grip_nm: f64,
    },
    /// A push along the wheel's plane.
    Push {
        /// Force at the wheel [N], + forward.
        force_n: f64,
    },
    /// The drive's torque is limited: a low battery.
    TorqueLimit {
        /// Limit [N·m].
        limit_nm: f64,
    },
}
