//! A path into the slot with its stages and checks, and the parts that every plan is made of.

use crate::guidance::look_ahead::LookAheadFollower;
use crate::guidance::parking::check::{PathJudgement, judge};
use crate::guidance::parking::entry::SlotEntry;
use crate::guidance::parking::scene::ParkingScene;
use crate::guidance::parking::stage::{ParkingStage, StageSpan};
use crate::guidance::parking::start::ParkingStart;
use crate::guidance::reference::{ReferenceLine, ahead};
use crate::guidance::{PathPose, PlanePoint, PosePath};
use serde::Serialize;
use std::f64::consts::PI;

/// A path into the slot.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct ParkingPlan {
    /// Poses of the rear axle's middle, every step.
    pub path: PosePath,
    /// Its stages in order.
    pub stages: Vec<StageSpan>,
    /// The entry circle; `None` when the vehicle goes straight in.
    pub entry: Option<SlotEntry>,
    /// Results of the checks: all within limits.
    pub judgement: PathJudgement,
}

impl ParkingPlan {
    /// Number of moves: stretches without a change of direction.
    pub(crate) fn moves(&self) -> usize {
        1 + self.path.poses.windows(2).filter(|pair| pair[0].direction != pair[1].direction).count()
    }

    /// Number of moves along the slot's axis after the entry.
    pub(crate) fn shuffles(&self) -> usize {
        self.stages.iter().filter(|s| s.stage == ParkingStage::Shuffle).count()
    }
}

/// A path at its start.
pub(crate) fn follower(scene: &ParkingScene, start: ParkingStart) -> LookAheadFollower {
    let body = &scene.body;
    LookAheadFollower::new(start.x_m, start.y_m, start.heading_rad, start.wheel_angle_rad, body.wheelbase_m, scene.look_ahead)
}

/// The slot's axis inward, from `outward_m` before the mouth to the goal.
pub(crate) fn axis_from(scene: &ParkingScene, outward_m: f64) -> ReferenceLine {
    let angle = scene.slot.angle_rad;
    ReferenceLine::starting(ahead(PlanePoint::default(), angle, outward_m), angle + PI).then(outward_m - scene.parked_at_m(), 0.0)
}

/// Whether the vehicle is aligned with the first line y = `line_m`.
pub(crate) fn on_line(p: &PathPose, line_m: f64) -> bool {
    (p.y_m - line_m).abs() < 0.02 && p.heading_rad.sin().abs() < 0.02 && p.heading_rad.cos() > 0.0 && p.wheel_angle_rad.abs() < 0.05
}

/// The path with its checks; stages without a pose of their own are left out.
pub(crate) fn finish(
    scene: &ParkingScene,
    follower: LookAheadFollower,
    mut stages: Vec<StageSpan>,
    entry: Option<SlotEntry>,
) -> ParkingPlan {
    stages.dedup_by(|next, before| {
        next.from == before.from && {
            before.stage = next.stage;
            true
        }
    });
    let judgement = judge(scene, &follower.path);
    ParkingPlan { path: follower.path, stages, entry, judgement }
}
