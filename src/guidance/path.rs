//! The path of a manoeuvre: poses of the rear axle's middle in the order of travel.

use crate::map::Gear;
use serde::Serialize;

/// A pose of a path with its curvature, wheel angle, gear and distance.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct PathPose {
    /// East of the origin [m], middle of the rear axle.
    pub x_m: f64,
    /// North of the origin [m], middle of the rear axle.
    pub y_m: f64,
    /// Heading of the vehicle [rad], counter-clockwise, whatever the direction of travel.
    pub heading_rad: f64,
    /// tan δ/L [1/m]: heading over distance when driven forward, left positive. In reverse the heading changes by −κ per metre travelled.
    pub curvature_per_m: f64,
    /// Front-wheel angle that belongs to it [rad], left positive.
    pub wheel_angle_rad: f64,
    /// Direction of travel from here to the next pose; the last pose has that of the previous one.
    pub direction: Gear,
    /// Distance travelled by the rear axle's middle from the start [m]; it grows in reverse too.
    pub s_m: f64,
}

/// A whole path.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct PosePath {
    /// The poses in the order of travel.
    pub poses: Vec<PathPose>,
}

impl PosePath {
    /// Distance travelled from the first to the last pose [m].
    pub fn length_m(&self) -> f64 {
        self.poses.last().map_or(0.0, |last| last.s_m - self.poses[0].s_m)
    }
}
