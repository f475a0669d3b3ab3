//! Plane geometry of bodies and obstacles: points, convex polygons, their distance or depth of overlap.
//!
//! The distance of two separate convex polygons is the least distance of an edge of one from a corner of the other. The depth of overlap is
//! the shortest translation that separates them, along the edges' normals (Source: Ericson, *Real-Time Collision Detection*, §5.2.1 and
//! §5.1.9).

use crate::guidance::{Error, Result};
use serde::Serialize;

/// A point of the plane.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct PlanePoint {
    /// East of the origin [m].
    pub x_m: f64,
    /// North of the origin [m].
    pub y_m: f64,
}

impl PlanePoint {
    /// At (x, y) [m].
    pub const fn new(x_m: f64, y_m: f64) -> Self {
        Self { x_m, y_m }
    }

    /// Whether both coordinates are finite.
    pub fn is_finite(self) -> bool {
        self.x_m.is_finite() && self.y_m.is_finite()
    }

    /// Distance to another point [m].
    pub fn distance_m(self, other: Self) -> f64 {
        (self.x_m - other.x_m).hypot(self.y_m - other.y_m)
    }

    /// Distance to the segment from `a` to `b` [m].
    pub fn segment_distance_m(self, a: Self, b: Self) -> f64 {
        let (dx, dy) = (b.x_m - a.x_m, b.y_m - a.y_m);
        let length2 = dx * dx + dy * dy;
        let along = if length2 > 0.0 { (((self.x_m - a.x_m) * dx + (self.y_m - a.y_m) * dy) / length2).clamp(0.0, 1.0) } else { 0.0 };
        self.distance_m(Self::new(a.x_m + along * dx, a.y_m + along * dy))
    }
}

/// A convex polygon, corners counter-clockwise.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Polygon {
    corners: Vec<PlanePoint>,
}

impl Polygon {
    /// A polygon of at least three corners in either sense of rotation.
    ///
    /// # Errors
    /// Fewer than three corners, one that is not finite, or corners that are repeated, on one line, or not convex.
    pub fn new(mut corners: Vec<PlanePoint>) -> Result<Self> {
        let n = corners.len();
        if n < 3 {
            return Err(Error::Polygon { corners: n, problem: "needs at least 3 corners" });
        }
        if corners.iter().any(|c| !c.is_finite()) {
            return Err(Error::Polygon { corners: n, problem: "has a corner that is not a number" });
        }
        let turn = |k: usize| cross(corners[k], corners[(k + 1) % n], corners[(k + 2) % n]);
        let left = (0..n).all(|k| turn(k) > 0.0);
        if !left && !(0..n).all(|k| turn(k) < 0.0) {
            return Err(Error::Polygon { corners: n, problem: "is not convex, or has repeated corners or three on a line" });
        }
        if !left {
            corners.reverse();
        }
        Ok(Self { corners })
    }

    /// Without the check; only for the body's rectangle.
    pub(crate) fn trusted(corners: Vec<PlanePoint>) -> Self {
        Self { corners }
    }

    /// Corners, counter-clockwise.
    pub fn corners(&self) -> &[PlanePoint] {
        &self.corners
    }

    /// Distance of two polygons [m]; negative when they overlap: the shortest translation that separates them.
    pub fn separation_m(&self, other: &Self) -> f64 {
        let gap = self.widest_axis_gap_m(other).max(other.widest_axis_gap_m(self));
        if gap > 0.0 { self.corner_distance_m(other).min(other.corner_distance_m(self)) } else { gap }
    }

    /// The smaller one of `most_m` and the distance of two polygons [m]: faster where they are further apart than that.
    pub fn separation_or_m(&self, other: &Self, most_m: f64) -> f64 {
        let gap = self.widest_axis_gap_m(other).max(other.widest_axis_gap_m(self));
        match gap {
            // the gap along an edge's normal is never more than the distance
            gap if gap >= most_m => most_m,
            gap if gap > 0.0 => most_m.min(self.corner_distance_m(other).min(other.corner_distance_m(self))),
            gap => gap,
        }
    }

    /// How far `inner` is inside this polygon [m]: the least distance of its corners from the edges' lines, negative when one is outside.
    pub fn inside_margin_m(&self, inner: &Self) -> f64 {
        let margin = |(a, b): (PlanePoint, PlanePoint)| {
            inner.corners.iter().map(|&c| cross(a, b, c) / a.distance_m(b)).fold(f64::INFINITY, f64::min)
        };
        self.edges().map(margin).fold(f64::INFINITY, f64::min)
    }

