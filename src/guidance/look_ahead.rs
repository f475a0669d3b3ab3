//! The look-ahead window method: a path of continuous curvature along a [`ReferenceLine`], step by step.
//!
//! In each step the middle of the rear axle is projected onto the reference, in a window ahead of its last projection. The goal is the
//! look-ahead distance further along. The circle that is tangent to the vehicle at its rear axle and passes through the goal has
//!
//! ```text
//! κ = 2 y_g/(x_g² + y_g²)      δ = arctan(L κ)
//! ```
//!
//! (x_g, y_g) is the goal in the vehicle's frame; forward and reverse have the same circle. The wheel angle changes toward δ by at most a
//! given amount per step, within its limit. The vehicle moves one step of fixed length along its own circle.
//! Source: Coulter, *Implementation of the Pure Pursuit Path Tracking Algorithm* (CMU-RI-TR-92-01).

use crate::guidance::body::within;
use crate::guidance::geometry::PlanePoint;
use crate::guidance::path::{PathPose, PosePath};
use crate::guidance::reference::{ReferenceLine, ahead};
use crate::guidance::{Error, Result};
use crate::map::Gear;
use serde::Serialize;

/// Settings of following a reference.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub(crate) struct LookAhead {
    /// Length of a step of the rear axle [m]. Default 0.02.
    pub step_m: f64,
    /// Distance of the goal along the reference [m]. Default 0.35.
    pub distance_m: f64,
    /// Length of the search window ahead of the last match [m]. Default 0.5.
    pub window_m: f64,
    /// Largest change of the wheel angle per step [rad]. Default 3°: at 0.25 m/s and 0.02 m it is 37°/s, within a steering of 60°/s.
    pub wheel_step_rad: f64,
    /// Largest wheel angle in either direction [rad]. Default 70°.
    pub wheel_limit_rad: f64,
}

impl Default for LookAhead {
    fn default() -> Self {
        Self { step_m: 0.02, distance_m: 0.35, window_m: 0.5, wheel_step_rad: 3.0_f64.to_radians(), wheel_limit_rad: 70.0_f64.to_radians() }
    }
}

impl LookAhead {
    /// Checks every number.
    ///
    /// # Errors
    /// The first out of its range.
    pub(crate) fn checked(self) -> Result<Self> {
        within("look_ahead.step_m", self.step_m, 1e-3, 0.5, "0.001 to 0.5")?;
        within("look_ahead.distance_m", self.distance_m, self.step_m, 10.0, "step_m to 10")?;
        within("look_ahead.window_m", self.window_m, self.step_m, 10.0, "step_m to 10")?;
        within("look_ahead.wheel_step_rad", self.wheel_step_rad, 1e-4, 1.0, "0.0001 to 1")?;
        within("look_ahead.wheel_limit_rad", self.wheel_limit_rad, 0.02, 1.48, "0.02 to 1.48 (85°)").map(|()| self)
    }

    /// Largest change of the curvature per step [1/m]: that at the wheel limit, where the tangent is steepest.
    pub(crate) fn curvature_step_per_m(&self, wheelbase_m: f64) -> f64 {
        (self.wheel_limit_rad.tan() - (self.wheel_limit_rad - self.wheel_step_rad).tan()) / wheelbase_m
    }
}

/// A path that grows leg by leg.
#[derive(Debug, Clone)]
pub(crate) struct LookAheadFollower {
    pub(crate) path: PosePath,
    wheelbase_m: f64,
    settings: LookAhead,
}

impl LookAheadFollower {
    /// A path that starts at a pose, with the wheel at `wheel_angle_rad` (limited).
    pub(crate) fn new(x_m: f64, y_m: f64, heading_rad: f64, wheel_angle_rad: f64, wheelbase_m: f64, settings: LookAhead) -> Self {
        let angle = wheel_angle_rad.clamp(-settings.wheel_limit_rad, settings.wheel_limit_rad);
        let pose = PathPose {
            x_m,
            y_m,
            heading_rad,
            curvature_per_m: angle.tan() / wheelbase_m,
            wheel_angle_rad: angle,
            direction: Gear::Forward,
            s_m: 0.0,
        };
        Self { path: PosePath { poses: vec![pose] }, wheelbase_m, settings }
    }

    /// The last pose.
    pub(crate) fn last(&self) -> PathPose {
        self.path.poses[self.path.poses.len() - 1]
    }

    /// Follows `reference` in `gear` from its nearest point until `done` is true or `most_m` are travelled. Returns whether `done` was
    /// true.
    pub(crate) fn follow(
        &mut self,
        reference: &ReferenceLine,
        gear: Gear,
        most_m: f64,
        mut done: impl FnMut(&PathPose, f64) -> bool,
    ) -> bool {
        let mut matched_m = self.first_match(reference);
        let steps = (most_m / self.settings.step_m).ceil().clamp(0.0, 1e5) as usize;
        for _ in 0..steps {
            let here = self.last();
            matched_m = reference.project(PlanePoint::new(here.x_m, here.y_m), matched_m, self.settings.window_m);
            if done(&here, matched_m) {
                return true;
            }
            let (goal, _) = reference.at(matched_m + self.settings.distance_m);
            self.step(goal, gear);
        }
        false
    }

