//! Parking and the U-turn planned for a vehicle: the path, and the obstacles and borders.

use crate::guidance::{BodyShape, PlanePoint, Polygon, PosePath, parking, u_turn};
use crate::manoeuvre::Result;
use crate::manoeuvre::error::Error;
use crate::scene::{ManoeuvreScene, UTurnTask};
use crate::units::RAD_PER_DEG;
use serde::Serialize;

/// The task that is planned and driven.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum PlannedTask {
    /// Into a slot, in reverse or nose in.
    Parking {
        /// Angle of the slot's axis against the row [°].
        angle_deg: f64,
        /// Whether there is an obstacle on the side from which the vehicle backs in.
        obstacle_right: bool,
        /// Whether the vehicle goes in forward.
        nose_in: bool,
    },
    /// Into a perpendicular slot with the published choices of line and circle.
    ParkingPublished,
    /// Into a slot from an aisle so narrow, with a turning circle so large, that no single entry ends straight.
    ParkingShuffle,
    /// A U-turn around the end of a shelf into the next aisle.
    UTurn,
    /// The slot or the field of a scene file.
    Given(Box<ManoeuvreScene>),
}

/// A task planned for a vehicle.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Planned {
    /// The path of the rear axle's middle.
    pub path: PosePath,
    /// Outline of the vehicle.
    pub body: BodyShape,
    /// The body stays inside; `None` for parking, whose obstacles close the aisle.
    pub field: Option<Polygon>,
    /// The body stays outside.
    pub obstacles: Vec<Polygon>,
    /// Speed along the path [m/s], front wheel.
    pub cruise_mps: f64,
    /// Smallest distance of the planned path's body from field and obstacles [m].
    pub clearance_m: f64,
    /// Moves of a parking path, and those of them along the slot's axis after the entry.
    pub moves: Option<[usize; 2]>,
}

/// Wheel limit of both manoeuvres: it leaves 9° of the tracking limit of 69° as a reserve.
const WHEEL_LIMIT_RAD: f64 = 60.0 * RAD_PER_DEG;

impl PlannedTask {
    /// Plans the task for a vehicle of a wheelbase [m], with the usual outline; slot and aisles are in proportion.
    ///
    /// # Errors
    /// A wheelbase for which no path is found.
    pub fn plan(&self, wheelbase_m: f64) -> Result<Planned> {
        match *self {
            Self::Parking { angle_deg, obstacle_right, nose_in } => {
                let (mut scene, start) = parking_scene(wheelbase_m, angle_deg, obstacle_right);
                scene.nose_in = nose_in;
                parked(&scene, start, 0.4)
            }
            Self::ParkingPublished => {
                let (mut scene, start) = parking_scene(wheelbase_m, 90.0, true);
                scene.method = parking::ParkingMethod::published();
                parked(&scene, start, 0.2)
            }
            Self::ParkingShuffle => {
                let (scene, start) = shuffle_scene(wheelbase_m);
                // the wheel turns over most of every move: slowly, so that the steering follows
                parked(&scene, start, 0.2)
            }
            Self::UTurn => {
                let (car, scene, ranges, settings) = u_turn_scene(wheelbase_m)?;
                let found = u_turn::search(&car, &scene, &ranges, &settings)?;
                Ok(Planned {
                    path: found.track.path(0.02),
                    body: car.body,
                    field: Some(scene.field),
                    obstacles: scene.obstacles,
                    cruise_mps: found.turn.speed_mps,
                    clearance_m: found.margins.smallest_m(),
                    moves: None,
                })
            }
            Self::Given(ref scene) => {
                if let Some(task) = scene.parking_task(wheelbase_m)? {
                    return parked(&task.scene, task.start, task.cruise_mps);
                }
                turned_round(scene.u_turn_task(wheelbase_m)?.ok_or(Error::NothingToPlan)?)
            }
        }
    }
}

/// The plan of a U-turn, in the frame of its scene file.
fn turned_round(task: UTurnTask) -> Result<Planned> {
    let found = u_turn::search(&task.car, &task.scene, &task.ranges, &task.settings)?;
    let poses = found.track.path(0.02).poses.iter().map(|pose| task.frame.pose_outside(pose)).collect();
    Ok(Planned {
        path: PosePath { poses },
        body: task.car.body,
        field: Some(task.field),
        obstacles: task.obstacles,
        cruise_mps: found.turn.speed_mps,
        clearance_m: found.margins.smallest_m(),
        moves: None,
    })
}

/// The plan of a parking scene, driven at `cruise_mps`.
fn parked(scene: &parking::ParkingScene, start: parking::ParkingStart, cruise_mps: f64) -> Result<Planned> {
    let plan = parking::plan(scene, start)?;
    let moves = Some([plan.moves(), plan.shuffles()]);
    Ok(Planned {
        path: plan.path,
        body: scene.body,
        field: None,
        obstacles: scene.obstacles(),
        cruise_mps,
        clearance_m: plan.judgement.clearance_m,
        moves,
    })
}

