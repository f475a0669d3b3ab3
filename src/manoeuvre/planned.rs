//! Parking and the U-turn in closed loop: the planned path is driven leg by leg, and the body's true distance from everything is watched.

use crate::control::{Inputs, Pose};
use crate::guidance::look_ahead::largest_steps;
use crate::guidance::route::follower::{DriveCommand, Follower, FollowerSettings, Stage};
use crate::guidance::route::path_position::{Leg, Offset};
use crate::guidance::route::rear_axle::RearAxle;
use crate::guidance::route::segment_speed::SegmentSpeed;
use crate::guidance::route::tracking::TrackingSettings;
use crate::guidance::{BodyShape, Point, Polygon, PosePath, parking, u_turn};
use crate::manoeuvre::bench::Bench;
use crate::manoeuvre::drive::{Moment, Mounting, Start, drive};
use crate::sim;
use crate::units::RAD_PER_DEG;
use crate::verify::Result;
use crate::verify::metric::{Metric, Values};
use serde::Serialize;
use std::f64::consts::PI;

/// What is planned and driven.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum PlannedTask {
    /// Into a slot, in reverse or nose in.
    Parking {
        /// Angle of the slot's axis against the row [°].
        angle_deg: f64,
        /// Whether something stands on the side from which the vehicle backs in.
        obstacle_right: bool,
        /// Whether it goes in forward.
        nose_in: bool,
    },
    /// A U-turn around the end of a shelf into the next aisle.
    UTurn,
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
}

/// Wheel limit of both manoeuvres: the tracking keeps 9° of its own limit of 69° for itself.
const WHEEL_LIMIT_RAD: f64 = 60.0 * RAD_PER_DEG;

impl PlannedTask {
    /// Plans the task for a vehicle of a wheelbase [m], with the usual outline; slot and aisles are in proportion.
    ///
    /// # Errors
    /// A wheelbase for which no path is found.
    pub fn plan(self, wheelbase_m: f64) -> Result<Planned> {
        match self {
            Self::Parking { angle_deg, obstacle_right, nose_in } => {
                let (mut scene, start) = parking_scene(wheelbase_m, angle_deg, obstacle_right);
                scene.nose_in = nose_in;
                let plan = parking::plan(&scene, start)?;
                Ok(Planned {
                    path: plan.path,
                    body: scene.body,
                    field: None,
                    obstacles: scene.obstacles(),
                    cruise_mps: 0.4,
                    clearance_m: plan.judgement.clearance_m,
                })
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
                })
            }
        }
    }
}

/// The parking scene for a wheelbase, and where it starts: beside the row, 2.2 wheelbases before the slot, 3° askew.
pub fn parking_scene(wheelbase_m: f64, angle_deg: f64, obstacle_right: bool) -> (parking::Scene, parking::Start) {
    let body = BodyShape::usual(wheelbase_m);
    let mut slot = parking::Slot::usual(&body, 0.2);
    (slot.angle_rad, slot.obstacle_right) = (angle_deg * RAD_PER_DEG, obstacle_right);
    let (sin, cos) = slot.angle_rad.sin_cos();
    slot.depth_m = body.length_m() + (0.3 + body.width_m * cos.abs()) / sin;
    let mut scene = parking::Scene::new(body, slot);
    scene.look_ahead.wheel_limit_rad = WHEEL_LIMIT_RAD;
    scene.look_ahead.distance_m = 0.4 * wheelbase_m;
    (scene, parking::Start { x_m: -2.2 * wheelbase_m, y_m: 1.1 * scene.line_m(), heading_rad: -3.0 * RAD_PER_DEG, wheel_angle_rad: 0.0 })
}

