//! `[parking]`: a slot in a row, and the start beside it.
//!
//! Frame: x along the row in the direction of travel, y away from it; the row's edge is y = 0, the middle of the slot's mouth the origin. The
//! pose is that of the rear axle's middle.

use crate::guidance::parking::{ParkingMethod, ParkingScene, ParkingStart, Slot};
use crate::guidance::{BodyShape, Polygon};
use crate::scene::Result;
use crate::scene::ranges::{check, ranged};
use crate::units::RAD_PER_DEG;
use serde::{Deserialize, Serialize};

/// `[parking.slot]`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct SlotKeys {
    /// Width across its axis [m].
    width_m: f64,
    /// Depth along its axis [m].
    depth_m: f64,
    /// Width of the aisle before the row [m].
    aisle_m: f64,
    /// Angle of its axis against the row [°]; 90 is perpendicular.
    #[serde(default = "perpendicular")]
    angle_deg: f64,
    /// Whether the neighbour on the side of the vehicle's way is an obstacle.
    #[serde(default = "yes")]
    obstacle_right: bool,
    /// Whether the other neighbour is one.
    #[serde(default = "yes")]
    obstacle_left: bool,
}

/// `[parking.start]`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct ParkingStartKeys {
    /// Along the row [m].
    x_m: f64,
    /// Away from the row's edge [m].
    y_m: f64,
    /// Heading [°]; 0 is along the row.
    #[serde(default)]
    heading_deg: f64,
    /// Wheel angle [°], left positive.
    #[serde(default)]
    wheel_angle_deg: f64,
}

/// Choices of line and circle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum ParkingChoice {
    /// Those of this planner.
    #[default]
    Grown,
    /// The published ones.
    Published,
}

/// `[parking]`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct ParkingKeys {
    slot: SlotKeys,
    start: ParkingStartKeys,
    /// Whether the vehicle goes in forward.
    #[serde(default)]
    nose_in: bool,
    /// Set speed of the front wheel [m/s].
    #[serde(default = "cruise")]
    cruise_mps: f64,
    /// Largest wheel angle of the plan [°].
    #[serde(default = "wheel_limit")]
    wheel_limit_deg: f64,
    /// Distance of the body from the row on the first line [m].
    #[serde(default = "line_distance")]
    line_distance_m: f64,
    /// Distance that is planned for from the obstacle's corner and the slot's end [m].
    #[serde(default = "safety")]
    safety_m: f64,
    /// Least distance of the body from every obstacle [m].
    #[serde(default = "clearance")]
    clearance_m: f64,
    /// Choices of line and circle.
    #[serde(default)]
    method: ParkingChoice,
}

fn perpendicular() -> f64 {
    90.0
}
fn yes() -> bool {
    true
}
fn cruise() -> f64 {
    0.4
}
fn wheel_limit() -> f64 {
    60.0
}
fn line_distance() -> f64 {
    1.0
}
fn safety() -> f64 {
    0.2
}
fn clearance() -> f64 {
    0.1
}

/// What the planner of parking needs.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct ParkingTask {
    /// Slot, body, obstacles and settings.
    pub(crate) scene: ParkingScene,
    /// The start.
    pub(crate) start: ParkingStart,
    /// Set speed of the front wheel [m/s].
    pub(crate) cruise_mps: f64,
}

impl ParkingKeys {
    /// Checks every number.
    pub(crate) fn checked(&self, text: &str) -> Result<()> {
        let (slot, start) = (&self.slot, &self.start);
        check(
            text,
            ("parking.slot", 0),
            &[
                ranged("width_m", slot.width_m, 0.0, 100.0),
                ranged("depth_m", slot.depth_m, 0.0, 100.0),
                ranged("aisle_m", slot.aisle_m, 0.0, 1000.0),
                ranged("angle_deg", slot.angle_deg, 30.0, 150.0),
            ],
        )?;
        check(
            text,
            ("parking.start", 0),
            &[
                ranged("x_m", start.x_m, -100.0, 100.0),
                ranged("y_m", start.y_m, -100.0, 100.0),
                ranged("heading_deg", start.heading_deg, -180.0, 180.0),
                ranged("wheel_angle_deg", start.wheel_angle_deg, -69.0, 69.0),
            ],
        )?;
        check(
            text,
            ("parking", 0),
            &[
                ranged("cruise_mps", self.cruise_mps, 0.1, 2.0),
                ranged("wheel_limit_deg", self.wheel_limit_deg, 10.0, 69.0),
                ranged("line_distance_m", self.line_distance_m, 0.0, 10.0),
                ranged("safety_m", self.safety_m, 0.0, 5.0),
                ranged("clearance_m", self.clearance_m, 0.0, 5.0),
            ],
        )
    }

    /// Whether the vehicle goes in forward.
    pub(crate) fn nose_in(&self) -> bool {
        self.nose_in
    }

    /// Angle of the slot's axis against the row [°].
    pub(crate) fn angle_deg(&self) -> f64 {
        self.slot.angle_deg
    }

    /// The inputs of planning for a body and further obstacles.
    pub(crate) fn task(&self, body: BodyShape, others: Vec<Polygon>) -> ParkingTask {
        let slot = Slot {
            width_m: self.slot.width_m,
            depth_m: self.slot.depth_m,
            angle_rad: self.slot.angle_deg * RAD_PER_DEG,
            obstacle_right: self.slot.obstacle_right,
            obstacle_left: self.slot.obstacle_left,
            aisle_m: self.slot.aisle_m,
        };
        let mut scene = ParkingScene::new(body, slot);
        scene.nose_in = self.nose_in;
        scene.look_ahead.wheel_limit_rad = self.wheel_limit_deg * RAD_PER_DEG;
        scene.look_ahead.distance_m = 0.4 * body.wheelbase_m;
        scene.line_distance_m = self.line_distance_m;
        scene.safety_m = self.safety_m;
        scene.tolerance.clearance_m = self.clearance_m;
        scene.others = others;
        if self.method == ParkingChoice::Published {
            scene.method = ParkingMethod::published();
        }
        let start = ParkingStart {
            x_m: self.start.x_m,
            y_m: self.start.y_m,
            heading_rad: self.start.heading_deg * RAD_PER_DEG,
            wheel_angle_rad: self.start.wheel_angle_deg * RAD_PER_DEG,
        };
        ParkingTask { scene, start, cruise_mps: self.cruise_mps }
    }
}
