//! A course: a path of pieces whose curvature changes linearly (straights, arcs, clothoids), forward or in reverse.

use crate::control::numeric::{atan, sin_cos};
use crate::guidance::path::{PathPose, PosePath};
use crate::map::Gear;
use core::f64::consts::PI;
use serde::Serialize;

/// One piece.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub(crate) struct ClothoidPiece {
    /// Length [m].
    pub length_m: f64,
    /// Curvature at its start [1/m], tan δ/L, left positive.
    pub from_per_m: f64,
    /// Curvature at its end [1/m].
    pub to_per_m: f64,
    /// Direction of travel.
    pub direction: Gear,
}

impl ClothoidPiece {
    /// A straight, forward.
    pub(crate) fn straight(length_m: f64) -> Self {
        Self { length_m, from_per_m: 0.0, to_per_m: 0.0, direction: Gear::Forward }
    }

    /// A piece of changing curvature, forward.
    pub(crate) fn bend(length_m: f64, from_per_m: f64, to_per_m: f64) -> Self {
        Self { length_m, from_per_m, to_per_m, direction: Gear::Forward }
    }

    /// The same in reverse.
    #[must_use]
    pub(crate) fn reversed(self) -> Self {
        Self { direction: Gear::Reverse, ..self }
    }
}

/// Distance between poses [m].
const SPACING_M: f64 = 0.05;

/// The task of the lateral calibration: a straight, a bend of 90°, a lane change around an obstacle and back, a straight; then a straight in
/// reverse. 58 m.
pub(crate) fn lateral_task() -> Vec<ClothoidPiece> {
    let bend = 0.2;
    // two clothoids of 2 m turn by κ·2 in all, the arc by the rest of 90°
    let arc_m = 0.5 * PI / bend - 2.0;
    let swerve = |side: f64| {
        let k = side * 0.25;
        [
            ClothoidPiece::bend(1.0, 0.0, k),
            ClothoidPiece::bend(1.0, k, 0.0),
            ClothoidPiece::bend(1.0, 0.0, -k),
            ClothoidPiece::bend(1.0, -k, 0.0),
        ]
    };
    let mut pieces = vec![
        ClothoidPiece::straight(12.0),
        ClothoidPiece::bend(2.0, 0.0, bend),
        ClothoidPiece::bend(arc_m, bend, bend),
        ClothoidPiece::bend(2.0, bend, 0.0),
    ];
    pieces.push(ClothoidPiece::straight(6.0));
    pieces.extend(swerve(-1.0));
    pieces.push(ClothoidPiece::straight(2.0));
    pieces.extend(swerve(1.0));
    pieces.push(ClothoidPiece::straight(8.0));
    pieces.push(ClothoidPiece::straight(12.0).reversed());
    pieces
}

/// The path of `pieces` from the origin along x, one pose every 0.05 m; positions by Simpson's rule over each spacing.
pub(crate) fn course(pieces: &[ClothoidPiece], wheelbase_m: f64) -> PosePath {
    let mut path = PosePath::default();
    let (mut x, mut y, mut heading, mut s) = (0.0, 0.0, 0.0, 0.0);
    let pose = |x_m: f64, y_m: f64, heading_rad: f64, curvature_per_m: f64, direction: Gear, s_m: f64| PathPose {
        x_m,
        y_m,
        heading_rad,
        curvature_per_m,
        wheel_angle_rad: atan(wheelbase_m * curvature_per_m),
        direction,
        s_m,
    };
    for piece in pieces.iter().filter(|p| p.length_m > 0.0) {
        let count = (piece.length_m / SPACING_M).ceil().clamp(1.0, 1e6) as usize;
        let step = piece.length_m / count as f64;
        let sign = piece.direction.sign();
        let slope = (piece.to_per_m - piece.from_per_m) / piece.length_m;
        if path.poses.last().is_none_or(|p| p.direction != piece.direction) {
            // the pose at which the direction changes belongs to the new one
            path.poses.pop();
            path.poses.push(pose(x, y, heading, piece.from_per_m, piece.direction, s));
        }
        for k in 0..count {
            let at = |part: f64| piece.from_per_m + slope * step * (k as f64 + part);
            let (middle, end) = (heading + sign * step * 0.25 * (at(0.0) + at(0.5)), heading + sign * step * 0.5 * (at(0.0) + at(1.0)));
            let ((s0, c0), (s1, c1), (s2, c2)) = (sin_cos(heading), sin_cos(middle), sin_cos(end));
            x += sign * step / 6.0 * (c0 + 4.0 * c1 + c2);
            y += sign * step / 6.0 * (s0 + 4.0 * s1 + s2);
            (heading, s) = (end, s + step);
            path.poses.push(pose(x, y, heading, at(1.0), piece.direction, s));
        }
    }
    path
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_circle_closes_and_a_reverse_piece_goes_back_the_same_way() {
        let circle = course(&[ClothoidPiece::bend(2.0 * PI * 3.0, 1.0 / 3.0, 1.0 / 3.0)], 0.9);
        let end = circle.poses[circle.poses.len() - 1];
        assert!(end.x_m.hypot(end.y_m) < 1e-9 && (end.heading_rad - 2.0 * PI).abs() < 1e-9);
        let there_and_back = course(&[ClothoidPiece::bend(3.0, 0.0, 0.4), ClothoidPiece::bend(3.0, 0.4, 0.0).reversed()], 0.9);
        let end = there_and_back.poses[there_and_back.poses.len() - 1];
        assert!(end.x_m.hypot(end.y_m) < 1e-9 && end.heading_rad.abs() < 1e-12 && (end.s_m - 6.0).abs() < 1e-9);
    }

    #[test]
    fn the_lateral_task_turns_left_by_90_degrees_and_ends_in_reverse() {
        let path = course(&lateral_task(), 0.9);
        let end = path.poses[path.poses.len() - 1];
        assert!((end.heading_rad - 0.5 * PI).abs() < 1e-9 && end.direction == Gear::Reverse);
    }
}
