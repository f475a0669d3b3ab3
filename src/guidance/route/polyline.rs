//! A polyline with turns on the spot: a list of points becomes segments with headings and directions of travel, and legs that are driven
//! without a stop.
//!
//! The direction of travel follows by recursion, with the vehicle's heading θ on the previous segment and the segment's own direction φ:
//! forward if |φ − θ| ≤ 90°, otherwise in reverse with heading φ + π. So no corner turns the vehicle by more than 90°. The first segment
//! is driven forward unless a start heading is given. Each segment has a set speed ([`LegSpeed`]).

use crate::control::numeric::{atan2, wrapped};
use crate::guidance::path::{PathPose, PosePath};
use crate::guidance::route::leg_speed::LegSpeed;
use crate::guidance::route::path_position::hypot;
use crate::guidance::route::segment_speed::SegmentSpeed;
use crate::map::Gear;
use crate::units::RAD_PER_DEG;
use core::f64::consts::{FRAC_PI_2, PI};
use serde::Serialize;

/// Why a list of points is not a path.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
#[allow(missing_docs)] // the message explains the fields
pub enum PolylineError {
    #[error("a path needs at least 2 points, {found} found; add a point at least {least_m} m from the first")]
    TooFewPoints { found: usize, least_m: f64 },
    #[error(
        "points {first} and {second} are {distance_m} m apart, at ({x_m}, {y_m}); the least is {least_m} m: leave out point {second}, or move \
         it by at least {move_m} m"
    )]
    Repeated { first: usize, second: usize, distance_m: f64, x_m: f64, y_m: f64, least_m: f64, move_m: f64 },
    #[error("point {point} is not a pair of finite numbers: ({x_m}, {y_m})")]
    NotFinite { point: usize, x_m: f64, y_m: f64 },
    #[error(
        "the angle within which a segment continues is {found_deg}°; allowed: 0 to 30°, since a wheel that keeps rolling cuts the corner"
    )]
    Continues { found_deg: f64 },
    #[error("the set speed at point {point} is {found_mps} m/s; allowed: 0.05 to 5 m/s, or none for {usual_mps} m/s")]
    SetSpeed { point: usize, found_mps: f64, usual_mps: f64 },
    #[error("the speeds of the segments: {0}")]
    Speeds(#[from] crate::control::Error),
}

/// A point of a polyline.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct PolylinePoint {
    /// East [m].
    pub x_m: f64,
    /// North [m].
    pub y_m: f64,
    /// Set speed of the segment that begins here [m/s], front wheel; `None` for the usual one. Without meaning at the last point.
    pub speed_mps: Option<f64>,
}

impl From<[f64; 2]> for PolylinePoint {
    /// At the usual speed.
    fn from([x_m, y_m]: [f64; 2]) -> Self {
        Self { x_m, y_m, speed_mps: None }
    }
}

/// Settings of the plan.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct PolylineSettings {
    /// A corner of at most this angle is driven through without slowing down [rad]. Default 5°.
    pub continues_rad: f64,
    /// Shortest segment [m]. Default 0.1.
    pub least_m: f64,
    /// Heading of the vehicle at the start [rad], if it is not that of the first segment.
    pub start_heading_rad: Option<f64>,
    /// Usual set speed, the speeds at corners, and the distances of the ramps.
    pub speed: SegmentSpeed,
}

impl Default for PolylineSettings {
    fn default() -> Self {
        Self { continues_rad: 5.0 * RAD_PER_DEG, least_m: 0.1, start_heading_rad: None, speed: SegmentSpeed::default() }
    }
}

/// One segment between two points.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct PolylineSegment {
    /// Its start [m].
    pub from_m: [f64; 2],
    /// Its end [m].
    pub to_m: [f64; 2],
    /// Direction from start to end [rad].
    pub course_rad: f64,
    /// Length [m].
    pub length_m: f64,
    /// Direction of travel.
    pub gear: Gear,
    /// Heading of the vehicle on it [rad].
    pub heading_rad: f64,
    /// Turn at its start [rad], left positive, at most 90° either way.
    pub turn_rad: f64,
    /// Whether it continues from the previous segment without a stop.
    pub continues: bool,
    /// Set speed [m/s], if it has one of its own.
    pub speed_mps: Option<f64>,
}

/// The plan of a polyline.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct PolylinePlan {
    /// The segments.
    pub segments: Vec<PolylineSegment>,
    /// The legs, each driven without a stop: one or more segments.
    pub legs: Vec<PosePath>,
    /// Heading of the vehicle on each leg's first segment [rad].
    pub headings_rad: Vec<f64>,
    /// Speed along each leg.
    pub speeds: Vec<LegSpeed>,
}

