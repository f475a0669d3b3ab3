//! The slot, the obstacles around it, and the parked pose.

use crate::guidance::body::within;
use crate::guidance::look_ahead::LookAhead;
use crate::guidance::parking::Tolerance;
use crate::guidance::parking::method::{FirstLine, ParkingMethod};
use crate::guidance::parking::start::ParkingStart;
use crate::guidance::{BodyShape, Error, PlanePoint, Polygon, Result};
use crate::map::Gear;
use serde::Serialize;

/// A slot in a row.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub(crate) struct Slot {
    /// Width across its axis [m].
    pub width_m: f64,
    /// Depth along its axis [m].
    pub depth_m: f64,
    /// Angle from the row's direction to the slot's axis, outward [rad], 30° to 150°; 90° is perpendicular.
    pub angle_rad: f64,
    /// Whether there is an obstacle on the right of the parked driver: the side from which the vehicle backs in.
    pub obstacle_right: bool,
    /// Whether there is an obstacle on the left.
    pub obstacle_left: bool,
    /// Width of the aisle before the row [m].
    pub aisle_m: f64,
}

impl Slot {
    /// A perpendicular slot between two obstacles, 0.2 m wider than necessary and deep enough, with an aisle of three lengths.
    pub(crate) fn usual(body: &BodyShape, safety_m: f64) -> Self {
        Self {
            width_m: body.width_m + 2.0 * safety_m + 0.2,
            depth_m: body.length_m() + 2.0 * safety_m,
            angle_rad: std::f64::consts::FRAC_PI_2,
            obstacle_right: true,
            obstacle_left: true,
            aisle_m: 3.0 * body.length_m(),
        }
    }
}

/// The inputs of planning.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct ParkingScene {
    /// Outline.
    pub body: BodyShape,
    /// Slot.
    pub slot: Slot,
    /// Whether the vehicle goes in forward and parks with its nose to the slot's end. Default no: it backs in.
    pub nose_in: bool,
    /// Settings of following lines and circles.
    pub look_ahead: LookAhead,
    /// Distance of the body from the row on the first line [m]. Default 1.
    pub line_distance_m: f64,
    /// Safety distance from the obstacle's corner and the slot's end [m]. Default 0.2.
    pub safety_m: f64,
    /// Wheel angle that circles reserve for the tracking [rad]. Default 5°.
    pub wheel_reserve_rad: f64,
    /// Tolerances of the parked pose.
    pub tolerance: Tolerance,
    /// Choices where this planner departs from the published method.
    pub method: ParkingMethod,
    /// Further obstacles beside those that bound slot and aisle. Default none. No path is planned around them: they refuse paths.
    pub others: Vec<Polygon>,
}

impl ParkingScene {
    /// The defaults for a body and a slot.
    pub(crate) fn new(body: BodyShape, slot: Slot) -> Self {
        Self {
            body,
            slot,
            nose_in: false,
            look_ahead: LookAhead::default(),
            line_distance_m: 1.0,
            safety_m: 0.2,
            wheel_reserve_rad: 5.0_f64.to_radians(),
            tolerance: Tolerance::default(),
            method: ParkingMethod::default(),
            others: Vec::new(),
        }
    }

