//! A drive law: the part of the longitudinal module that computes torque from speed and place, once the wheel is at its angle.

use crate::Gear;
use crate::messages::{DriveStep, PivotRequest, Pose};

/// Inputs of a drive law in each period.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DriveInputs {
    /// Front-wheel speed [m/s], gear frame.
    pub speed_mps: f64,
    /// Pose of the reference point.
    pub pose: Pose,
}

/// A law that drives a pivot from its start to its end.
pub trait DriveLaw {
    /// Resets the law and starts at `pose`.
    fn start(&mut self, request: &PivotRequest, pose: Pose);

    /// One period. `None` if the law gives no torque: the pivot fails.
    fn step(&mut self, request: &PivotRequest, inputs: &DriveInputs) -> Option<DriveStep>;

    /// Torque that brakes with `decel_mps2` (positive) at `speed_mps` in `gear`; the longitudinal module takes only its braking part.
    fn braking_torque_nm(&self, gear: Gear, speed_mps: f64, decel_mps2: f64) -> f64;
}
