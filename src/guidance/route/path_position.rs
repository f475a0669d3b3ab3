//! A place on one leg of a path, and the path in the travel frame.
//!
//! A leg is a sequence of poses with one direction of travel. In reverse everything is rotated by π: the *travel frame*. There a vehicle
//! that drives backward becomes one that drives forward with its steering mirrored (δ' = −δ), so that a law for forward travel serves both.

use crate::control::Pose;
use crate::control::numeric::{sin_cos, sqrt, wrapped};
use crate::guidance::path::PathPose;
use crate::map::Gear;
use core::f64::consts::PI;

/// A point of the path in the travel frame.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Matched {
    /// East [m].
    pub x_m: f64,
    /// North [m].
    pub y_m: f64,
    /// Direction of the path [rad].
    pub course_rad: f64,
    /// Its change over the distance travelled [1/m], left positive.
    pub curvature_per_m: f64,
    /// Distance travelled from the start of the path [m].
    pub s_m: f64,
}

/// One leg, borrowed.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Leg<'a> {
    poses: &'a [PathPose],
}

/// The curvature at either end holds this far beyond it [m]: at rest at a change of direction the foot of a noisy pose lies now before and now
/// after the leg's start, and the wheel must not be asked for straight ahead and for the path's angle in turn.
const NEAR_END_M: f64 = 0.05;
/// Length of the search beyond the nearest point so far [m].
const WINDOW_M: f64 = 2.0;

impl<'a> Leg<'a> {
    /// The leg that begins at the first of `poses`: as far as the direction stays the same, with the pose at which it changes. `None` without two
    /// poses.
    pub(crate) fn first(poses: &'a [PathPose]) -> Option<Self> {
        let direction = poses.first()?.direction;
        let end = poses.iter().position(|p| p.direction != direction).unwrap_or(poses.len() - 1);
        if end == 0 { None } else { Some(Self { poses: poses.get(..=end)? }) }
    }

    /// Index of its last pose, counted from its first.
    pub(crate) fn last_index(&self) -> usize {
        self.poses.len() - 1
    }

    /// Direction of travel.
    pub(crate) fn gear(&self) -> Gear {
        self.poses[0].direction
    }

    /// Distance at its start [m].
    pub(crate) fn start_m(&self) -> f64 {
        self.poses[0].s_m
    }

    /// Distance at its end [m].
    pub(crate) fn end_m(&self) -> f64 {
        self.poses[self.poses.len() - 1].s_m
    }

    /// The pose of the vehicle in the travel frame.
    pub(crate) fn travel_pose(&self, pose: Pose) -> Pose {
        match self.gear() {
            Gear::Forward => pose,
            Gear::Reverse => Pose { heading_rad: pose.heading_rad + PI, ..pose },
        }
    }

    /// The point at distance `s_m`; the path continues straight before the start and past the end, with the end's curvature for 5 cm. `hint`: an index of a pose at or before
    /// it.
    pub(crate) fn at(&self, s_m: f64, hint: usize) -> Matched {
        let last = self.poses.len() - 1;
        let mut index = hint.min(last - 1);
        while index > 0 && self.poses[index].s_m > s_m {
            index -= 1;
        }
        while index + 1 < last && self.poses[index + 1].s_m < s_m {
            index += 1;
        }
        let (p, q) = (&self.poses[index], &self.poses[index + 1]);
        let length = q.s_m - p.s_m;
        let fraction = if length > 0.0 { (s_m - p.s_m) / length } else { 0.0 };
        let within = fraction.clamp(0.0, 1.0);
        let turn = if self.gear() == Gear::Forward { 0.0 } else { PI };
        let sign = self.gear().sign();
        let heading_rad = p.heading_rad + within * wrapped(q.heading_rad - p.heading_rad);
        let course_rad = heading_rad + turn;
        let outside_m = (fraction - within) * length;
        let (sin, cos) = sin_cos(course_rad);
        Matched {
            x_m: p.x_m + within * (q.x_m - p.x_m) + outside_m * cos,
            y_m: p.y_m + within * (q.y_m - p.y_m) + outside_m * sin,
            course_rad,
            curvature_per_m: if outside_m.abs() <= NEAR_END_M {
                sign * (p.curvature_per_m + within * (q.curvature_per_m - p.curvature_per_m))
            } else {
                0.0
            },
            s_m,
        }
    }

