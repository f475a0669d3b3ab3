//! The closed loop of a manoeuvre: read, command, let the world go on, once a control period.

use crate::control::{Inputs, Pose};
use crate::guidance::route::follower::{DriveCommand, Stage};
use crate::sim;
use crate::sim::{Measurement, TrueState, World};
use crate::verify::Result;

/// How the navigation and the steering are mounted wrongly.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Mounting {
    /// Navigation's heading minus the vehicle's [rad].
    pub yaw_rad: f64,
    /// The wheel's angle minus what the steering takes it for [rad]: commanded 0, it stands at this.
    pub steering_zero_rad: f64,
}

/// Where a manoeuvre starts.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Start {
    /// Pose of the rear axle's middle.
    pub pose: Pose,
    /// Wheel angle [rad].
    pub wheel_angle_rad: f64,
}

/// One control period, for metrics, a log or a picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Moment {
    /// The truth at its start.
    pub state: TrueState,
    /// What the controller read, mounting errors included.
    pub seen: Measurement,
    /// What it commanded.
    pub command: DriveCommand,
    /// Compensation that was added to the tracking law's angle [rad].
    pub compensation_rad: f64,
    /// Leg that was driven.
    pub leg: usize,
}

/// Longest manoeuvre [s].
const LONGEST_S: f64 = 900.0;
/// How long before the first command [s]: every sensor has read at least once.
const SETTLE_S: f64 = 0.1;

/// Drives until the controller has arrived or failed, and returns how it ended. `controller` gives the command, the compensation in it and the leg.
///
/// # Errors
/// A world that cannot be simulated.
pub fn drive(
    plant: &sim::Settings,
    seed: u64,
    start: &Start,
    mounting: &Mounting,
    period_s: f64,
    mut controller: impl FnMut(&Inputs) -> (DriveCommand, f64, usize),
    mut record: impl FnMut(&Moment),
) -> Result<Stage> {
    let mut world = World::new(plant, seed)?;
    world.place_wheel(start.wheel_angle_rad + mounting.steering_zero_rad);
    let steps = (period_s / plant.step_s).round().max(1.0) as usize;
    let mut order = sim::Command { torque_nm: 0.0, wheel_angle_rad: start.wheel_angle_rad + mounting.steering_zero_rad, gear: None };
    for _ in 0..(SETTLE_S / plant.step_s) as usize {
        world.step(&order);
    }
    for _ in 0..(LONGEST_S / period_s) as usize {
        let (state, seen) = looked(&world, start, mounting);
        let (command, compensation_rad, leg) = controller(&Inputs {
            speed_mps: seen.speed_mps,
            wheel_angle_rad: seen.wheel_angle_rad,
            pose: Pose { x_m: seen.x_m, y_m: seen.y_m, heading_rad: seen.heading_rad },
            gear: seen.gear,
            estop: seen.estop,
        });
        record(&Moment { state, seen, command, compensation_rad, leg });
        if matches!(command.stage, Stage::Arrived | Stage::Failed(_)) {
            return Ok(command.stage);
        }
        order = sim::Command {
            torque_nm: command.torque_nm,
            wheel_angle_rad: command.wheel_angle_rad + mounting.steering_zero_rad,
            gear: command.gear,
        };
        for _ in 0..steps {
            world.step(&order);
        }
    }
    Ok(Stage::Driving)
}

/// Truth and readings in the frame of the path, with the mounting errors.
fn looked(world: &World, start: &Start, mounting: &Mounting) -> (TrueState, Measurement) {
    let (sin, cos) = start.pose.heading_rad.sin_cos();
    let placed = |x: f64, y: f64| (start.pose.x_m + cos * x - sin * y, start.pose.y_m + sin * x + cos * y);
    let (mut state, mut seen) = (world.state(), world.measure());
    (state.x_m, state.y_m) = placed(state.x_m, state.y_m);
    (seen.x_m, seen.y_m) = placed(seen.x_m, seen.y_m);
    state.heading_rad += start.pose.heading_rad;
    seen.heading_rad += start.pose.heading_rad + mounting.yaw_rad;
    seen.wheel_angle_rad -= mounting.steering_zero_rad;
    (state, seen)
}
