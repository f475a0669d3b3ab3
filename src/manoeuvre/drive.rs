//! The driver of a manoeuvre in the closed loop: the controller gets readings with mounting errors, and the vehicle gets its commands.

use crate::control::{Inputs, Pose};
use crate::guidance::route::follower::{DriveCommand, DriveStage};
use crate::manoeuvre::Result;
use crate::manoeuvre::endings::DriveEnd;
use crate::sim;
use crate::sim::{Measurement, TrueState, World, WorldCommand};
use crate::verify;
use crate::verify::drive::{Driver, Observer, drive, inputs, steps_of};

/// Mounting errors of navigation and steering.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Mounting {
    /// Navigation's heading minus the vehicle's [rad].
    pub yaw_rad: f64,
    /// True wheel angle minus reported wheel angle [rad]: the true angle at a command of 0.
    pub steering_zero_rad: f64,
}

/// Start of a manoeuvre.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct ManoeuvreStart {
    /// Pose of the rear axle's middle.
    pub(crate) pose: Pose,
    /// Wheel angle [rad].
    pub(crate) wheel_angle_rad: f64,
}

/// One control period, for metrics, a log or a picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ManoeuvreMoment {
    /// The truth at its start.
    pub state: TrueState,
    /// Readings of the controller, mounting errors included.
    pub seen: Measurement,
    /// Command of the controller.
    pub command: DriveCommand,
    /// Compensation that was added to the tracking law's angle [rad].
    pub compensation_rad: f64,
    /// Number of the leg.
    pub leg: usize,
}

/// Output of a controller in one period.
pub(crate) struct Commanded {
    pub(crate) command: DriveCommand,
    /// Compensation in it [rad].
    pub(crate) compensation_rad: f64,
    /// Number of the leg.
    pub(crate) leg: usize,
}

/// Longest manoeuvre [s].
const LONGEST_S: f64 = 900.0;
/// Time before the first command [s]: every sensor has read at least once.
const SETTLE_S: f64 = 0.1;

/// Sees every period of a manoeuvre.
pub(crate) trait ManoeuvreObserver: for<'a> Observer<ManoeuvreDriver<'a>> {}

impl<O: for<'a> Observer<ManoeuvreDriver<'a>>> ManoeuvreObserver for O {}

/// A controller and its connection to the vehicle.
pub(crate) struct ManoeuvreDriver<'a> {
    start: &'a ManoeuvreStart,
    mounting: &'a Mounting,
    controller: &'a mut dyn FnMut(&Inputs) -> Commanded,
    stage: DriveStage,
    leg: usize,
    state: TrueState,
    periods_left: usize,
}

impl ManoeuvreDriver<'_> {
    fn has_ended(&self) -> bool {
        matches!(self.stage, DriveStage::Arrived | DriveStage::Failed(_))
    }
}

impl Driver for ManoeuvreDriver<'_> {
    type Moment = ManoeuvreMoment;

    fn prepare(&mut self, _: &mut World) -> verify::Result<bool> {
        if self.has_ended() || self.periods_left == 0 {
            return Ok(false);
        }
        self.periods_left -= 1;
        Ok(true)
    }

    fn command(&mut self, world: &World) -> (ManoeuvreMoment, WorldCommand) {
        let (state, seen) = readings(world, self.start, self.mounting);
        let Commanded { command, compensation_rad, leg } = (self.controller)(&inputs(&seen));
        (self.stage, self.leg, self.state) = (command.stage, leg, state);
        let order = WorldCommand {
            torque_nm: command.torque_nm,
            wheel_angle_rad: command.wheel_angle_rad + self.mounting.steering_zero_rad,
            gear: command.gear,
        };
        (ManoeuvreMoment { state, seen, command, compensation_rad, leg }, order)
    }
}

