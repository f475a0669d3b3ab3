//! Planning: direction, gear, arc and speeds of a turn.
//!
//! With the wheel at δ the vehicle turns about a point on the rear axle's line, L/tan δ to the left of its middle: at δ = ±90° about the middle
//! itself. The front wheel runs on a circle of radius L/|sin δ|; a turn of Δθ is an arc of L·|Δθ|/|sin δ|.

use crate::angle::RAD_PER_DEG;
use crate::messages::{Direction, PivotRequest, Pose};
use crate::numeric::sin_cos;
use crate::waypoints::{MAX_WAYPOINTS, Path, Waypoint};
use crate::{Error, Gear, Profile, Result};
use core::f64::consts::TAU;

/// Wheel angle and gear for turns to the left and to the right.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum WheelPolicy {
    /// The wheel always at its test angle: left in forward gear, right in reverse gear.
    #[default]
    HoldLeft,
    /// The wheel to the left for left turns, to its second preset on the right for right turns; always forward gear.
    Mirror,
}

impl WheelPolicy {
    /// Wheel angle [rad] and gear that turn in `direction`, with the wheel's presets for the left and the right.
    pub fn wheel_and_gear(self, direction: Direction, left_rad: f64, right_rad: f64) -> (f64, Gear) {
        match (self, direction) {
            (_, Direction::Left) => (left_rad, Gear::Forward),
            (Self::HoldLeft, Direction::Right) => (left_rad, Gear::Reverse),
            (Self::Mirror, Direction::Right) => (right_rad, Gear::Forward),
        }
    }
}

/// Settings of planning.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct PlanningSettings {
    /// Distance from the rear axle to the front wheel's centre [m].
    pub wheelbase_m: f64,
    /// First preset: wheel angle that the map belongs to [rad], left positive. Default 90°. Turns to the left use its size.
    pub test_angle_rad: f64,
    /// Second preset: wheel angle of turns to the right with [`WheelPolicy::Mirror`] [rad], negative, −10° to −120°. Default the mirror of
    /// the first: at another angle the map is not the one that was measured.
    pub right_angle_rad: f64,
    /// Third preset: wheel angle to which the wheel returns after a pivot [rad], left positive, at most 100° either way. Default 0.
    pub return_angle_rad: f64,
    /// Wheel policy. Default hold-left.
    pub policy: WheelPolicy,
    /// Speeds along the arc.
    pub profile: Profile,
    /// Distance between waypoints along the arc [m]. Default 0.02.
    pub spacing_m: f64,
}

impl PlanningSettings {
    /// The defaults for a wheelbase [m] and a test angle [rad].
    pub fn new(wheelbase_m: f64, test_angle_rad: f64) -> Self {
        Self {
            wheelbase_m,
            test_angle_rad,
            right_angle_rad: -test_angle_rad.abs(),
            return_angle_rad: 0.0,
            policy: WheelPolicy::default(),
            profile: Profile::default(),
            spacing_m: 0.02,
        }
    }

    /// Checks that every number is finite and possible.
    ///
    /// # Errors
    /// The first invalid one.
    pub fn checked(self) -> Result<Self> {
        let check = |field, value: f64, allowed, good: bool| if good { Ok(()) } else { Err(Error::Setting { field, value, allowed }) };
        check("wheelbase_m", self.wheelbase_m, "0.05 to 20", (0.05..=20.0).contains(&self.wheelbase_m))?;
        let angle_deg = self.test_angle_rad / RAD_PER_DEG;
        check("test_angle_deg", angle_deg, "10 to 120 either way", (10.0..=120.0).contains(&angle_deg.abs()))?;
        let right_deg = self.right_angle_rad / RAD_PER_DEG;
        check("right_angle_deg", right_deg, "-120 to -10", (-120.0..=-10.0).contains(&right_deg))?;
        let return_deg = self.return_angle_rad / RAD_PER_DEG;
        check("return_angle_deg", return_deg, "0 to 100 either way", return_deg.abs() <= 100.0)?;
        check("spacing_m", self.spacing_m, "0.001 to 1", (0.001..=1.0).contains(&self.spacing_m))?;
        self.profile.checked()?;
        Ok(self)
    }

    /// Wheel angle [rad] and gear of turns in `direction`.
    pub fn wheel_and_gear(&self, direction: Direction) -> (f64, Gear) {
        self.policy.wheel_and_gear(direction, self.test_angle_rad.abs(), self.right_angle_rad)
    }