impl PolylinePlan {
    /// Plans `points`.
    ///
    /// # Errors
    /// Fewer than two points, a point that is not finite, points repeated or nearer than the shortest segment, a set speed out of its range.
    pub fn new(points: &[PolylinePoint], settings: &PolylineSettings) -> Result<Self, PolylineError> {
        if !(0.0..=30.0 * RAD_PER_DEG).contains(&settings.continues_rad) {
            return Err(PolylineError::Continues { found_deg: settings.continues_rad / RAD_PER_DEG });
        }
        if points.len() < 2 {
            return Err(PolylineError::TooFewPoints { found: points.len(), least_m: settings.least_m });
        }
        if let Some(k) = points.iter().position(|p| !(p.x_m.is_finite() && p.y_m.is_finite())) {
            return Err(PolylineError::NotFinite { point: k + 1, x_m: points[k].x_m, y_m: points[k].y_m });
        }
        let usual_mps = settings.speed.cruise_mps;
        let speeds = points[..points.len() - 1].iter().map(|p| p.speed_mps).enumerate();
        for (k, found_mps) in speeds.filter_map(|(k, speed)| Some((k, speed?))) {
            if !(0.05..=5.0).contains(&found_mps) {
                return Err(PolylineError::SetSpeed { point: k + 1, found_mps, usual_mps });
            }
        }
        let mut plan = Self::default();
        let mut heading = settings.start_heading_rad;
        for (k, pair) in points.windows(2).enumerate() {
            let (dx, dy) = (pair[1].x_m - pair[0].x_m, pair[1].y_m - pair[0].y_m);
            let length_m = hypot(dx, dy);
            // a small tolerance for rounding: points typed at the least distance are accepted
            if length_m < settings.least_m * (1.0 - 1e-9) {
                let (x_m, y_m) = (pair[1].x_m, pair[1].y_m);
                let (distance_m, least_m) = (length_m, settings.least_m);
                let move_m = settings.least_m - length_m;
                return Err(PolylineError::Repeated { first: k + 1, second: k + 2, distance_m, x_m, y_m, least_m, move_m });
            }
            let course_rad = atan2(dy, dx);
            let before = heading.unwrap_or(course_rad);
            let forward = wrapped(course_rad - before).abs() <= FRAC_PI_2 + 1e-9;
            let gear = if forward { Gear::Forward } else { Gear::Reverse };
            let heading_rad = if forward { course_rad } else { wrapped(course_rad + PI) };
            let turn_rad = wrapped(heading_rad - before);
            let last = plan.segments.last();
            let continues = last.is_some_and(|s: &PolylineSegment| s.gear == gear) && turn_rad.abs() <= settings.continues_rad;
            plan.segments.push(PolylineSegment {
                from_m: [pair[0].x_m, pair[0].y_m],
                to_m: [pair[1].x_m, pair[1].y_m],
                course_rad,
                length_m,
                gear,
                heading_rad,
                turn_rad,
                continues,
                speed_mps: pair[0].speed_mps,
            });
            heading = Some(heading_rad);
        }
        for segment in &plan.segments {
            if !segment.continues {
                plan.legs.push(PosePath::default());
                plan.headings_rad.push(segment.heading_rad);
            }
            if let Some(leg) = plan.legs.last_mut() {
                let s_m = leg.poses.last().map_or(0.0, |p| p.s_m);
                for (at, s_m) in [(segment.from_m, s_m), (segment.to_m, s_m + segment.length_m)] {
                    leg.poses.push(PathPose {
                        x_m: at[0],
                        y_m: at[1],
                        heading_rad: segment.heading_rad,
                        curvature_per_m: 0.0,
                        wheel_angle_rad: 0.0,
                        direction: segment.gear,
                        s_m,
                    });
                }
            }
        }
        let mut of_legs: Vec<Vec<(f64, Option<f64>)>> = Vec::new();
        for segment in &plan.segments {
            if !segment.continues {
                of_legs.push(Vec::new());
            }
            if let Some(leg) = of_legs.last_mut() {
                leg.push((segment.length_m, segment.speed_mps));
            }
        }
        plan.speeds = of_legs.iter().map(|leg| LegSpeed::new(leg, &settings.speed)).collect::<Result<_, _>>()?;
        Ok(plan)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use proptest::prelude::*;

    fn at(points: &[[f64; 2]]) -> Vec<PolylinePoint> {
        points.iter().map(|p| PolylinePoint::from(*p)).collect()
    }

    #[test]
    fn a_sharp_corner_is_left_in_reverse() {
        let plan = PolylinePlan::new(&at(&[[0.0, 0.0], [4.0, 0.0], [1.0, 1.0], [1.0, 5.0]]), &PolylineSettings::default()).unwrap();
        let gears: Vec<Gear> = plan.segments.iter().map(|s| s.gear).collect();
        // 161.6° is more than 90°: back, turned by −18.4°; then from heading −18.4° to 90° is more than 90°: back again
        assert_eq!(gears, [Gear::Forward, Gear::Reverse, Gear::Reverse]);
        assert!((plan.segments[1].turn_rad / RAD_PER_DEG + 18.435).abs() < 1e-3);
        assert!((plan.segments[2].turn_rad / RAD_PER_DEG + 71.565).abs() < 1e-3, "{}", plan.segments[2].turn_rad / RAD_PER_DEG);
    }

    #[test]
    fn a_small_angle_continues_in_the_same_leg() {
        let plan = PolylinePlan::new(&at(&[[0.0, 0.0], [4.0, 0.0], [8.0, 0.2], [8.0, 4.0]]), &PolylineSettings::default()).unwrap();
        assert_eq!((plan.segments.len(), plan.legs.len()), (3, 2));
        assert_eq!(plan.legs[0].poses.len(), 4);
    }

    #[test]
    fn points_that_are_not_a_path_are_an_error_with_a_remedy() {
        let settings = PolylineSettings::default();
        let message = |points: &[[f64; 2]]| PolylinePlan::new(&at(points), &settings).unwrap_err().to_string();
        assert_eq!(message(&[[1.0, 2.0]]), "a path needs at least 2 points, 1 found; add a point at least 0.1 m from the first");
        assert!(message(&[]).contains("0 found"));
        let repeated = message(&[[0.0, 0.0], [1.0, 2.0], [1.0, 2.0]]);
        assert!(repeated.starts_with("points 2 and 3 are 0 m apart, at (1, 2); the least is 0.1 m: leave out point 3"), "{repeated}");
        assert!(message(&[[0.0, 0.0], [f64::NAN, 2.0]]).contains("point 2"));
    }

    #[test]
    fn each_segment_has_the_set_speed_of_its_first_point() {
        let point = |x_m, y_m, speed_mps| PolylinePoint { x_m, y_m, speed_mps };
        // 2.9° at the second point: one leg; a corner at the third
        let points = [point(0.0, 0.0, Some(0.5)), point(4.0, 0.0, Some(0.7)), point(8.0, 0.2, None), point(8.0, 5.2, Some(9.0))];
        let plan = PolylinePlan::new(&points, &PolylineSettings::default()).unwrap();
        assert_eq!(plan.speeds.len(), 2);
        let near = |leg: usize, s_m: f64, v: f64| assert!((plan.speeds[leg].speed_at(s_m, 0.0) - v).abs() < 1e-9, "{leg} {s_m}");
        near(0, 2.0, 0.5);
        near(0, 4.0, 0.7);
        near(0, 6.0, 0.7);
        near(0, 4.0 + f64::hypot(4.0, 0.2), 0.12);
        near(1, 0.0, 0.15);
        near(1, 2.5, 0.8);
        let mut wrong = points;
        wrong[1].speed_mps = Some(0.0);
        let error = PolylinePlan::new(&wrong, &PolylineSettings::default()).unwrap_err().to_string();
        assert_eq!(error, "the set speed at point 2 is 0 m/s; allowed: 0.05 to 5 m/s, or none for 0.8 m/s");
    }

    proptest! {
        #[test]
        fn no_corner_turns_by_more_than_90_degrees(points in prop::collection::vec((-9.0..9.0f64, -9.0..9.0f64), 0..12)) {
            let points: Vec<PolylinePoint> = points.into_iter().map(|(x, y)| [x, y].into()).collect();
            if let Ok(plan) = PolylinePlan::new(&points, &PolylineSettings::default()) {
                for s in &plan.segments {
                    prop_assert!(s.turn_rad.abs() <= FRAC_PI_2 + 1e-8);
                    let away = if s.gear == Gear::Forward { 0.0 } else { PI };
                    prop_assert!(wrapped(s.heading_rad + away - s.course_rad).abs() < 1e-9);
                }
            }
        }
    }
}
