//! The checks of a parking path: no contact, no jump of the wheel or the curvature, the goal reached.

use crate::guidance::PosePath;
use crate::guidance::look_ahead::largest_steps;
use crate::guidance::parking::ParkingScene;
use serde::Serialize;

/// Results of the checks.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub(crate) struct PathJudgement {
    /// Distance of the last pose from the goal [m].
    pub position_m: f64,
    /// |heading error| of the last pose [rad].
    pub heading_rad: f64,
    /// Least distance of the body from an obstacle along the path [m], negative in a collision.
    pub clearance_m: f64,
    /// Largest change of the wheel angle per step [rad].
    pub wheel_step_rad: f64,
    /// Largest change of the curvature per step [1/m].
    pub curvature_step_per_m: f64,
    /// Whether every value is within its limit.
    pub pass: bool,
}

/// Judges a path in a scene.
pub(crate) fn judge(scene: &ParkingScene, path: &PosePath) -> PathJudgement {
    let (goal, obstacles) = (scene.goal(), scene.obstacles());
    let (position_m, heading_rad) = path.poses.last().map_or((f64::INFINITY, f64::INFINITY), |end| {
        let turns = (end.heading_rad - goal.heading_rad).sin_cos();
        ((end.x_m - goal.x_m).hypot(end.y_m - goal.y_m), turns.0.atan2(turns.1).abs())
    });
    let clearance_m = path
        .poses
        .iter()
        .map(|pose| scene.body.at_pose(pose))
        .fold(f64::INFINITY, |least_m, body| obstacles.iter().fold(least_m, |least_m, o| o.separation_or_m(&body, least_m)));
    let (wheel_step_rad, curvature_step_per_m) = largest_steps(path);
    let (limits, rounding) = (&scene.look_ahead, 1e-9);
    let pass = position_m <= scene.tolerance.position_m
        && heading_rad <= scene.tolerance.heading_rad
        && clearance_m >= scene.tolerance.clearance_m
        && wheel_step_rad <= limits.wheel_step_rad + rounding
        && curvature_step_per_m <= limits.curvature_step_per_m(scene.body.wheelbase_m) + rounding;
    PathJudgement { position_m, heading_rad, clearance_m, wheel_step_rad, curvature_step_per_m, pass }
}