    /// Places the waypoints of a turn of `turn_rad` (left positive, at most a full turn) from `pose`.
    ///
    /// # Errors
    /// A turn of less than one waypoint spacing, of more than 360°, or not a number; a pose that is not a number; an arc with too many
    /// waypoints.
    pub fn plan(&self, turn_rad: f64, pose: Pose) -> Result<PivotRequest> {
        if !(pose.x_m.is_finite() && pose.y_m.is_finite() && pose.heading_rad.is_finite()) {
            return Err(Error::Pose { x_m: pose.x_m, y_m: pose.y_m, heading_rad: pose.heading_rad });
        }
        let direction = if turn_rad < 0.0 { Direction::Right } else { Direction::Left };
        let (wheel_angle_rad, gear) = self.wheel_and_gear(direction);
        let (sin_wheel, cos_wheel) = sin_cos(wheel_angle_rad);
        let size_rad = turn_rad.abs();
        let radius_m = self.wheelbase_m / sin_wheel.abs();
        let length_m = radius_m * size_rad;
        // 1e-9: a full turn given in degrees and converted is still a full turn
        if length_m.is_nan() || length_m < self.spacing_m || size_rad > TAU + 1e-9 {
            return Err(Error::Turn { found_deg: turn_rad / RAD_PER_DEG, smallest_deg: self.spacing_m / radius_m / RAD_PER_DEG });
        }
        let pieces = ((length_m / self.spacing_m) + 0.999_999) as usize;
        if pieces >= MAX_WAYPOINTS {
            return Err(Error::TooManyWaypoints { arc_m: length_m, needed: pieces + 1, allowed: MAX_WAYPOINTS });
        }
        let to_centre_m = self.wheelbase_m * cos_wheel / sin_wheel;
        let (sin_start, cos_start) = sin_cos(pose.heading_rad);
        let (centre_x, centre_y) = (pose.x_m - sin_start * to_centre_m, pose.y_m + cos_start * to_centre_m);
        let mut path = Path::default();
        let mut planned_s = 0.0;
        let mut last: Option<Waypoint> = None;
        for k in 0..=pieces {
            let arc_m = (k as f64 * self.spacing_m).min(length_m);
            let (sin, cos) = sin_cos(pose.heading_rad + direction.sign() * arc_m / radius_m);
            let point = Waypoint {
                x_m: centre_x + sin * to_centre_m + self.wheelbase_m * cos,
                y_m: centre_y - cos * to_centre_m + self.wheelbase_m * sin,
                arc_m,
                speed_mps: self.profile.speed_at(arc_m, length_m),
            };
            if let Some(previous) = last {
                planned_s += 2.0 * (arc_m - previous.arc_m) / (point.speed_mps + previous.speed_mps);
            }
            path.push(point);
            last = Some(point);
        }
        let return_angle_rad = self.return_angle_rad;
        Ok(PivotRequest { pivot: true, direction, wheel_angle_rad, return_angle_rad, gear, turn_rad: size_rad, planned_s, path })
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use proptest::prelude::*;

    fn settings() -> PlanningSettings {
        PlanningSettings::new(0.92, 90.0 * RAD_PER_DEG)
    }

    #[test]
    fn a_quarter_turn_is_a_quarter_circle_about_the_rear_axle() {
        let start = Pose { x_m: 1.0, y_m: 2.0, heading_rad: 0.3 };
        let plan = settings().plan(90.0 * RAD_PER_DEG, start).unwrap();
        assert!((plan.path.length_m() - 0.92 * 90.0 * RAD_PER_DEG).abs() < 1e-12);
        for p in plan.path.waypoints() {
            // rounding of cos 90° and of the sums: some 1e-16 per operation
            assert!((f64::hypot(p.x_m - 1.0, p.y_m - 2.0) - 0.92).abs() < 1e-12);
        }
        assert_eq!((plan.direction.flag(), plan.gear), (2, Gear::Forward));
        assert_eq!(plan.path.waypoints().last().unwrap().speed_mps, 0.0);
        // trapezoid: (0.6 − 0.1)/0.4 + 0.6/0.4 s on the slopes and 0.5577 m of cruise; linear speed over arc at both ends costs some tenths
        assert!((plan.planned_s - (1.25 + 1.5 + (1.4451 - 0.4375 - 0.45) / 0.6)).abs() < 0.4, "{}", plan.planned_s);
    }

    #[test]
    fn the_two_policies_turn_right_in_reverse_or_with_the_wheel_to_the_right() {
        let mut settings = settings();
        let right = |s: &PlanningSettings| s.plan(-1.0, Pose::default()).unwrap();
        let hold = right(&settings);
        assert_eq!((hold.direction.flag(), hold.gear), (3, Gear::Reverse));
        assert!(hold.wheel_angle_rad > 0.0);
        settings.policy = WheelPolicy::Mirror;
        let mirror = right(&settings);
        assert_eq!(mirror.gear, Gear::Forward);
        assert!(mirror.wheel_angle_rad < 0.0);
        let [p, q] = [&hold, &mirror].map(|r| *r.path.waypoints().last().unwrap());
        assert!((p.x_m - q.x_m).abs() < 1e-12 && (p.y_m - q.y_m).abs() < 1e-12);
    }

    #[test]
    fn the_second_preset_sets_the_circle_of_turns_to_the_right_and_the_third_is_in_the_request() {
        let mut settings = PlanningSettings::new(1.0, 90.0 * RAD_PER_DEG);
        settings.policy = WheelPolicy::Mirror;
        (settings.right_angle_rad, settings.return_angle_rad) = (-45.0 * RAD_PER_DEG, 20.0 * RAD_PER_DEG);
        let settings = settings.checked().unwrap();
        let [left, right] = [0.5, -0.5].map(|turn: f64| settings.plan(turn * TAU, Pose::default()).unwrap());
        assert_eq!((left.wheel_angle_rad, right.wheel_angle_rad), (90.0 * RAD_PER_DEG, -45.0 * RAD_PER_DEG));
        assert_eq!((left.return_angle_rad, right.return_angle_rad), (20.0 * RAD_PER_DEG, 20.0 * RAD_PER_DEG));
        // L/tan 45° = 1 m to the right: half a turn carries the front wheel from (1, 0) to (−1, −2), on a radius of √2 m
        let end = right.path.waypoints().last().unwrap();
        assert!((end.x_m + 1.0).abs() < 1e-9 && (end.y_m + 2.0).abs() < 1e-9, "{end:?}");
        assert!((right.path.length_m() - 2.0_f64.sqrt() * TAU / 2.0).abs() < 1e-9);
        // hold-left has no use for the second preset
        settings_hold_left(settings);
        for (right_deg, return_deg, field) in
            [(5.0, 0.0, "right_angle_deg"), (-9.0, 0.0, "right_angle_deg"), (-90.0, 101.0, "return_angle_deg")]
        {
            let (right_angle_rad, return_angle_rad) = (right_deg * RAD_PER_DEG, return_deg * RAD_PER_DEG);
            let found = PlanningSettings { right_angle_rad, return_angle_rad, ..settings }.checked();
            assert!(matches!(found, Err(Error::Setting { field: named, .. }) if named == field), "{found:?}");
        }
    }

    fn settings_hold_left(settings: PlanningSettings) {
        let request = PlanningSettings { policy: WheelPolicy::HoldLeft, ..settings }.plan(-1.0, Pose::default()).unwrap();
        assert_eq!((request.wheel_angle_rad, request.gear), (90.0 * RAD_PER_DEG, Gear::Reverse));
    }

    #[test]
    fn at_another_wheel_angle_the_turning_point_moves_along_the_rear_axle() {
        let plan = PlanningSettings::new(1.0, 45.0 * RAD_PER_DEG).plan(TAU / 2.0, Pose::default()).unwrap();
        // L/tan 45° = 1 m to the left: half a turn carries the front wheel from (1, 0) to (−1, 2)
        let end = plan.path.waypoints().last().unwrap();
        assert!((end.x_m + 1.0).abs() < 1e-9 && (end.y_m - 2.0).abs() < 1e-9);
        assert!((plan.path.length_m() - 2.0_f64.sqrt() * TAU / 2.0).abs() < 1e-9);
    }

    #[test]
    fn the_error_of_an_impossible_turn_names_the_allowed_range() {
        for turn in [0.0, 0.01, 7.0, f64::NAN, f64::INFINITY] {
            assert!(matches!(settings().plan(turn, Pose::default()), Err(Error::Turn { .. })), "{turn}");
        }
        let lost = Pose { x_m: f64::NAN, ..Pose::default() };
        assert!(matches!(settings().plan(1.0, lost), Err(Error::Pose { .. })));
        let fine = PlanningSettings { spacing_m: 0.001, ..settings() };
        assert!(matches!(fine.plan(6.0, Pose::default()), Err(Error::TooManyWaypoints { needed: 5521, .. })));
    }

    proptest! {
        #[test]
        fn every_turn_up_to_a_full_one_ends_at_its_heading(turn_deg in 2.0..360.0f64, left in any::<bool>(), heading in -3.0..3.0f64) {
            let turn = turn_deg * RAD_PER_DEG * if left { 1.0 } else { -1.0 };
            let plan = settings().plan(turn, Pose { heading_rad: heading, ..Pose::default() }).unwrap();
            let end = plan.path.waypoints().last().unwrap();
            prop_assert!((end.x_m - 0.92 * (heading + turn).cos()).abs() < 1e-9);
            prop_assert!((end.y_m - 0.92 * (heading + turn).sin()).abs() < 1e-9);
            prop_assert!(plan.path.waypoints().windows(2).all(|w| w[1].arc_m > w[0].arc_m && w[1].arc_m - w[0].arc_m < 0.0201));
            prop_assert!(plan.planned_s.is_finite());
        }
    }
}