/// The U-turn's vehicle, scene, ranges and settings for a wheelbase: two aisles of 1.6 m and a shelf between them, wider in proportion for a vehicle
/// longer than 0.9 m.
///
/// # Errors
/// A wheelbase that makes no scene.
pub fn u_turn_scene(wheelbase_m: f64) -> Result<(u_turn::Car, u_turn::Scene, u_turn::Ranges, u_turn::Settings)> {
    let k = (wheelbase_m / 0.9).max(1.0);
    let box_of = |x0: f64, x1: f64, y0: f64, y1: f64| {
        Polygon::new([(x0, y0), (x1, y0), (x1, y1), (x0, y1)].map(|(x, y)| Point::new(k * x, k * y)).to_vec())
    };
    let car = u_turn::Car { body: BodyShape::usual(wheelbase_m), steering_ratio: 1.0, steering_limit_rad: WHEEL_LIMIT_RAD };
    let scene = u_turn::Scene {
        field: box_of(-3.2, 0.8, -1.2, 6.5)?,
        obstacles: vec![box_of(-1.6, -0.8, -1.2, 3.4)?],
        lines: Vec::new(),
        clearance_m: 0.3,
    };
    let ranges = u_turn::Ranges {
        run_up_m: [1.0 * k, 5.5 * k],
        // a longer vehicle needs more way for the same change of angle: slower
        speed_mps: [0.3 / k, 0.8],
        steering_rate_rad_s: [12.0 * RAD_PER_DEG, 40.0 * RAD_PER_DEG],
        yaw_rate_rad_s: None,
    };
    let settings =
        u_turn::Settings { run_up_accel_mps2: 0.5, method: u_turn::Method::RungeKutta, step_s: 0.02, ..u_turn::Settings::default() };
    Ok((car, scene, ranges, settings))
}

impl Planned {
    /// Smallest distance of the body at a pose from field and obstacles [m].
    pub fn clearance_at_m(&self, x_m: f64, y_m: f64, heading_rad: f64) -> f64 {
        let body = self.body.at(x_m, y_m, heading_rad);
        let free = self.obstacles.iter().map(|o| o.separation_m(&body)).fold(f64::INFINITY, f64::min);
        self.field.as_ref().map_or(free, |field| free.min(field.inside_margin_m(&body)))
    }

    fn settings(&self, wheelbase_m: f64) -> FollowerSettings {
        // feedback over the length of the vehicle's own turning: back onto the path within a metre
        let law = RearAxle { offset_gain_per_m2: 4.0, heading_gain_per_m: 4.0 };
        let mut settings = FollowerSettings::new(wheelbase_m, TrackingSettings::RearAxle(law));
        settings.speed =
            SegmentSpeed { start_mps: 0.15, accelerating_m: 0.4, cruise_mps: self.cruise_mps, decelerating_m: 0.6, switch_mps: 0.1 };
        settings
    }
}

/// One leg after the other.
struct LegDriver<'a> {
    path: &'a PosePath,
    follower: Follower,
    from: usize,
    leg: usize,
}

impl LegDriver<'_> {
    fn step(&mut self, inputs: &Inputs, bench: &Bench<'_>) -> (DriveCommand, f64, usize) {
        let Some(leg) = self.path.poses.get(self.from..).and_then(Leg::first) else {
            return (DriveCommand::at_rest(inputs.wheel_angle_rad), 0.0, self.leg);
        };
        let mut command = self.follower.step(leg, inputs, &bench.torque, 0.0);
        if command.stage == Stage::Arrived && self.from + leg.last_index() + 1 < self.path.poses.len() {
            self.from += leg.last_index();
            self.leg += 1;
            self.follower.start();
            command.stage = Stage::Steering;
        }
        (command, 0.0, self.leg)
    }
}

