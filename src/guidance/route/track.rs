//! The inputs of a tracking law in a control period, and the limits of the vehicle's wheel.

use crate::control::Pose;
use crate::control::numeric::{sin_cos, wrapped};
use crate::guidance::route::path_position::{Leg, Matched, Offset};
use crate::map::Gear;
use serde::Serialize;

/// One period in the travel frame.
#[derive(Debug, Clone, Copy)]
pub(crate) struct TrackState<'a> {
    /// The leg that is tracked.
    pub leg: Leg<'a>,
    /// Pose of the rear axle's middle in the travel frame.
    pub pose: Pose,
    /// Nearest point of the path.
    pub matched: Matched,
    /// Piece of the leg that contains it.
    pub index: usize,
    /// Offset from it.
    pub offset: Offset,
    /// Speed of the rear axle's middle along the travel [m/s], not negative.
    pub speed_mps: f64,
    /// Measured wheel angle in the travel frame [rad].
    pub wheel_angle_rad: f64,
    /// Wheelbase [m].
    pub wheelbase_m: f64,
    /// Largest wheel angle that may be commanded [rad].
    pub max_wheel_rad: f64,
}

impl<'a> TrackState<'a> {
    /// The state of a vehicle at `pose` with front-wheel speed [m/s] and angle [rad] in the vehicle's frame; `hint` is its last piece.
    pub(crate) fn new(leg: Leg<'a>, pose: Pose, hint: usize, front_speed_mps: f64, wheel_angle_rad: f64, limits: &Limits) -> Self {
        let (matched, index) = leg.nearest(pose.x_m, pose.y_m, hint);
        let travel = leg.travel_pose(pose);
        let sign = leg.gear().sign();
        let speed_mps = (sign * front_speed_mps * sin_cos(wheel_angle_rad).1).max(0.0);
        Self {
            leg,
            pose: travel,
            matched,
            index,
            offset: Offset::new(travel, &matched),
            speed_mps: if speed_mps.is_finite() { speed_mps } else { 0.0 },
            wheel_angle_rad: sign * wheel_angle_rad,
            wheelbase_m: limits.wheelbase_m,
            max_wheel_rad: limits.max_wheel_rad,
        }
    }

    /// Offset of the front axle from the point of the path nearest to it.
    pub(crate) fn front_offset(&self) -> Offset {
        let (sin, cos) = sin_cos(self.pose.heading_rad);
        let front = Pose {
            x_m: self.pose.x_m + self.wheelbase_m * cos,
            y_m: self.pose.y_m + self.wheelbase_m * sin,
            heading_rad: self.pose.heading_rad,
        };
        let (matched, _) = self.leg.nearest(front.x_m, front.y_m, self.index);
        Offset { heading_rad: wrapped(front.heading_rad - matched.course_rad), ..Offset::new(front, &matched) }
    }

    /// Whether the vehicle drives backward.
    pub(crate) fn is_reverse(&self) -> bool {
        self.leg.gear() == Gear::Reverse
    }
}

/// A tracking law.
pub(crate) trait Law: std::fmt::Debug {
    /// Desired front-wheel angle [rad] in the travel frame, not limited; not finite if the numbers give none.
    fn wheel_angle_rad(&mut self, track: &TrackState<'_>) -> f64;

    /// Resets the law's state. Most laws have none.
    fn forget(&mut self) {}
}

/// Data of the vehicle that a law needs.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub(crate) struct Limits {
    /// Wheelbase [m].
    pub wheelbase_m: f64,
    /// Largest wheel angle that may be commanded while tracking [rad]. Default 1.2 (69°).
    pub max_wheel_rad: f64,
    /// Control period [s]. Default 0.02.
    pub period_s: f64,
}

impl Limits {
    /// The defaults for a wheelbase [m].
    pub(crate) fn new(wheelbase_m: f64) -> Self {
        Self { wheelbase_m, max_wheel_rad: 1.2, period_s: 0.02 }
    }
}

#[cfg(test)]
pub(crate) mod example {
    //! A vehicle beside a path, for the tests of the laws.
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::guidance::PosePath;

    pub(crate) const WHEELBASE_M: f64 = 0.9;

    /// The state of a vehicle with its wheel straight.
    pub(crate) fn state(path: &PosePath, x_m: f64, y_m: f64, heading_rad: f64, speed_mps: f64) -> TrackState<'_> {
        TrackState::new(Leg::first(&path.poses).unwrap(), Pose { x_m, y_m, heading_rad }, 0, speed_mps, 0.0, &Limits::new(WHEELBASE_M))
    }
}
