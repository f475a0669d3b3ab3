//! What can go wrong in the world, injected while it runs.

/// A fault or a disturbance; it lasts until its opposite or [`Fault::Cleared`] is injected.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Fault {
    /// All well again: every fault below ends.
    Cleared,
    /// The steering stays where it is.
    SteeringStuck,
    /// The steering's rate limit is multiplied by this factor.
    SteeringSlow {
        /// 0 to 1.
        rate_factor: f64,
    },
    /// The steering angle sensor reads this much too far left.
    SteeringOffset {
        /// Offset [rad]; some radians make the reading implausible.
        offset_rad: f64,
    },
    /// The speed sensor gives no reading any more.
    SpeedSensorLost,
    /// The floor slopes.
    Slope {
        /// Angle of the slope [rad].
        grade_rad: f64,
        /// Heading in which it goes up [rad].
        uphill_heading_rad: f64,
    },
    /// The floor takes no more torque than this; beyond it the wheel slips.
    WetFloor {
        /// Grip [N·m] at the wheel.
        grip_nm: f64,
    },
    /// Somebody or something pushes along the wheel's plane.
    Push {
        /// Force at the wheel [N], + forward.
        force_n: f64,
    },
    /// The drive gives no more torque than this: a low battery.
    TorqueLimit {
        /// Limit [N·m].
        limit_nm: f64,
    },
}