    /// Checks every number, and that the vehicle fits into the slot.
    ///
    /// # Errors
    /// The first number out of its range; a slot too narrow or too shallow, with the nearest feasible size.
    pub(crate) fn checked(self) -> Result<Self> {
        self.body.checked()?;
        self.look_ahead.checked()?;
        self.tolerance.checked()?;
        self.method.checked()?;
        within("line_distance_m", self.line_distance_m, 0.0, 10.0, "0 to 10")?;
        within("safety_m", self.safety_m, 0.0, 5.0, "0 to 5")?;
        within("wheel_reserve_rad", self.wheel_reserve_rad, 0.0, 0.9 * self.look_ahead.wheel_limit_rad, "0 to 0.9 of the wheel's limit")?;
        let slot = &self.slot;
        within("slot.width_m", slot.width_m, 0.0, 100.0, "0 to 100")?;
        within("slot.depth_m", slot.depth_m, 0.0, 100.0, "0 to 100")?;
        within("slot.angle_rad", slot.angle_rad, 30.0_f64.to_radians() - 1e-9, 150.0_f64.to_radians() + 1e-9, "30° to 150°")?;
        within("slot.aisle_m", slot.aisle_m, 0.0, 1000.0, "0 to 1000")?;
        let nearest_m = self.least_width_m();
        // 1e-9: a slot of exactly the least width, written as a sum
        if slot.width_m < nearest_m - 1e-9 {
            return Err(Error::SlotTooNarrow {
                found_m: slot.width_m,
                vehicle_m: self.body.width_m,
                clearance_m: self.safety_m,
                nearest_m,
            });
        }
        let (sin, cos) = slot.angle_rad.sin_cos();
        let nearest_m = self.body.length_m() + (self.safety_m + self.body.width_m * cos.abs()) / sin;
        if slot.depth_m < nearest_m - 1e-9 {
            return Err(Error::SlotTooShallow { found_m: slot.depth_m, nearest_m });
        }
        Ok(self)
    }

    /// Least width of the slot: the vehicle's with the safety distance on either side [m].
    pub(crate) fn least_width_m(&self) -> f64 {
        self.body.width_m + 2.0 * self.safety_m
    }

    /// Distance of the first line from the row's edge, for the middle of the rear axle [m].
    pub(crate) fn line_m(&self) -> f64 {
        self.line_distance_m + 0.5 * self.body.width_m
    }

    /// The scene with the first line that the method chooses for a start: within the aisle, the safety distance from its borders.
    pub(crate) fn with_line_for(&self, start: ParkingStart) -> Self {
        if self.method.first_line == FirstLine::SetDistance {
            return self.clone();
        }
        let most_m = (self.slot.aisle_m - self.body.width_m - self.safety_m).max(self.safety_m);
        Self { line_distance_m: (start.y_m - 0.5 * self.body.width_m).max(self.safety_m).min(most_m), ..self.clone() }
    }

    /// Direction of travel into the slot.
    pub(crate) fn gear_in(&self) -> Gear {
        if self.nose_in { Gear::Forward } else { Gear::Reverse }
    }

    /// Direction of travel out of the slot.
    pub(crate) fn gear_out(&self) -> Gear {
        if self.nose_in { Gear::Reverse } else { Gear::Forward }
    }

    /// Parked position of the rear axle's middle along the slot's axis from the mouth [m], negative inside: the rear, or the nose, keeps
    /// the safety distance from the slot's end.
    pub(crate) fn parked_at_m(&self) -> f64 {
        let (sin, cos) = self.slot.angle_rad.sin_cos();
        let before_m = if self.nose_in { self.body.length_m() - self.body.rear_overhang_m } else { self.body.rear_overhang_m };
        -self.slot.depth_m + before_m + (self.safety_m + 0.5 * self.body.width_m * cos.abs()) / sin
    }

    /// The goal pose.
    pub(crate) fn goal(&self) -> ParkingStart {
        let (sin, cos) = self.slot.angle_rad.sin_cos();
        let t = self.parked_at_m();
        let heading_rad = self.slot.angle_rad + if self.nose_in { std::f64::consts::PI } else { 0.0 };
        ParkingStart { x_m: t * cos, y_m: t * sin, heading_rad, wheel_angle_rad: 0.0 }
    }

    /// Corner of the obstacle at the slot's mouth on the side from which the vehicle comes: on the right as it backs in, on the left, which it reaches
    /// first, nose in.
    pub(crate) fn corner(&self) -> PlanePoint {
        let half = 0.5 * self.slot.width_m / self.slot.angle_rad.sin();
        PlanePoint::new(if self.nose_in { -half } else { half }, 0.0)
    }