/// The scene of parking with shuffling for a wheelbase: a slot 0.45 m wider than the vehicle, an aisle 0.55 m wider than its length, and a wheel limit
/// of 50°; the start 12° askew, near the row.
pub(crate) fn shuffle_scene(wheelbase_m: f64) -> (parking::ParkingScene, parking::ParkingStart) {
    let (mut scene, mut start) = parking_scene(wheelbase_m, 90.0, true);
    scene.slot.width_m = scene.body.width_m + 0.45;
    scene.slot.aisle_m = scene.body.length_m() + 0.55;
    scene.look_ahead.wheel_limit_rad = 50.0 * RAD_PER_DEG;
    (start.y_m, start.heading_rad) = (0.95 * wheelbase_m, 12.0 * RAD_PER_DEG);
    (scene, start)
}

/// The parking scene for a wheelbase, and the start: beside the row, 2.2 wheelbases before the slot, heading 3° off the row.
pub(crate) fn parking_scene(wheelbase_m: f64, angle_deg: f64, obstacle_right: bool) -> (parking::ParkingScene, parking::ParkingStart) {
    let body = BodyShape::usual(wheelbase_m);
    let mut slot = parking::Slot::usual(&body, 0.2);
    (slot.angle_rad, slot.obstacle_right) = (angle_deg * RAD_PER_DEG, obstacle_right);
    let (sin, cos) = slot.angle_rad.sin_cos();
    slot.depth_m = body.length_m() + (0.3 + body.width_m * cos.abs()) / sin;
    let mut scene = parking::ParkingScene::new(body, slot);
    scene.look_ahead.wheel_limit_rad = WHEEL_LIMIT_RAD;
    scene.look_ahead.distance_m = 0.4 * wheelbase_m;
    let y_m = 1.1 * scene.line_m();
    (scene, parking::ParkingStart { x_m: -2.2 * wheelbase_m, y_m, heading_rad: -3.0 * RAD_PER_DEG, wheel_angle_rad: 0.0 })
}

/// The U-turn's vehicle, scene, ranges and settings for a wheelbase: two aisles of 1.6 m and a shelf between them, wider in proportion for a vehicle
/// longer than 0.9 m.
///
/// # Errors
/// A wheelbase for which there is no scene.
pub(crate) fn u_turn_scene(wheelbase_m: f64) -> Result<(u_turn::Car, u_turn::UTurnScene, u_turn::Ranges, u_turn::UTurnSettings)> {
    let k = (wheelbase_m / 0.9).max(1.0);
    let box_of = |x0: f64, x1: f64, y0: f64, y1: f64| {
        Polygon::new([(x0, y0), (x1, y0), (x1, y1), (x0, y1)].map(|(x, y)| PlanePoint::new(k * x, k * y)).to_vec())
    };
    let car = u_turn::Car { body: BodyShape::usual(wheelbase_m), steering_ratio: 1.0, steering_limit_rad: WHEEL_LIMIT_RAD };
    let scene = u_turn::UTurnScene {
        field: box_of(-3.2, 0.8, -1.2, 6.5)?,
        obstacles: vec![box_of(-1.6, -0.8, -1.2, 3.4)?],
        lines: Vec::new(),
        clearance_m: 0.3,
    };
    let ranges = u_turn::Ranges {
        run_up_m: [1.0 * k, 5.5 * k],
        // a longer vehicle needs more distance for the same change of angle, so it drives slower
        speed_mps: [0.3 / k, 0.8],
        steering_rate_rad_s: [12.0 * RAD_PER_DEG, 40.0 * RAD_PER_DEG],
        yaw_rate_rad_s: None,
    };
    let settings = u_turn::UTurnSettings {
        run_up_accel_mps2: 0.5,
        method: u_turn::Method::RungeKutta,
        step_s: 0.02,
        ..u_turn::UTurnSettings::default()
    };
    Ok((car, scene, ranges, settings))
}

impl Planned {
    /// Smallest distance of the body at a pose from field and obstacles [m].
    pub fn clearance_at_m(&self, x_m: f64, y_m: f64, heading_rad: f64) -> f64 {
        let body = self.body.at(x_m, y_m, heading_rad);
        let free = self.obstacles.iter().map(|o| o.separation_m(&body)).fold(f64::INFINITY, f64::min);
        self.field.as_ref().map_or(free, |field| free.min(field.inside_margin_m(&body)))
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn scenes_scale_with_the_vehicle() {
        for wheelbase_m in [0.7, 0.92, 1.35] {
            let usual = PlannedTask::Parking { angle_deg: 90.0, obstacle_right: true, nose_in: false };
            for task in [PlannedTask::UTurn, usual, PlannedTask::ParkingShuffle] {
                let planned = task.plan(wheelbase_m).unwrap();
                let [moves, shuffles] = planned.moves.unwrap_or_default();
                assert_eq!(shuffles > 0, task == PlannedTask::ParkingShuffle, "{task:?} {wheelbase_m}: {moves} moves");
                assert!(planned.clearance_m >= 0.1 - 1e-9, "{task:?} {wheelbase_m}: {}", planned.clearance_m);
            }
        }
    }
}
