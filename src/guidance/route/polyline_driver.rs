//! Drives a planned polyline: turn on the spot, track the leg, stop at its end, turn, and so on.

use crate::control::Inputs;
use crate::control::numeric::wrapped;
use crate::guidance::route::follower::{DriveCommand, DriveStage, FollowerSettings, PathFollower};
use crate::guidance::route::path_position::Leg;
use crate::guidance::route::polyline::PolylinePlan;
use crate::guidance::route::turn_law::{SpotTurn, TurnSettings};
use crate::guidance::torque_source::TorqueSource;

/// The driver with its state; it borrows the plan.
#[derive(Debug)]
pub(crate) struct PolylineDriver<'a> {
    plan: &'a PolylinePlan,
    turn_settings: TurnSettings,
    follower: PathFollower,
    turn: Option<SpotTurn>,
    leg: usize,
    begun: bool,
}

impl<'a> PolylineDriver<'a> {
    /// At the start of `plan`.
    pub(crate) fn new(plan: &'a PolylinePlan, settings: FollowerSettings, turn_settings: TurnSettings) -> Self {
        Self { plan, turn_settings, follower: PathFollower::new(settings), turn: None, leg: 0, begun: false }
    }

    /// Index of the current leg, driven or turned to.
    pub(crate) fn leg(&self) -> usize {
        self.leg
    }

    /// One period.
    pub(crate) fn step<T: TorqueSource + ?Sized>(&mut self, inputs: &Inputs, torque: &T, compensation_rad: f64) -> DriveCommand {
        let poses = self.plan.legs.get(self.leg);
        let (Some(leg), Some(&heading_rad)) = (poses.and_then(|p| Leg::first(&p.poses)), self.plan.headings_rad.get(self.leg)) else {
            return DriveCommand::hold(inputs.wheel_angle_rad, None, DriveStage::Arrived);
        };
        if !self.begun {
            self.begun = true;
            let off = wrapped(heading_rad - inputs.pose.heading_rad);
            // no turn for an angle that the tracking law corrects while driving
            let turns = off.abs() > 2.0 * self.turn_settings.rate.dead_zone_rad;
            self.turn = turns.then(|| SpotTurn::new(self.turn_settings));
            self.follower.start(self.plan.speeds.get(self.leg).cloned());
        }
        if let Some(turn) = &mut self.turn {
            let command = turn.step(heading_rad, inputs, torque);
            if command.stage != DriveStage::Arrived {
                return command;
            }
            self.turn = None;
        }
        let command = self.follower.step(leg, inputs, torque, compensation_rad);
        if command.stage == DriveStage::Arrived {
            (self.leg, self.begun) = (self.leg + 1, false);
            if self.leg < self.plan.legs.len() {
                return DriveCommand { stage: DriveStage::Stopping, ..command };
            }
        }
        command
    }
}