    /// The foot of the perpendicular from (`x_m`, `y_m`): the nearest one on the pieces from `hint` onward, searched to 2 m
    /// beyond the nearest so far, so that a path that returns to itself is not cut short. Returns the
    /// point and the index of its piece. Past either end it lies on the straight continuation.
    pub(crate) fn nearest(&self, x_m: f64, y_m: f64, hint: usize) -> (Matched, usize) {
        let last = self.poses.len() - 1;
        let first = hint.min(last - 1);
        let from_m = self.poses[first].s_m;
        let (mut best, mut found, mut best_s) = (f64::INFINITY, first, from_m);
        for index in first..last {
            let (p, q) = (&self.poses[index], &self.poses[index + 1]);
            if index > first && p.s_m > best_s + WINDOW_M {
                break;
            }
            let (dx, dy) = (q.x_m - p.x_m, q.y_m - p.y_m);
            let squared = dx * dx + dy * dy;
            if squared == 0.0 {
                continue;
            }
            let free = ((x_m - p.x_m) * dx + (y_m - p.y_m) * dy) / squared;
            let low = if index == 0 { f64::NEG_INFINITY } else { 0.0 };
            let high = if index + 1 == last { f64::INFINITY } else { 1.0 };
            let fraction = if free < low {
                low
            } else if free > high {
                high
            } else {
                free
            };
            let (ex, ey) = (x_m - p.x_m - fraction * dx, y_m - p.y_m - fraction * dy);
            let distance = ex * ex + ey * ey;
            if distance < best {
                (best, found, best_s) = (distance, index, p.s_m + fraction * (q.s_m - p.s_m));
            }
        }
        (self.at(best_s, found), found)
    }
}

/// Offset and heading error of the vehicle from the path, in the travel frame.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Offset {
    /// Distance of the point to the left of the path [m].
    pub lateral_m: f64,
    /// Direction of travel minus course of the path [rad], −π to π.
    pub heading_rad: f64,
}

impl Offset {
    /// The offset of `pose` from `matched`.
    pub(crate) fn new(pose: Pose, matched: &Matched) -> Self {
        let (sin, cos) = sin_cos(matched.course_rad);
        Self {
            lateral_m: cos * (pose.y_m - matched.y_m) - sin * (pose.x_m - matched.x_m),
            heading_rad: wrapped(pose.heading_rad - matched.course_rad),
        }
    }
}

/// The instantaneous lateral error of a vehicle at `pose` [m]: `e = cos θ·(y_m − y) − sin θ·(x_m − x)`, the matched point seen from the
/// vehicle, left positive, θ the vehicle's heading whatever the direction of travel.
pub(crate) fn lateral_error_m(pose: Pose, matched_x_m: f64, matched_y_m: f64) -> f64 {
    let (sin, cos) = sin_cos(pose.heading_rad);
    cos * (matched_y_m - pose.y_m) - sin * (matched_x_m - pose.x_m)
}

/// √(a² + b²).
pub(crate) fn hypot(a: f64, b: f64) -> f64 {
    sqrt(a * a + b * b)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn pose(x_m: f64, y_m: f64, heading_rad: f64, s_m: f64, direction: Gear) -> PathPose {
        PathPose { x_m, y_m, heading_rad, curvature_per_m: 0.0, wheel_angle_rad: 0.0, direction, s_m }
    }

    #[test]
    fn the_foot_is_found_on_long_and_short_pieces_and_beyond_the_ends() {
        let f = Gear::Forward;
        let poses = [pose(0.0, 0.0, 0.0, 0.0, f), pose(6.0, 0.0, 0.0, 6.0, f), pose(6.0, 0.0, 1.5, 6.0, f), pose(6.0, 1.0, 1.5, 7.0, f)];
        let leg = Leg::first(&poses).unwrap();
        assert_eq!(leg.nearest(4.0, 0.3, 0).0.s_m, 4.0);
        assert_eq!(leg.nearest(5.9, 0.6, 0), (leg.at(6.6, 2), 2));
        assert_eq!(leg.nearest(-0.5, 0.2, 0).0.s_m, -0.5);
        assert_eq!(leg.nearest(6.0, 1.4, 2).0.s_m, 7.4);
    }

    #[test]
    fn the_curvature_of_an_end_holds_a_little_beyond_it() {
        let bent = |x_m: f64, s_m: f64| PathPose { curvature_per_m: 0.8, ..pose(x_m, 0.0, 0.0, s_m, Gear::Forward) };
        let poses = [bent(0.0, 0.0), bent(1.0, 1.0)];
        let leg = Leg::first(&poses).unwrap();
        let at = |s_m: f64| leg.at(s_m, 0).curvature_per_m;
        assert_eq!((at(-0.02), at(0.0), at(0.5), at(1.02)), (0.8, 0.8, 0.8, 0.8));
        assert_eq!((at(-0.2), at(1.2)), (0.0, 0.0));
    }

    #[test]
    fn in_reverse_the_travel_frame_is_turned_round_and_the_lateral_error_is_not() {
        let r = Gear::Reverse;
        let poses = [pose(0.0, 0.0, 0.0, 0.0, r), pose(-5.0, 0.0, 0.0, 5.0, r)];
        let leg = Leg::first(&poses).unwrap();
        let vehicle = Pose { x_m: -2.0, y_m: 0.1, heading_rad: 0.0 };
        let (matched, _) = leg.nearest(vehicle.x_m, vehicle.y_m, 0);
        // seen along the travel the vehicle is to the right of the path, seen along its heading the path is to its right
        let offset = Offset::new(leg.travel_pose(vehicle), &matched);
        assert!((offset.lateral_m + 0.1).abs() < 1e-12 && offset.heading_rad.abs() < 1e-12);
        assert!((lateral_error_m(vehicle, matched.x_m, matched.y_m) + 0.1).abs() < 1e-12);
    }
}