    /// Edges, counter-clockwise.
    pub fn edges(&self) -> impl Iterator<Item = (PlanePoint, PlanePoint)> {
        let n = self.corners.len();
        (0..n).map(move |k| (self.corners[k], self.corners[(k + 1) % n]))
    }

    /// Largest gap of `other` beyond one of this polygon's edges [m].
    fn widest_axis_gap_m(&self, other: &Self) -> f64 {
        let gap = |(a, b): (PlanePoint, PlanePoint)| {
            other.corners.iter().map(|&c| -cross(a, b, c) / a.distance_m(b)).fold(f64::INFINITY, f64::min)
        };
        self.edges().map(gap).fold(f64::NEG_INFINITY, f64::max)
    }

    fn corner_distance_m(&self, other: &Self) -> f64 {
        let nearest = |c: PlanePoint| self.edges().map(|(a, b)| c.segment_distance_m(a, b)).fold(f64::INFINITY, f64::min);
        other.corners.iter().map(|&c| nearest(c)).fold(f64::INFINITY, f64::min)
    }
}

/// Twice the area of the triangle a, b, c; positive when c lies left of the line from a to b.
fn cross(a: PlanePoint, b: PlanePoint, c: PlanePoint) -> f64 {
    (b.x_m - a.x_m) * (c.y_m - a.y_m) - (b.y_m - a.y_m) * (c.x_m - a.x_m)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use proptest::prelude::*;

    fn square(x: f64, y: f64, half: f64) -> Polygon {
        let at = |sx: f64, sy: f64| PlanePoint::new(x + sx * half, y + sy * half);
        Polygon::new(vec![at(-1.0, -1.0), at(1.0, -1.0), at(1.0, 1.0), at(-1.0, 1.0)]).unwrap()
    }

    #[test]
    fn separate_polygons_have_a_distance_and_overlapping_ones_a_depth() {
        let one = square(0.0, 0.0, 1.0);
        assert!((one.separation_m(&square(3.0, 0.0, 1.0)) - 1.0).abs() < 1e-12);
        assert!((one.separation_m(&square(5.0, 6.0, 1.0)) - 5.0).abs() < 1e-12, "corner to corner: 3, 4, 5");
        assert!((one.separation_m(&square(1.7, 0.2, 1.0)) + 0.3).abs() < 1e-12);
        // a square on its corner: the corner at (√2, 0) seen from an edge at 2
        let tip = Polygon::new(
            (0..4)
                .map(|k| f64::from(k) * std::f64::consts::FRAC_PI_2)
                .map(|t| PlanePoint::new(t.cos() * 2.0_f64.sqrt(), t.sin() * 2.0_f64.sqrt()))
                .collect(),
        )
        .unwrap();
        assert!((tip.separation_m(&square(3.0, 0.0, 1.0)) - (2.0 - 2.0_f64.sqrt())).abs() < 1e-12);
    }

    #[test]
    fn inside_it_is_the_distance_from_the_nearest_edge() {
        let (field, body) = (square(0.0, 0.0, 5.0), square(3.0, 1.0, 1.0));
        assert!((field.inside_margin_m(&body) - 1.0).abs() < 1e-12);
        assert!((field.inside_margin_m(&square(4.5, 0.0, 1.0)) + 0.5).abs() < 1e-12);
    }

    #[test]
    fn a_polygon_that_is_not_convex_is_an_error() {
        let p = PlanePoint::new;
        assert!(Polygon::new(vec![p(0.0, 0.0), p(1.0, 0.0)]).is_err());
        assert!(Polygon::new(vec![p(0.0, 0.0), p(1.0, 0.0), p(1.0, 0.0)]).is_err());
        assert!(Polygon::new(vec![p(0.0, 0.0), p(1.0, 0.0), p(f64::NAN, 1.0)]).is_err());
        assert!(Polygon::new(vec![p(0.0, 0.0), p(4.0, 0.0), p(1.0, 1.0), p(0.0, 4.0)]).is_err());
    }

    proptest! {
        #[test]
        fn the_separation_is_the_same_from_either_side(x in -4.0..4.0f64, y in -4.0..4.0f64, half in 0.2..3.0f64) {
            let (one, other) = (square(0.0, 0.0, 1.0), square(x, y, half));
            prop_assert!((one.separation_m(&other) - other.separation_m(&one)).abs() < 1e-9);
            for most_m in [0.3, 1.0, f64::INFINITY] {
                prop_assert_eq!(one.separation_or_m(&other, most_m), one.separation_m(&other).min(most_m));
            }
        }
    }
}
