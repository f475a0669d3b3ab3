//! The vehicle's outline: a rectangle that moves with the middle of the rear axle.

use crate::guidance::geometry::{PlanePoint, Polygon};
use crate::guidance::path::PathPose;
use crate::guidance::{Error, Result};
use serde::Serialize;

/// Outline of the vehicle.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct BodyShape {
    /// Distance from the rear axle to the front wheel's centre [m].
    pub wheelbase_m: f64,
    /// Width [m].
    pub width_m: f64,
    /// Length before the front wheel's centre [m].
    pub front_overhang_m: f64,
    /// Length behind the rear axle [m].
    pub rear_overhang_m: f64,
}

impl BodyShape {
    /// Checks every length.
    ///
    /// # Errors
    /// The first that is not finite or out of its range.
    pub fn checked(self) -> Result<Self> {
        within("wheelbase_m", self.wheelbase_m, 0.1, 20.0, "0.1 to 20")?;
        within("width_m", self.width_m, 0.1, 5.0, "0.1 to 5")?;
        within("front_overhang_m", self.front_overhang_m, 0.0, 5.0, "0 to 5")?;
        within("rear_overhang_m", self.rear_overhang_m, 0.0, 5.0, "0 to 5").map(|()| self)
    }

    /// The usual outline for a wheelbase [m]: 0.8 of it wide, overhangs of 0.25 and 0.3 of it. A scrubber of wheelbase 0.9 m is 0.72 m wide and
    /// 1.4 m long.
    pub fn usual(wheelbase_m: f64) -> Self {
        Self { wheelbase_m, width_m: 0.8 * wheelbase_m, front_overhang_m: 0.25 * wheelbase_m, rear_overhang_m: 0.3 * wheelbase_m }
    }

    /// Overall length [m].
    pub fn length_m(&self) -> f64 {
        self.rear_overhang_m + self.wheelbase_m + self.front_overhang_m
    }

    /// The outline with the middle of the rear axle at (x, y) [m], heading θ [rad].
    pub fn at(&self, x_m: f64, y_m: f64, heading_rad: f64) -> Polygon {
        let (sin, cos) = heading_rad.sin_cos();
        let (front, rear, half) = (self.wheelbase_m + self.front_overhang_m, -self.rear_overhang_m, 0.5 * self.width_m);
        let corner = |u: f64, w: f64| PlanePoint::new(x_m + u * cos - w * sin, y_m + u * sin + w * cos);
        Polygon::trusted(vec![corner(front, half), corner(rear, half), corner(rear, -half), corner(front, -half)])
    }

    /// The outline at a pose of a path.
    pub fn at_pose(&self, pose: &PathPose) -> Polygon {
        self.at(pose.x_m, pose.y_m, pose.heading_rad)
    }
}

/// `value` within [low, high].
pub(crate) fn within(field: &'static str, value: f64, low: f64, high: f64, allowed: &'static str) -> Result<()> {
    if (low..=high).contains(&value) { Ok(()) } else { Err(Error::Setting { field, value, allowed }) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_outline_turns_with_the_heading_about_the_rear_axle() {
        let body = BodyShape { wheelbase_m: 1.0, width_m: 0.6, front_overhang_m: 0.2, rear_overhang_m: 0.3 };
        let corners = body.at(1.0, 2.0, std::f64::consts::FRAC_PI_2);
        let front_left = corners.corners()[0];
        assert!((front_left.x_m - 0.7).abs() < 1e-12 && (front_left.y_m - 3.2).abs() < 1e-12);
        assert!((body.length_m() - 1.5).abs() < 1e-12);
    }
}
