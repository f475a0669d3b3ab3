//! A polyline with turns on the spot: from a list of points to segments with headings and directions of travel, and to legs that are driven
//! without a stop.
//!
//! The direction of travel follows by recursion: with the vehicle's heading θ on the segment before and the segment's own direction φ, forward when
//! |φ − θ| ≤ 90°, else in reverse with heading φ + π. So no corner turns the vehicle by more than 90°. The first segment is driven forward
//! unless a start heading says otherwise.

use crate::control::numeric::{atan2, wrapped};
use crate::guidance::path::{PathPose, PosePath};
use crate::guidance::route::path_position::hypot;
use crate::map::Gear;
use crate::units::RAD_PER_DEG;
use core::f64::consts::{FRAC_PI_2, PI};
use serde::Serialize;

/// Why a list of points is no path.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
#[allow(missing_docs)] // the fields are what the message says
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
}

impl Default for PolylineSettings {
    fn default() -> Self {
        Self { continues_rad: 5.0 * RAD_PER_DEG, least_m: 0.1, start_heading_rad: None }
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
    /// Whether it goes on from the segment before without a stop.
    pub continues: bool,
}

/// The plan of a polyline.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct PolylinePlan {
    /// The segments.
    pub segments: Vec<PolylineSegment>,
    /// What is driven without a stop: one or more segments each.
    pub legs: Vec<PosePath>,
    /// Heading of the vehicle on each leg's first segment [rad].
    pub headings_rad: Vec<f64>,
}

impl PolylinePlan {
    /// Plans `points` [m].
    ///
    /// # Errors
    /// Fewer than two points, a point that is not finite, points repeated or nearer than the shortest segment.
    pub fn new(points: &[[f64; 2]], settings: &PolylineSettings) -> Result<Self, PolylineError> {
        if !(0.0..=30.0 * RAD_PER_DEG).contains(&settings.continues_rad) {
            return Err(PolylineError::Continues { found_deg: settings.continues_rad / RAD_PER_DEG });
        }
        if points.len() < 2 {
            return Err(PolylineError::TooFewPoints { found: points.len(), least_m: settings.least_m });
        }
        if let Some(k) = points.iter().position(|p| !(p[0].is_finite() && p[1].is_finite())) {
            return Err(PolylineError::NotFinite { point: k + 1, x_m: points[k][0], y_m: points[k][1] });
        }
        let mut plan = Self::default();
        let mut heading = settings.start_heading_rad;
        for (k, pair) in points.windows(2).enumerate() {
            let (dx, dy) = (pair[1][0] - pair[0][0], pair[1][1] - pair[0][1]);
            let length_m = hypot(dx, dy);
            // a hair of tolerance: points typed at the least distance are that far apart
            if length_m < settings.least_m * (1.0 - 1e-9) {
                let (x_m, y_m) = (pair[1][0], pair[1][1]);
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
                from_m: pair[0],
                to_m: pair[1],
                course_rad,
                length_m,
                gear,
                heading_rad,
                turn_rad,
                continues,
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
        Ok(plan)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn a_sharp_corner_is_left_in_reverse() {
        let plan = PolylinePlan::new(&[[0.0, 0.0], [4.0, 0.0], [1.0, 1.0], [1.0, 5.0]], &PolylineSettings::default()).unwrap();
        let gears: Vec<Gear> = plan.segments.iter().map(|s| s.gear).collect();
        // 161.6° is more than 90°: back, turned by −18.4°; then from heading −18.4° to 90° is more than 90°: back again
        assert_eq!(gears, [Gear::Forward, Gear::Reverse, Gear::Reverse]);
        assert!((plan.segments[1].turn_rad / RAD_PER_DEG + 18.435).abs() < 1e-3);
        assert!((plan.segments[2].turn_rad / RAD_PER_DEG + 71.565).abs() < 1e-3, "{}", plan.segments[2].turn_rad / RAD_PER_DEG);
    }

    #[test]
    fn a_small_angle_continues_in_the_same_leg() {
        let plan = PolylinePlan::new(&[[0.0, 0.0], [4.0, 0.0], [8.0, 0.2], [8.0, 4.0]], &PolylineSettings::default()).unwrap();
        assert_eq!((plan.segments.len(), plan.legs.len()), (3, 2));
        assert_eq!(plan.legs[0].poses.len(), 4);
    }

    #[test]
    fn what_is_no_path_is_refused_with_what_would_be_one() {
        let settings = PolylineSettings::default();
        let message = |points: &[[f64; 2]]| PolylinePlan::new(points, &settings).unwrap_err().to_string();
        assert_eq!(message(&[[1.0, 2.0]]), "a path needs at least 2 points, 1 found; add a point at least 0.1 m from the first");
        assert!(message(&[]).contains("0 found"));
        let repeated = message(&[[0.0, 0.0], [1.0, 2.0], [1.0, 2.0]]);
        assert!(repeated.starts_with("points 2 and 3 are 0 m apart, at (1, 2); the least is 0.1 m: leave out point 3"), "{repeated}");
        assert!(message(&[[0.0, 0.0], [f64::NAN, 2.0]]).contains("point 2"));
    }

    proptest! {
        #[test]
        fn no_corner_turns_by_more_than_90_degrees(points in prop::collection::vec((-9.0..9.0f64, -9.0..9.0f64), 0..12)) {
            let points: Vec<[f64; 2]> = points.into_iter().map(|(x, y)| [x, y]).collect();
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
