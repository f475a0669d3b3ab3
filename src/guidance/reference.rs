//! A reference for the rear axle: straight pieces and circles, one after the other.

use crate::guidance::geometry::PlanePoint;
use serde::Serialize;

/// A piece of constant curvature in the order of travel.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
struct ReferencePiece {
    start: PlanePoint,
    /// Direction of travel at the start [rad].
    course_rad: f64,
    /// Change of the direction of travel per metre [1/m].
    bend_per_m: f64,
    /// Distance of the start from the reference's start [m].
    from_m: f64,
    length_m: f64,
}

/// Straight lines and circles, one after the other; it continues straight before its start and past its end.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct ReferenceLine {
    pieces: Vec<ReferencePiece>,
    end: PlanePoint,
    end_course_rad: f64,
    length_m: f64,
}

impl ReferenceLine {
    /// An empty reference that starts at a point with a direction of travel [rad].
    pub(crate) fn starting(start: PlanePoint, course_rad: f64) -> Self {
        Self {
            pieces: vec![ReferencePiece { start, course_rad, bend_per_m: 0.0, from_m: 0.0, length_m: 0.0 }],
            end: start,
            end_course_rad: course_rad,
            length_m: 0.0,
        }
    }

    /// Appends a piece of `length_m` (none below 0) with curvature `bend_per_m` (left positive in the direction of travel).
    #[must_use]
    pub(crate) fn then(mut self, length_m: f64, bend_per_m: f64) -> Self {
        let piece = ReferencePiece {
            start: self.end,
            course_rad: self.end_course_rad,
            bend_per_m,
            from_m: self.length_m,
            length_m: length_m.max(0.0),
        };
        (self.end, self.end_course_rad) = piece.at(piece.length_m);
        self.length_m += piece.length_m;
        self.pieces.push(piece);
        self
    }

    /// Length [m].
    pub(crate) fn length_m(&self) -> f64 {
        self.length_m
    }

    /// Place and direction of travel [rad] at `s_m` from the start; straight on before the start and past the end.
    pub(crate) fn at(&self, s_m: f64) -> (PlanePoint, f64) {
        if s_m >= self.length_m {
            return (ahead(self.end, self.end_course_rad, s_m - self.length_m), self.end_course_rad);
        }
        let first = &self.pieces[0];
        if s_m <= 0.0 {
            return (ahead(first.start, first.course_rad, s_m), first.course_rad);
        }
        let piece = self.pieces.iter().rev().find(|p| p.from_m <= s_m).unwrap_or(first);
        piece.at(s_m - piece.from_m)
    }

    /// Position of `place` on the reference [m from the start], searched from `from_m` forward within `window_m` by Newton's iteration
    /// on the distance along the tangent.
    pub(crate) fn project(&self, place: PlanePoint, from_m: f64, window_m: f64) -> f64 {
        let mut s_m = from_m;
        for _ in 0..4 {
            let (on, course) = self.at(s_m);
            let (sin, cos) = course.sin_cos();
            let step = (place.x_m - on.x_m) * cos + (place.y_m - on.y_m) * sin;
            s_m = if step.is_finite() { (s_m + step).clamp(from_m, from_m + window_m) } else { from_m };
        }
        s_m
    }
}

impl ReferencePiece {
    fn at(&self, s_m: f64) -> (PlanePoint, f64) {
        let turned = self.bend_per_m * s_m;
        // chord of an arc: s·sin(φ/2)/(φ/2), half way between the two directions
        let half = 0.5 * turned;
        let chord_m = s_m * if half.abs() < 1e-6 { 1.0 - half * half / 6.0 } else { half.sin() / half };
        (ahead(self.start, self.course_rad + half, chord_m), self.course_rad + turned)
    }
}

/// The point `by_m` from `from` in direction `course_rad`.
pub(crate) fn ahead(from: PlanePoint, course_rad: f64, by_m: f64) -> PlanePoint {
    let (sin, cos) = course_rad.sin_cos();
    PlanePoint::new(from.x_m + by_m * cos, from.y_m + by_m * sin)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::FRAC_PI_2;

    #[test]
    fn a_line_a_quarter_circle_and_a_line_end_where_geometry_says() {
        let reference = ReferenceLine::starting(PlanePoint::new(0.0, 0.0), 0.0).then(1.0, 0.0).then(FRAC_PI_2 * 2.0, 0.5).then(3.0, 0.0);
        let (end, course) = reference.at(reference.length_m());
        assert!(end.distance_m(PlanePoint::new(3.0, 5.0)) < 1e-12 && (course - FRAC_PI_2).abs() < 1e-12);
        let (past, _) = reference.at(reference.length_m() + 1.0);
        assert!(past.distance_m(PlanePoint::new(3.0, 6.0)) < 1e-12);
    }

    #[test]
    fn a_place_beside_the_line_is_projected_onto_it() {
        let reference = ReferenceLine::starting(PlanePoint::new(0.0, 0.0), 0.0).then(10.0, 0.0);
        assert!((reference.project(PlanePoint::new(4.0, 0.7), 3.5, 1.0) - 4.0).abs() < 1e-12);
        assert!((reference.project(PlanePoint::new(9.0, 0.7), 3.5, 1.0) - 4.5).abs() < 1e-12, "not beyond the window");
    }
}
