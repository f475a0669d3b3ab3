//! Drives the legs of a path one after the other.

use crate::control::Inputs;
use crate::guidance::path::PosePath;
use crate::guidance::route::follower::{DriveCommand, DriveStage, FollowerSettings, PathFollower};
use crate::guidance::route::path_position::Leg;
use crate::guidance::torque_source::TorqueSource;

/// The driver with its state; it borrows the path.
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

    /// One period. `compensation_rad` is added to the tracking law's angle. A path without a leg counts as completed. At the end of a
    /// leg that is not the last one, the stage is still [`DriveStage::Stopping`].
    pub(crate) fn step<T: TorqueSource>(&mut self, inputs: &Inputs, torque: &T, compensation_rad: f64) -> DriveCommand {
        let Some(leg) = self.path.poses.get(self.first..).and_then(Leg::first) else {
            return DriveCommand::at_rest(inputs.wheel_angle_rad);
        };
        let command = self.follower.step(leg, inputs, torque, compensation_rad);
        let end = self.first + leg.last_index();
        if command.stage == DriveStage::Arrived && end + 1 < self.path.poses.len() {
            (self.first, self.leg) = (end, self.leg + 1);
            self.follower.start(None);
            return DriveCommand { stage: DriveStage::Stopping, ..command };
        }
        command
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::control::Pose;
    use crate::guidance::route::clothoid_path::{ClothoidPiece, course};
    use crate::guidance::route::response::VehicleResponse;
    use crate::guidance::route::tracking::{LawName, TrackingSettings};
    use crate::map::Gear;

    struct NoTorque;

    impl TorqueSource for NoTorque {
        fn torque_nm(&self, _: f64, _: f64, _: f64) -> f64 {
            0.0
        }
    }

    fn standing_at(x_m: f64) -> Inputs {
        Inputs { speed_mps: Some(0.0), wheel_angle_rad: 0.0, pose: Pose { x_m, ..Pose::default() }, gear: None, estop: false }
    }

    #[test]
    fn at_the_end_of_a_leg_the_next_one_begins_and_at_the_end_of_the_last_it_has_arrived() {
        let path = course(&[ClothoidPiece::straight(2.0), ClothoidPiece::straight(1.0).reversed()], 0.9);
        let settings = FollowerSettings::new(&VehicleResponse::quick(0.9), TrackingSettings::new(LawName::RearAxle));
        let mut driver = LegsDriver::new(&path, settings);
        let mut legs = Vec::new();
        let mut last = DriveStage::Steering;
        // if the pose stays at the end of each leg, the follower stops there half a second later
        for x_m in [2.0, 1.0] {
            for _ in 0..40 {
                let command = driver.step(&standing_at(x_m), &NoTorque, 0.0);
                legs.push((driver.leg(), command.gear, command.stage == DriveStage::Arrived));
                last = command.stage;
                if x_m == 2.0 && driver.leg() == 1 {
                    break;
                }
            }
        }
        assert_eq!(last, DriveStage::Arrived);
        assert_eq!(legs[0], (0, Some(Gear::Forward), false));
        let switch = legs.iter().position(|l| l.0 == 1).unwrap();
        assert_eq!(legs[switch], (1, Some(Gear::Forward), false), "the stop of the first leg is no arrival");
        assert_eq!(legs[switch + 1].1, Some(Gear::Reverse));
    }

    #[test]
    fn a_path_without_a_leg_is_at_its_end() {
        let settings = FollowerSettings::new(&VehicleResponse::quick(0.9), TrackingSettings::new(LawName::RearAxle));
        let path = PosePath { poses: Vec::new() };
        assert_eq!(LegsDriver::new(&path, settings).step(&standing_at(0.0), &NoTorque, 0.0).stage, DriveStage::Arrived);
    }
}