    /// The obstacles: the neighbours, the end of the slot, the other side of the aisle, and the further ones.
    pub(crate) fn obstacles(&self) -> Vec<Polygon> {
        let (slot, (sin, cos)) = (&self.slot, self.slot.angle_rad.sin_cos());
        let (dx, dy) = (-slot.depth_m * cos, -slot.depth_m * sin);
        let half = 0.5 * slot.width_m / sin;
        // a neighbour extends as far as the vehicle can reach
        let far = 30.0 + slot.aisle_m + slot.depth_m;
        let neighbour = |from: f64, to: f64| {
            Polygon::trusted(vec![
                PlanePoint::new(from, 0.0),
                PlanePoint::new(from + dx, dy),
                PlanePoint::new(to + dx, dy),
                PlanePoint::new(to, 0.0),
            ])
        };
        let band = |low: f64, high: f64| {
            Polygon::trusted(vec![
                PlanePoint::new(-far, low),
                PlanePoint::new(far, low),
                PlanePoint::new(far, high),
                PlanePoint::new(-far, high),
            ])
        };
        let mut all = vec![band(dy - 1.0, dy), band(slot.aisle_m, slot.aisle_m + 1.0)];
        if slot.obstacle_right {
            all.push(neighbour(half, half + far));
        }
        if slot.obstacle_left {
            all.push(neighbour(-half - far, -half));
        }
        all.extend(self.others.iter().cloned());
        all
    }
}

/// The usual slot for a vehicle of wheelbase 0.9 m, slanted by `angle_deg` and deep enough for that, for tests.
#[cfg(test)]
pub(crate) fn usual_scene(angle_deg: f64) -> ParkingScene {
    let body = BodyShape::usual(0.9);
    let mut slot = Slot::usual(&body, 0.2);
    slot.angle_rad = angle_deg.to_radians();
    slot.depth_m = (body.length_m() + (0.3 + body.width_m * slot.angle_rad.cos().abs()) / slot.angle_rad.sin()).max(slot.depth_m);
    ParkingScene::new(body, slot)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn a_slot_too_small_is_an_error_with_the_nearest_feasible_size() {
        let mut narrow = usual_scene(90.0);
        narrow.slot.width_m = 1.0;
        let error = narrow.clone().checked().unwrap_err();
        let Error::SlotTooNarrow { nearest_m, .. } = error else { panic!("{error}") };
        assert!((nearest_m - 1.12).abs() < 1e-12, "0.72 m and twice 0.2 m");
        narrow.slot.width_m = nearest_m;
        assert!(narrow.checked().is_ok());
        let mut shallow = usual_scene(90.0);
        shallow.slot.depth_m = 1.2;
        let Err(Error::SlotTooShallow { nearest_m, .. }) = shallow.clone().checked() else { panic!() };
        shallow.slot.depth_m = nearest_m;
        assert!(shallow.checked().is_ok());
    }

    #[test]
    fn the_parked_vehicle_keeps_its_distances() {
        for (angle, nose_in) in [(60.0_f64, false), (90.0, false), (120.0, false), (90.0, true), (120.0, true)] {
            let mut scene = usual_scene(angle);
            scene.nose_in = nose_in;
            let goal = scene.goal();
            let body = scene.body.at(goal.x_m, goal.y_m, goal.heading_rad);
            let gap = scene.obstacles().iter().map(|o| o.separation_m(&body)).fold(f64::INFINITY, f64::min);
            assert!((gap - 0.2).abs() < 1e-9, "{angle}°: {gap}");
        }
    }

    #[test]
    fn the_obstacles_are_convex_and_counter_clockwise() {
        for obstacle in usual_scene(90.0).obstacles() {
            assert_eq!(Polygon::new(obstacle.corners().to_vec()).unwrap(), obstacle);
        }
    }
}
