//! `[u_turn]`: a field, the start in it, and the ranges in which the turn is searched.
//!
//! The frame is the file's own: corners, lines and start are in the same one. The start is the pose of the rear axle's middle.

use crate::guidance::u_turn::{Car, Method, Ranges, UTurnScene, UTurnSettings};
use crate::guidance::{BodyShape, PlanePoint, Polygon};
use crate::map::toml_line;
use crate::scene::obstacle::polygon;
use crate::scene::plane_frame::PlaneFrame;
use crate::scene::ranges::{check, check_pair, ranged};
use crate::scene::{Error, Result};
use crate::units::RAD_PER_DEG;
use serde::{Deserialize, Serialize};

/// `[u_turn.start]`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct UTurnStartKeys {
    /// East [m].
    x_m: f64,
    /// North [m].
    y_m: f64,
    /// Heading [°], counter-clockwise from x.
    heading_deg: f64,
}

/// `[[u_turn.line]]`: a line on which the vehicle must not end.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct LineKeys {
    /// One end [m].
    from_m: [f64; 2],
    /// The other end [m].
    to_m: [f64; 2],
}

/// Side to which the vehicle turns.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum TurnSide {
    /// To the left.
    #[default]
    Left,
    /// To the right.
    Right,
}

/// `[u_turn]`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct UTurnKeys {
    /// Corners of the field [m]; the body stays inside.
    field_m: Vec<[f64; 2]>,
    start: UTurnStartKeys,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    line: Vec<LineKeys>,
    /// Side to which the vehicle turns.
    #[serde(default)]
    side: TurnSide,
    /// Distance that the body keeps from border and obstacles [m].
    #[serde(default = "clearance")]
    clearance_m: f64,
    /// Largest wheel angle [°].
    #[serde(default = "wheel_limit")]
    wheel_limit_deg: f64,
    /// Run-up, shortest and longest [m].
    run_up_m: [f64; 2],
    /// Speed of the point between the axles, lowest and highest [m/s].
    #[serde(default = "speeds")]
    speed_mps: [f64; 2],
    /// Rate of the wheel angle, lowest and highest [°/s].
    #[serde(default = "rates")]
    wheel_rate_deg_s: [f64; 2],
    /// Largest yaw rate [°/s].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    yaw_rate_deg_s: Option<f64>,
    /// Acceleration of the run-up [m/s²].
    #[serde(default = "acceleration")]
    run_up_accel_mps2: f64,
}

fn clearance() -> f64 {
    0.3
}
fn wheel_limit() -> f64 {
    60.0
}
fn speeds() -> [f64; 2] {
    [0.3, 0.8]
}
fn rates() -> [f64; 2] {
    [12.0, 40.0]
}
fn acceleration() -> f64 {
    0.5
}

/// What the planner of a U-turn needs.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct UTurnTask {
    /// The vehicle.
    pub(crate) car: Car,
    /// Field, obstacles and lines, in the planning frame.
    pub(crate) scene: UTurnScene,
    /// The search.
    pub(crate) ranges: Ranges,
    /// The computation.
    pub(crate) settings: UTurnSettings,
    /// The planning frame in the file's frame.
    pub(crate) frame: PlaneFrame,
    /// The field in the file's frame.
    pub(crate) field: Polygon,
    /// The obstacles in the file's frame.
    pub(crate) obstacles: Vec<Polygon>,
}

