//! The fourth phase: the vehicle straightens by moving out and in within the room that there is.
//!
//! A third reference line lies along the slot's axis. Each move tracks it with the same look-ahead window as the other phases, so that the
//! wheel angle is continuous over every change of direction. A move ends where the body would come nearer to an obstacle than the least
//! clearance. A move out also ends as soon as the vehicle is aligned with the axis. Moves follow one another until the vehicle is parked
//! straight or three pairs of them have brought it no nearer.

use crate::guidance::look_ahead::LookAheadFollower;
use crate::guidance::parking::parked_path::axis_from;
use crate::guidance::parking::scene::ParkingScene;
use crate::guidance::parking::stage::{ParkingStage, StageSpan};
use crate::guidance::reference::ReferenceLine;
use crate::guidance::{PathPose, PlanePoint, Polygon};
use crate::map::Gear;

/// Largest number of moves: some 20 minutes of driving, more than any scene with room needs.
pub(crate) const MOST_MOVES: usize = 120;
/// Pairs of moves without progress after which the slot has no room to straighten.
const IDLE_PAIRS: usize = 3;
/// Progress of a pair of moves [m]: less is none.
const PROGRESS_M: f64 = 0.002;

/// The obstacles of a scene, made once for many poses.
pub(crate) struct Room<'a> {
    scene: &'a ParkingScene,
    obstacles: Vec<Polygon>,
}

impl<'a> Room<'a> {
    pub(crate) fn new(scene: &'a ParkingScene) -> Self {
        Self { scene, obstacles: scene.obstacles() }
    }

    /// Distance of the body at a pose from the nearest obstacle [m].
    pub(crate) fn clearance_m(&self, pose: &PathPose) -> f64 {
        let body = self.scene.body.at_pose(pose);
        self.obstacles.iter().fold(f64::INFINITY, |least_m, o| o.separation_or_m(&body, least_m))
    }

    /// Follows `reference` while there is room, at most to `end_m` on it or until `done`. Returns the distance moved [m].
    pub(crate) fn follow(
        &self,
        follower: &mut LookAheadFollower,
        reference: &ReferenceLine,
        gear: Gear,
        end_m: f64,
        mut done: impl FnMut(&PathPose) -> bool,
    ) -> f64 {
        let (least_m, step_m) = (self.scene.tolerance.clearance_m, self.scene.look_ahead.step_m);
        let before = follower.path.poses.len();
        let here = follower.last();
        let most_m = reference.length_m() + 2.0 * here.x_m.hypot(here.y_m) + self.scene.body.length_m();
        follower.follow(reference, gear, most_m, |pose, s_m| {
            // the pose at which the move starts may itself be at the limit
            s_m >= end_m - 0.5 * step_m || self.clearance_m(pose) < least_m - 1e-9 || done(pose)
        });
        while follower.path.poses.len() > before && self.clearance_m(&follower.last()) < least_m - 1e-9 {
            follower.path.poses.pop();
        }
        if follower.path.poses.len() == before {
            // nothing moved: the start keeps its direction
            let last = before - 1;
            follower.path.poses[last].direction = here.direction;
        }
        (follower.path.poses.len() - before) as f64 * step_m
    }

    /// Offset from the slot's axis [m], left of the outward direction positive, and heading error [rad].
    fn off_axis(&self, pose: &PathPose) -> (f64, f64) {
        let (sin, cos) = self.scene.slot.angle_rad.sin_cos();
        let (turn_sin, turn_cos) = (pose.heading_rad - self.scene.goal().heading_rad).sin_cos();
        (pose.y_m * cos - pose.x_m * sin, turn_sin.atan2(turn_cos))
    }

    /// How far the vehicle is from being parked straight [m].
    fn lacking_m(&self, pose: &PathPose) -> f64 {
        let goal = self.scene.goal();
        let (_, heading_rad) = self.off_axis(pose);
        (pose.x_m - goal.x_m).hypot(pose.y_m - goal.y_m) + self.scene.body.wheelbase_m * heading_rad.abs()
    }

    /// Whether the vehicle is parked within its tolerances.
    pub(crate) fn parked(&self, pose: &PathPose) -> bool {
        let (goal, tolerance) = (self.scene.goal(), &self.scene.tolerance);
        let (_, heading_rad) = self.off_axis(pose);
        (pose.x_m - goal.x_m).hypot(pose.y_m - goal.y_m) <= tolerance.position_m && heading_rad.abs() <= tolerance.heading_rad
    }
}

/// Moves out and in along the axis until the vehicle is parked straight, no move helps, or there are more than `most` moves. The moves are
/// appended to `stages`.
pub(crate) fn shuffle(scene: &ParkingScene, follower: &mut LookAheadFollower, stages: &mut Vec<StageSpan>, most: usize) {
    let room = Room::new(scene);
    let (mut best_m, mut idle) = (room.lacking_m(&follower.last()), 0);
    // far enough out for the whole body, however wide the aisle is
    let out_m = scene.body.length_m() + scene.slot.depth_m;
    let goal = scene.goal();
    let outward = ReferenceLine::starting(PlanePoint::new(goal.x_m, goal.y_m), scene.slot.angle_rad).then(out_m, 0.0);
    for _ in 0..most.div_ceil(2) {
        if room.parked(&follower.last()) || idle >= IDLE_PAIRS {
            return;
        }
        let from = follower.path.poses.len() - 1;
        let aligned = |pose: &PathPose| {
            let (offset_m, heading_rad) = room.off_axis(pose);
            offset_m.abs() < 0.01 && heading_rad.abs() < 0.005 && pose.wheel_angle_rad.abs() < 0.03
        };
        let out = room.follow(follower, &outward, scene.gear_out(), out_m, aligned);
        if out > 0.0 {
            stages.push(StageSpan { stage: ParkingStage::Shuffle, from });
        }
        let here = follower.last();
        let (sin, cos) = scene.slot.angle_rad.sin_cos();
        let inward = axis_from(scene, here.x_m * cos + here.y_m * sin + scene.look_ahead.distance_m);
        let from = follower.path.poses.len() - 1;
        let back = room.follow(follower, &inward, scene.gear_in(), inward.length_m(), |_| false);
        if back > 0.0 {
            stages.push(StageSpan { stage: ParkingStage::Shuffle, from });
        }
        let lacking_m = room.lacking_m(&follower.last());
        idle = if lacking_m < best_m - PROGRESS_M { 0 } else { idle + 1 };
        best_m = best_m.min(lacking_m);
        if out + back == 0.0 {
            return;
        }
    }
}
