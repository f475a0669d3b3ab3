//! The frame in which a U-turn is planned, seen from the frame of a scene file.
//!
//! Planning starts at the origin, heads along y and turns left. A turn to the right is the mirror image.

use crate::guidance::{PathPose, PlanePoint, Polygon, Result};
use std::f64::consts::FRAC_PI_2;

/// Place and direction of the planning frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct PlaneFrame {
    /// Its origin in the file's frame [m].
    pub(crate) origin: PlanePoint,
    /// Direction of its y axis in the file's frame [rad].
    pub(crate) heading_rad: f64,
    /// Whether it is mirrored: its turn to the left is one to the right in the file's frame.
    pub(crate) mirrored: bool,
}

impl PlaneFrame {
    /// Direction of its x axis over that of a frame that is only turned.
    fn side(&self) -> f64 {
        if self.mirrored { -1.0 } else { 1.0 }
    }

    /// A point of the file's frame in the planning frame.
    pub(crate) fn inside(&self, point: PlanePoint) -> PlanePoint {
        let (sin, cos) = self.heading_rad.sin_cos();
        let (dx, dy) = (point.x_m - self.origin.x_m, point.y_m - self.origin.y_m);
        PlanePoint::new(self.side() * (dx * sin - dy * cos), dx * cos + dy * sin)
    }

    /// A point of the planning frame in the file's frame.
    pub(crate) fn outside(&self, point: PlanePoint) -> PlanePoint {
        let (sin, cos) = self.heading_rad.sin_cos();
        let x_m = self.side() * point.x_m;
        PlanePoint::new(self.origin.x_m + point.y_m * cos + x_m * sin, self.origin.y_m + point.y_m * sin - x_m * cos)
    }

    /// A polygon of the file's frame in the planning frame.
    ///
    /// # Errors
    /// Corners that rounding puts on a line.
    pub(crate) fn polygon_inside(&self, polygon: &Polygon) -> Result<Polygon> {
        Polygon::new(polygon.corners().iter().map(|corner| self.inside(*corner)).collect())
    }

    /// A pose of the planning frame in the file's frame.
    pub(crate) fn pose_outside(&self, pose: &PathPose) -> PathPose {
        let at = self.outside(PlanePoint::new(pose.x_m, pose.y_m));
        PathPose {
            x_m: at.x_m,
            y_m: at.y_m,
            heading_rad: self.heading_rad + self.side() * (pose.heading_rad - FRAC_PI_2),
            curvature_per_m: self.side() * pose.curvature_per_m,
            wheel_angle_rad: self.side() * pose.wheel_angle_rad,
            ..*pose
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_frame_and_back_is_the_same_place_and_left_of_it_is_right_when_mirrored() {
        for mirrored in [false, true] {
            let frame = PlaneFrame { origin: PlanePoint::new(2.0, -1.0), heading_rad: 0.7, mirrored };
            let point = PlanePoint::new(-3.0, 4.5);
            assert!(frame.outside(frame.inside(point)).distance_m(point) < 1e-12);
            // one metre ahead is (0, 1); what is on the left in the file is on the left, or on the right, in the frame
            let (sin, cos) = 0.7_f64.sin_cos();
            assert!(frame.inside(PlanePoint::new(2.0 + cos, -1.0 + sin)).distance_m(PlanePoint::new(0.0, 1.0)) < 1e-12);
            let left = frame.inside(PlanePoint::new(2.0 - sin, -1.0 + cos));
            assert!(left.distance_m(PlanePoint::new(if mirrored { 1.0 } else { -1.0 }, 0.0)) < 1e-12, "{left:?}");
        }
    }
}
