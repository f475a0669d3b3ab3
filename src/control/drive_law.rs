//! What a drive law is: the part of the longitudinal module that turns speed and place into torque, once the wheel is at its angle.

use crate::Gear;
use crate::messages::{DriveStep, PivotRequest, Pose};

/// What a drive law reads each period.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DriveInputs {
    /// Front-wheel speed [m/s], gear frame.
    pub speed_mps: f64,
    /// Pose of the reference point.
    pub pose: Pose,
}

/// A law that drives a pivot from its start to its end.
pub trait DriveLaw {
    /// Forgets the pivot before and starts at `pose`.
    fn start(&mut self, request: &PivotRequest, pose: Pose);

    /// One period. `None` when the law has no torque to give: the pivot fails.
    fn step(&mut self, request: &PivotRequest, inputs: &DriveInputs) -> Option<DriveStep>;

    /// Torque that brakes with `decel_mps2` (positive) at `speed_mps` in `gear`; the longitudinal module takes only its braking part.
    fn braking_torque_nm(&self, gear: Gear, speed_mps: f64, decel_mps2: f64) -> f64;
}