    /// The nearest place of the whole reference, searched at every step and refined. It may lie on the line before the start.
    fn first_match(&self, reference: &ReferenceLine) -> f64 {
        let here = self.last();
        let place = PlanePoint::new(here.x_m, here.y_m);
        let (start, course) = reference.at(0.0);
        let before = ((place.x_m - start.x_m) * course.cos() + (place.y_m - start.y_m) * course.sin()).min(0.0);
        let count = (reference.length_m() / self.settings.step_m).ceil().clamp(1.0, 1e5) as usize;
        let mut best = (reference.at(before).0.distance_m(place), before);
        for k in 0..=count {
            let s_m = reference.length_m() * k as f64 / count as f64;
            let distance = reference.at(s_m).0.distance_m(place);
            if distance < best.0 {
                best = (distance, s_m);
            }
        }
        best.1
    }

    /// One step toward `goal`.
    fn step(&mut self, goal: PlanePoint, gear: Gear) {
        let (settings, here) = (&self.settings, self.last());
        let (sin, cos) = here.heading_rad.sin_cos();
        let (dx, dy) = (goal.x_m - here.x_m, goal.y_m - here.y_m);
        let (x_g, y_g) = (dx * cos + dy * sin, dy * cos - dx * sin);
        let curvature = 2.0 * y_g / (x_g * x_g + y_g * y_g).max(1e-9);
        let wanted = (self.wheelbase_m * curvature).atan().clamp(-settings.wheel_limit_rad, settings.wheel_limit_rad);
        let change = (wanted - here.wheel_angle_rad).clamp(-settings.wheel_step_rad, settings.wheel_step_rad);
        let angle = here.wheel_angle_rad + change;
        let last = self.path.poses.len() - 1;
        // the wheel turns, then the vehicle moves: a pose holds the angle of the step after it
        self.path.poses[last].direction = gear;
        let moved = arc(&here, angle.tan() / self.wheelbase_m, gear.sign() * settings.step_m);
        self.path.poses.push(PathPose { wheel_angle_rad: angle, direction: gear, s_m: here.s_m + settings.step_m, ..moved });
    }
}

/// The pose after `distance_m` (negative in reverse) along a circle.
fn arc(from: &PathPose, curvature_per_m: f64, distance_m: f64) -> PathPose {
    let half = 0.5 * curvature_per_m * distance_m;
    let chord_m = distance_m * if half.abs() < 1e-6 { 1.0 - half * half / 6.0 } else { half.sin() / half };
    let to = ahead(PlanePoint::new(from.x_m, from.y_m), from.heading_rad + half, chord_m);
    PathPose { x_m: to.x_m, y_m: to.y_m, heading_rad: from.heading_rad + 2.0 * half, curvature_per_m, ..*from }
}

/// Largest change of wheel angle [rad] and of curvature [1/m] from one pose to the next.
pub(crate) fn largest_steps(path: &PosePath) -> (f64, f64) {
    path.poses.windows(2).fold((0.0, 0.0), |(angle, curvature): (f64, f64), pair| {
        (
            angle.max((pair[1].wheel_angle_rad - pair[0].wheel_angle_rad).abs()),
            curvature.max((pair[1].curvature_per_m - pair[0].curvature_per_m).abs()),
        )
    })
}

/// Checks a start.
pub(crate) fn finite_start(x_m: f64, y_m: f64, heading_rad: f64) -> Result<()> {
    let check =
        |field, value: f64| if value.abs() <= 1e3 { Ok(()) } else { Err(Error::Setting { field, value, allowed: "-1000 to 1000" }) };
    check("start x_m", x_m)?;
    check("start y_m", y_m)?;
    check("start heading_rad", heading_rad)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    #[test]
    fn a_line_is_reached_forward_and_in_reverse() {
        for (gear, course) in [(Gear::Forward, 0.0), (Gear::Reverse, PI)] {
            let mut follower = LookAheadFollower::new(0.0, 0.4, 0.1, 0.0, 0.9, LookAhead::default());
            let reference = ReferenceLine::starting(PlanePoint::new(0.0, 0.0), course).then(6.0, 0.0);
            assert!(follower.follow(&reference, gear, 8.0, |_, s| s > 5.0));
            let end = follower.last();
            assert!(end.y_m.abs() < 2e-3 && end.heading_rad.abs() < 5e-3, "{gear}: {end:?}");
        }
    }

    #[test]
    fn a_circle_is_held_to_the_part_of_its_radius_that_the_chord_cuts() {
        let settings = LookAhead { distance_m: 0.2, ..LookAhead::default() };
        let mut follower = LookAheadFollower::new(0.0, 0.0, 0.0, 0.42, 0.9, settings);
        let reference = ReferenceLine::starting(PlanePoint::new(0.0, 0.0), 0.0).then(2.0 * PI * 2.0, 0.5);
        follower.follow(&reference, Gear::Forward, 8.0, |_, _| false);
        let end = follower.last();
        let radius = end.x_m.hypot(end.y_m - 2.0);
        // the goal is on the circle, so the tangent circle through it is the same circle
        assert!((radius - 2.0).abs() < 5e-3, "{radius}");
    }

    #[test]
    fn neither_the_wheel_nor_the_curvature_jumps() {
        let settings = LookAhead::default();
        let mut follower = LookAheadFollower::new(0.0, 1.5, -0.8, -0.6, 0.9, settings);
        let reference = ReferenceLine::starting(PlanePoint::new(0.0, 0.0), 0.0).then(2.0, 0.0).then(1.5, 1.0).then(2.0, 0.0);
        follower.follow(&reference, Gear::Forward, 9.0, |_, _| false);
        let (angle, curvature) = largest_steps(&follower.path);
        assert!(angle <= settings.wheel_step_rad + 1e-12 && curvature <= settings.curvature_step_per_m(0.9) + 1e-12);
    }
}