impl UTurnKeys {
    /// Checks every number and the field's shape.
    pub(crate) fn checked(&self, text: &str) -> Result<()> {
        let start = &self.start;
        check(
            text,
            ("u_turn.start", 0),
            &[
                ranged("x_m", start.x_m, -1000.0, 1000.0),
                ranged("y_m", start.y_m, -1000.0, 1000.0),
                ranged("heading_deg", start.heading_deg, -360.0, 360.0),
            ],
        )?;
        let numbers = [
            ranged("clearance_m", self.clearance_m, 0.0, 5.0),
            ranged("wheel_limit_deg", self.wheel_limit_deg, 5.0, 69.0),
            ranged("run_up_accel_mps2", self.run_up_accel_mps2, 0.01, 2.0),
        ];
        check(text, ("u_turn", 0), &numbers)?;
        if let Some(rate) = self.yaw_rate_deg_s {
            check(text, ("u_turn", 0), &[ranged("yaw_rate_deg_s", rate, 1.0, 720.0)])?;
        }
        check_pair(text, "u_turn", "run_up_m", self.run_up_m, [0.0, 1000.0])?;
        check_pair(text, "u_turn", "speed_mps", self.speed_mps, [0.05, 2.0])?;
        check_pair(text, "u_turn", "wheel_rate_deg_s", self.wheel_rate_deg_s, [1.0, 720.0])?;
        polygon(text, ("u_turn", 0), "field_m", &self.field_m)?;
        for (nth, line) in self.line.iter().enumerate() {
            let [from, to] = [line.from_m, line.to_m].map(|[x_m, y_m]| PlanePoint::new(x_m, y_m));
            let length_m = from.distance_m(to);
            if !(1e-3..=2000.0).contains(&length_m) {
                return Err(Error::Shape {
                    line: toml_line(text, ("u_turn.line", nth), "from_m"),
                    key: format!("u_turn.line {}", nth + 1),
                    problem: format!("its ends are {length_m} m apart; allowed: 0.001 to 2000 m"),
                });
            }
        }
        Ok(())
    }

    /// Side to which the vehicle turns.
    pub(crate) fn side(&self) -> TurnSide {
        self.side
    }

    /// The inputs of planning for a body and obstacles.
    ///
    /// # Errors
    /// Corners that rounding puts on a line.
    pub(crate) fn task(&self, body: BodyShape, obstacles: Vec<Polygon>) -> crate::guidance::Result<UTurnTask> {
        let heading_rad = self.start.heading_deg * RAD_PER_DEG;
        let (sin, cos) = heading_rad.sin_cos();
        // the control point is in the middle between the axles
        let half_m = 0.5 * body.wheelbase_m;
        let origin = PlanePoint::new(self.start.x_m + half_m * cos, self.start.y_m + half_m * sin);
        let frame = PlaneFrame { origin, heading_rad, mirrored: self.side == TurnSide::Right };
        let field = Polygon::new(self.field_m.iter().map(|[x_m, y_m]| PlanePoint::new(*x_m, *y_m)).collect())?;
        let lines = self.line.iter().map(|line| {
            let [a, b] = [line.from_m, line.to_m].map(|[x_m, y_m]| frame.inside(PlanePoint::new(x_m, y_m)));
            // from the far end to the near one
            if a.y_m >= b.y_m { (a, b) } else { (b, a) }
        });
        let scene = UTurnScene {
            field: frame.polygon_inside(&field)?,
            obstacles: obstacles.iter().map(|o| frame.polygon_inside(o)).collect::<crate::guidance::Result<_>>()?,
            lines: lines.collect(),
            clearance_m: self.clearance_m,
        };
        let ranges = Ranges {
            run_up_m: self.run_up_m,
            speed_mps: self.speed_mps,
            steering_rate_rad_s: self.wheel_rate_deg_s.map(|rate| rate * RAD_PER_DEG),
            yaw_rate_rad_s: self.yaw_rate_deg_s.map(|rate| rate * RAD_PER_DEG),
        };
        let settings = UTurnSettings {
            run_up_accel_mps2: self.run_up_accel_mps2,
            method: Method::RungeKutta,
            step_s: 0.02,
            ..UTurnSettings::default()
        };
        let car = Car { body, steering_ratio: 1.0, steering_limit_rad: self.wheel_limit_deg * RAD_PER_DEG };
        Ok(UTurnTask { car, scene, ranges, settings, frame, field, obstacles })
    }
}