/// Drives until the controller has arrived or failed, and returns how and where: in [`DriveStage::Driving`] after 15 minutes.
///
/// # Errors
/// A world that cannot be simulated.
pub(crate) fn drive_manoeuvre(
    plant: &sim::WorldSettings,
    seed: u64,
    start: &ManoeuvreStart,
    mounting: &Mounting,
    period_s: f64,
    mut controller: impl FnMut(&Inputs) -> Commanded,
    mut observer: impl ManoeuvreObserver,
) -> Result<DriveEnd> {
    let mut world = World::new(plant, seed)?;
    let wheel_angle_rad = start.wheel_angle_rad + mounting.steering_zero_rad;
    world.place_wheel(wheel_angle_rad);
    let order = WorldCommand { torque_nm: 0.0, wheel_angle_rad, gear: None };
    for _ in 0..(SETTLE_S / plant.step_s) as usize {
        world.step(&order);
    }
    let mut driver = ManoeuvreDriver {
        start,
        mounting,
        controller: &mut controller,
        stage: DriveStage::Driving,
        leg: 0,
        state: TrueState::default(),
        periods_left: (LONGEST_S / period_s) as usize,
    };
    drive(&mut world, steps_of(period_s, plant.step_s), &mut driver, &mut observer)?;
    let (stage, state) = (if driver.has_ended() { driver.stage } else { DriveStage::Driving }, driver.state);
    Ok(DriveEnd { stage, leg: driver.leg, at_m: [state.x_m, state.y_m], heading_rad: state.heading_rad, t_s: state.t_s })
}

/// Truth and readings in the frame of the path, with the mounting errors.
fn readings(world: &World, start: &ManoeuvreStart, mounting: &Mounting) -> (TrueState, Measurement) {
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

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::guidance::route::follower::Trouble;
    use crate::sim::VehicleFile;
    use crate::verify::drive::EachMoment;

    fn driven(start: &ManoeuvreStart, mounting: &Mounting, stage: impl Fn(usize) -> DriveStage) -> (Vec<ManoeuvreMoment>, DriveStage) {
        let (mut moments, mut period) = (Vec::new(), 0);
        let controller = |inputs: &Inputs| {
            period += 1;
            let command = DriveCommand { stage: stage(period), ..DriveCommand::at_rest(inputs.wheel_angle_rad) };
            Commanded { command, compensation_rad: 0.1, leg: period }
        };
        let vehicle = VehicleFile::bundled().unwrap().settings();
        let end =
            drive_manoeuvre(&vehicle, 1, start, mounting, 0.02, controller, EachMoment(|m: &ManoeuvreMoment| moments.push(*m))).unwrap();
        (moments, end.stage)
    }

    #[test]
    fn the_readings_have_the_mounting_errors_and_the_frame_of_the_path() {
        let pose = Pose { x_m: 3.0, y_m: -2.0, heading_rad: 1.0 };
        let start = ManoeuvreStart { pose, wheel_angle_rad: 0.3 };
        let mounting = Mounting { yaw_rad: 0.05, steering_zero_rad: -0.04 };
        let (moments, _) = driven(&start, &mounting, |_| DriveStage::Arrived);
        let (state, seen) = (moments[0].state, moments[0].seen);
        assert_eq!((state.x_m, state.y_m, state.heading_rad), (3.0, -2.0, 1.0));
        assert!((state.wheel_angle_rad - 0.26).abs() < 1e-9, "commanded 0.3, the wheel is 0.04 to the right of it");
        // noise of 2 mm and 0.05°, of 0.15° with a bias of 0.25° at the wheel
        assert!((seen.x_m - 3.0).abs() < 0.01 && (seen.heading_rad - 1.05).abs() < 0.005, "{seen:?}");
        assert!((seen.wheel_angle_rad - 0.3).abs() < 0.016, "{seen:?}");
    }

    #[test]
    fn a_drive_ends_with_the_period_that_arrives_or_fails() {
        let failed = DriveStage::Failed(Trouble::Stalled);
        for end in [DriveStage::Arrived, failed] {
            let stage = |period| if period < 7 { DriveStage::Steering } else { end };
            let (moments, found) = driven(&ManoeuvreStart::default(), &Mounting::default(), stage);
            assert_eq!((moments.len(), moments[6].command.stage, found), (7, end, end));
            assert_eq!((moments[6].leg, moments[6].compensation_rad), (7, 0.1));
        }
    }

    #[test]
    fn a_drive_that_does_not_end_is_stopped() {
        let (moments, found) = driven(&ManoeuvreStart::default(), &Mounting::default(), |_| DriveStage::Steering);
        assert_eq!((moments.len(), found), (45_000, DriveStage::Driving));
    }
}
