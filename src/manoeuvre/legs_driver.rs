//! Drives the legs of a path one after the other.

use crate::control::Inputs;
use crate::guidance::path::PosePath;
use crate::guidance::route::follower::{DriveCommand, DriveStage, FollowerSettings, PathFollower};
use crate::guidance::route::path_position::Leg;
use crate::guidance::torque_source::TorqueSource;

/// The driver with its memory; it borrows the path.
pub(crate) struct LegsDriver<'a> {
    path: &'a PosePath,
    /// Index of the leg's first pose.
    first: usize,
    leg: usize,
    follower: PathFollower,
}

impl<'a> LegsDriver<'a> {
    /// At the start of `path`.
    pub(crate) fn new(path: &'a PosePath, settings: FollowerSettings) -> Self {
        Self { path, first: 0, leg: 0, follower: PathFollower::new(settings) }
    }

    /// Number of the leg that is driven, from 0.
    pub(crate) fn leg(&self) -> usize {
        self.leg
    }

    /// One period. `compensation_rad` is added to the tracking law's angle. A path without a leg is one whose end is reached. At the end of a
    /// leg that is not the last one, the stage is still [`DriveStage::Stopping`].
    pub(crate) fn step<T: TorqueSource>(&mut self, inputs: &Inputs, torque: &T, compensation_rad: f64) -> DriveCommand {
        let Some(leg) = self.path.poses.get(self.first..).and_then(Leg::first) else {
            return DriveCommand::at_rest(inputs.wheel_angle_rad);
        };
        let command = self.follower.step(leg, inputs, torque, compensation_rad);
        let end = self.first + leg.last_index();
        if command.stage == DriveStage::Arrived && end + 1 < self.path.poses.len() {
            (self.first, self.leg) = (end, self.leg + 1);
            self.follower.start();
            return DriveCommand { stage: DriveStage::Stopping, ..command };
        }
        command
    }
}