/// Drives a plan and measures.
pub(crate) fn run(
    bench: &Bench<'_>,
    planned: &Planned,
    plant: &sim::Settings,
    seed: u64,
    mut record: impl FnMut(&Moment),
) -> Result<Values> {
    let settings = planned.settings(bench.wheelbase_m);
    let first = planned.path.poses[0];
    let start =
        Start { pose: Pose { x_m: first.x_m, y_m: first.y_m, heading_rad: first.heading_rad }, wheel_angle_rad: first.wheel_angle_rad };
    let mut driver = LegDriver { path: &planned.path, follower: Follower::new(settings), from: 0, leg: 0 };
    let (mut clearance_m, mut largest_m, mut squares, mut way_m) = (f64::INFINITY, 0.0_f64, 0.0, 0.0);
    let (mut end, mut leg_from, mut leg_now, mut index) = (None, 0, 0, 0);
    let controller = |inputs: &Inputs| driver.step(inputs, bench);
    let stage = drive(plant, seed, &start, &Mounting::default(), settings.limits.period_s, controller, |moment| {
        let state = moment.state;
        clearance_m = clearance_m.min(planned.clearance_at_m(state.x_m, state.y_m, state.heading_rad));
        if moment.leg != leg_now {
            leg_from += Leg::first(&planned.path.poses[leg_from..]).map_or(0, |l| l.last_index());
            (leg_now, index) = (moment.leg, 0);
        }
        if let Some(leg) = Leg::first(&planned.path.poses[leg_from..]) {
            let pose = Pose { x_m: state.x_m, y_m: state.y_m, heading_rad: state.heading_rad };
            let (matched, found) = leg.nearest(pose.x_m, pose.y_m, index);
            index = found;
            let lateral_m = Offset::new(leg.travel_pose(pose), &matched).lateral_m;
            let moved_m = end.map_or(0.0, |e: sim::TrueState| (state.x_m - e.x_m).hypot(state.y_m - e.y_m));
            largest_m = largest_m.max(lateral_m.abs());
            squares += moved_m * lateral_m * lateral_m;
            way_m += moved_m;
        }
        end = Some(state);
        record(moment);
    })?;
    let mut values = Values::default();
    values.set(Metric::AsExpected, f64::from(u8::from(stage == Stage::Arrived)));
    if let (Some(end), Some(goal)) = (end, planned.path.poses.last()) {
        let off = (end.heading_rad - goal.heading_rad + PI).rem_euclid(2.0 * PI) - PI;
        values.set(Metric::FinalPositionM, (end.x_m - goal.x_m).hypot(end.y_m - goal.y_m));
        values.set(Metric::HeadingErrorDeg, off.abs() / RAD_PER_DEG);
        values.set(Metric::TimeS, end.t_s);
    }
    values.set(Metric::SegmentErrorM, largest_m);
    values.set(Metric::SegmentRmsM, (squares / way_m).sqrt());
    values.set(Metric::ClearanceM, clearance_m);
    values.set(Metric::ClearanceLossM, (planned.clearance_m - clearance_m).max(0.0));
    values.set(Metric::CurvatureStepPerM, largest_steps(&planned.path).1);
    Ok(values)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::manoeuvre::{Kind, Manoeuvre, bundled_vehicle, replay_manoeuvre};
    use crate::verify::{Maps, Settings, known_maps};

    #[test]
    fn every_planned_manoeuvre_ends_where_it_should_and_touches_nothing() {
        let (table1, table2) = known_maps(&bundled_vehicle().unwrap()).unwrap();
        let (maps, settings) = (Maps::new(table1, table2).unwrap(), Settings::new().unwrap());
        for manoeuvre in Manoeuvre::all().into_iter().filter(|m| matches!(m.kind, Kind::Planned(_))) {
            let mut legs = 0;
            let values = replay_manoeuvre(&maps, &settings, &manoeuvre, |moment| legs = legs.max(moment.leg)).unwrap();
            let told: Vec<_> = Metric::ALL.into_iter().filter_map(|m| values.get(m).map(|v| format!("{}: {v:.4}", m.title()))).collect();
            let (parking, get) = (manoeuvre.name.starts_with("parking"), |m| values.get(m).unwrap());
            assert_eq!(get(Metric::AsExpected), 1.0, "{}", manoeuvre.name);
            assert!(get(Metric::FinalPositionM) < 0.05 && get(Metric::HeadingErrorDeg) < 1.0, "{}: {told:?}", manoeuvre.name);
            assert!(get(Metric::ClearanceM) > if parking { 0.05 } else { 0.2 }, "{}: {told:?}", manoeuvre.name);
            assert_eq!(legs, usize::from(parking && manoeuvre.name != "parking-nose-in"), "parking drives up and backs in");
        }
    }

    #[test]
    fn scenes_scale_with_the_vehicle() {
        for wheelbase_m in [0.7, 0.92, 1.35] {
            for task in [PlannedTask::UTurn, PlannedTask::Parking { angle_deg: 90.0, obstacle_right: true, nose_in: false }] {
                let planned = task.plan(wheelbase_m).unwrap();
                assert!(planned.clearance_m >= 0.1, "{task:?} {wheelbase_m}: {}", planned.clearance_m);
            }
        }
    }
}
