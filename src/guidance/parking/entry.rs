//! The entry circle: tangent to the first line and to the slot's axis, past the corner of the obstacle on the vehicle's side.
//!
//! With the axis u = (cos φ, sin φ) outward and n = (sin φ, −cos φ) to its right, the circle of radius R that touches the line y = y₁ and the axis
//! has its centre at
//!
//! ```text
//! C = t u + R n      t = (y₁ − R (1 − cos φ))/sin φ
//! ```
//!
//! when it backs in. Nose in, it is on the other side: C = t u − R n, t = (y₁ − R (1 + cos φ))/sin φ.
//!
//! The body's inner side is R − W/2 from C. It passes the corner P with the safety distance d when |C − P| ≤ R − W/2 − d. At φ = 90° this is
//! R = c − √(2 (a − b)(y₁ − b)) or more, with a half the slot's width, b = W/2 + d, c = a + y₁ − b. Without an obstacle on the right, the
//! vehicle's own smallest circle is the entry circle.

use crate::guidance::parking::ParkingScene;
use crate::guidance::{Error, Result};
use serde::Serialize;

/// An entry circle.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub(crate) struct SlotEntry {
    /// Radius of the rear axle's middle [m].
    pub radius_m: f64,
    /// Point of contact with the first line, along the row [m].
    pub line_x_m: f64,
    /// Point of contact with the slot's axis, outward from the mouth [m].
    pub axis_m: f64,
    /// Distance of the body's inner side from the obstacle's corner [m]; infinite without an obstacle.
    pub corner_clearance_m: f64,
}

impl ParkingScene {
    /// Smallest radius that planning uses: at the wheel limit less the reserve [m].
    pub(crate) fn least_radius_m(&self) -> f64 {
        self.body.wheelbase_m / (self.look_ahead.wheel_limit_rad - self.wheel_reserve_rad).tan()
    }

    /// The circle of a radius [m] from the first line.
    pub(crate) fn circle(&self, radius_m: f64) -> SlotEntry {
        self.circle_at(radius_m, self.line_m())
    }

    /// The circle of a radius [m] from a first line y = `line_m`.
    pub(crate) fn circle_at(&self, radius_m: f64, line_m: f64) -> SlotEntry {
        let (sin, cos) = self.slot.angle_rad.sin_cos();
        let (side, obstacle) = if self.nose_in { (-1.0, self.slot.obstacle_left) } else { (1.0, self.slot.obstacle_right) };
        let axis_m = (line_m - radius_m * (1.0 - side * cos)) / sin;
        let (x, y) = (axis_m * cos + side * radius_m * sin, axis_m * sin - side * radius_m * cos);
        let corner = self.corner();
        let clearance = radius_m - 0.5 * self.body.width_m - (x - corner.x_m).hypot(y - corner.y_m);
        SlotEntry { radius_m, line_x_m: x, axis_m, corner_clearance_m: if obstacle { clearance } else { f64::INFINITY } }
    }
}

/// The smallest entry circle.
///
/// # Errors
/// No circle passes the corner; the error holds the nearest width of the slot at which one does.
pub(crate) fn entry_circle(scene: &ParkingScene) -> Result<SlotEntry> {
    let least_m = scene.least_radius_m();
    if let Some(entry) = smallest(scene) {
        return Ok(entry);
    }
    // the corner's clearance grows with the width; double it until a circle fits, then bisect
    let fits = |width_m: f64| {
        let mut wider = scene.clone();
        wider.slot.width_m = width_m;
        smallest(&wider).is_some()
    };
    let (mut low, mut high) = (scene.slot.width_m, scene.slot.width_m.max(0.1) * 2.0);
    for _ in 0..10 {
        if fits(high) {
            break;
        }
        (low, high) = (high, 2.0 * high);
    }
    for _ in 0..40 {
        let middle = 0.5 * (low + high);
        if fits(middle) {
            high = middle;
        } else {
            low = middle;
        }
    }
    Err(Error::RadiusTooLarge { radius_m: least_m, found_m: scene.slot.width_m, nearest_m: high })
}

/// The clearance is concave in R: up to its peak by golden section, then the first R at which it suffices by bisection.
fn smallest(scene: &ParkingScene) -> Option<SlotEntry> {
    let least_m = scene.least_radius_m();
    let enough = |radius_m: f64| scene.circle(radius_m).corner_clearance_m >= scene.safety_m - 1e-12;
    if enough(least_m) {
        return Some(scene.circle(least_m));
    }
    let (mut low, mut high) = (least_m, least_m + 4.0 * (scene.line_m() + scene.slot.width_m));
    for _ in 0..80 {
        let (a, b) = (low + 0.382 * (high - low), low + 0.618 * (high - low));
        if scene.circle(a).corner_clearance_m < scene.circle(b).corner_clearance_m {
            low = a;
        } else {
            high = b;
        }
    }
    let peak = 0.5 * (low + high);
    if !enough(peak) {
        return None;
    }
    let (mut low, mut high) = (least_m, peak);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if enough(middle) {
            high = middle;
        } else {
            low = middle;
        }
    }
    Some(scene.circle(high))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::guidance::parking::scene::usual_scene;

    #[test]
    fn at_a_right_angle_the_search_finds_the_closed_form() {
        let scene = usual_scene(90.0);
        let (a, b, y1) = (0.5 * scene.slot.width_m, 0.5 * scene.body.width_m + 0.2, scene.line_m());
        let closed = a + y1 - b - (2.0 * (a - b) * (y1 - b)).sqrt();
        let entry = entry_circle(&scene).unwrap();
        assert!((entry.radius_m - closed).abs() < 1e-9, "{} for {closed}", entry.radius_m);
        assert!((entry.corner_clearance_m - 0.2).abs() < 1e-9);
        assert!((entry.axis_m - (y1 - closed)).abs() < 1e-9 && (entry.line_x_m - closed).abs() < 1e-9);
    }

    #[test]
    fn without_an_obstacle_the_wheel_limit_determines_the_circle() {
        let mut scene = usual_scene(90.0);
        scene.slot.obstacle_right = false;
        let entry = entry_circle(&scene).unwrap();
        assert!((entry.radius_m - 0.9 / 65.0_f64.to_radians().tan()).abs() < 1e-12);
    }

    #[test]
    fn a_radius_too_large_names_the_width_from_which_it_fits() {
        let mut scene = usual_scene(90.0);
        scene.look_ahead.wheel_limit_rad = 25.0_f64.to_radians();
        let Err(Error::RadiusTooLarge { nearest_m, .. }) = entry_circle(&scene) else { panic!() };
        scene.slot.width_m = nearest_m + 1e-6;
        assert!(entry_circle(&scene).is_ok());
        scene.slot.width_m = nearest_m - 1e-3;
        assert!(entry_circle(&scene).is_err());
    }
}
