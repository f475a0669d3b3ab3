//! A shared library of the user's in place of the bundled controller. What it answers wrongly or late ends its run as a fault with a text.

use crate::control::{
    AngleStatus, DriveStep, Failure, Inputs, LateralTask, Outputs, Phase, PivotRequest, PivotSettings, PlanningSettings, Pose,
    SteeringFault, WheelPolicy,
};
use crate::library::{LibraryController, LibraryInputs, LibraryOutputs, LibraryPose, LibraryPresets};
use crate::map::Gear;
use crate::verify::controller_command::ControllerCommand;
use crate::verify::pivot_law::{PivotControl, PivotLaw};
use crate::verify::{Error, Result};
use std::f64::consts::PI;
use std::ffi::OsStr;
use std::time::{Duration, Instant};

/// The library that each run opens.
#[derive(Debug, Clone, Copy)]
pub(crate) struct LibraryLaw<'a> {
    pub(crate) command: &'a ControllerCommand,
}

/// The controller of one run.
pub(crate) struct LibraryUnderTest {
    planning: PlanningSettings,
    timeout: Duration,
    /// `None` after a fault.
    controller: Option<LibraryController>,
    request: Option<PivotRequest>,
    phase: Phase,
    /// Commands that a fault leaves in force: the wheel where it is, no torque.
    wheel_angle_rad: f64,
    fault: Option<String>,
}

impl PivotLaw for LibraryLaw<'_> {
    type Controller = LibraryUnderTest;

    fn controller(self, settings: &PivotSettings) -> Result<LibraryUnderTest> {
        let planning = settings.planning.checked()?;
        let presets = LibraryPresets {
            policy: i32::from(planning.policy == WheelPolicy::Mirror),
            right_angle_rad: planning.right_angle_rad,
            return_angle_rad: planning.return_angle_rad,
        };
        let path = self.command.program();
        let controller = LibraryController::open(OsStr::new(&path), &presets)
            .map_err(|fault| Error::ControllerLibrary { path: crate::text::shown(&path), fault: fault.to_string() })?;
        Ok(LibraryUnderTest {
            planning,
            timeout: self.command.timeout(),
            controller: Some(controller),
            request: None,
            phase: Phase::Idle,
            wheel_angle_rad: 0.0,
            fault: None,
        })
    }
}

/// The phase of an answer; `Err` holds what is wrong with it.
fn phase(outputs: &LibraryOutputs) -> std::result::Result<Phase, String> {
    Ok(match outputs.phase {
        0 => Phase::Idle,
        1 => Phase::WaitingForAngle,
        2 => Phase::SettingGear,
        3 => Phase::Driving,
        4 => Phase::WaitingForStandstill,
        5 => Phase::RestoringAngle,
        6 => Phase::Succeeded,
        7 => Phase::Failed(match outputs.failure {
            1 => Failure::ObstacleStop,
            2 => Failure::Steering(SteeringFault::Implausible),
            3 => Failure::Steering(SteeringFault::Stuck),
            4 => Failure::Steering(SteeringFault::TooSlow),
            5 => Failure::Steering(SteeringFault::Lost),
            6 => Failure::GearNotSet,
            7 => Failure::SpeedLost,
            8 => Failure::StoodStill,
            9 => Failure::TimeOut,
            10 => Failure::OutsideTable,
            other => return Err(format!("the failure is number {other}; allowed with phase 7: 1 to 10")),
        }),
        other => return Err(format!("the phase is number {other}; allowed: 0 to 7")),
    })
}

/// The gear of an answer.
fn gear(number: i32) -> std::result::Result<Option<Gear>, String> {
    match number {
        0 => Ok(None),
        1 => Ok(Some(Gear::Forward)),
        -1 => Ok(Some(Gear::Reverse)),
        other => Err(format!("the gear is number {other}; allowed: 1, 0 and -1")),
    }
}

impl LibraryUnderTest {
    /// Asks the library; `Err` holds what it did wrong.
    fn ask(&mut self, inputs: &Inputs) -> std::result::Result<Outputs, String> {
        let Some(controller) = &mut self.controller else { return Err(String::new()) };
        let readings = LibraryInputs {
            has_speed: i32::from(inputs.speed_mps.is_some()),
            speed_mps: inputs.speed_mps.unwrap_or(0.0),
            wheel_angle_rad: inputs.wheel_angle_rad,
            pose: pose_of(inputs.pose),
            gear: inputs.gear.map_or(0, |gear| gear.sign() as i32),
            emergency_stop: i32::from(inputs.estop),
        };
        let begun = Instant::now();
        let answer = controller.step(&readings);
        let taken = begun.elapsed();
        if taken > self.timeout {
            return Err(format!("its answer took {} ms; allowed: {} ms", taken.as_millis(), self.timeout.as_millis()));
        }
        let (phase, gear) = (phase(&answer)?, gear(answer.gear)?);
        if phase == Phase::Idle && self.request.is_some() {
            return Err("the phase is 0, idle, although a turn is requested".to_owned());
        }
        for (name, value, most) in [("torque_nm", answer.torque_nm, 1e6), ("wheel_angle_rad", answer.wheel_angle_rad, PI)] {
            if value.is_nan() || value.abs() > most {
                return Err(format!("{name} is {value}; allowed: -{most:.6} to {most:.6}"));
            }
        }
        // an end is final until the next request
        if self.phase.is_active() {
            self.phase = phase;
        }
        let sign = gear.map_or(1.0, Gear::sign);
        let shows = answer.has_drive != 0 && matches!(self.phase, Phase::Driving | Phase::WaitingForStandstill);
        let drive = shows.then_some(DriveStep {
            torque_nm: sign * answer.torque_nm,
            target_speed_mps: answer.target_speed_mps,
            speed_mps: answer.drive_speed_mps,
            accel_mps2: answer.accel_mps2,
            arc_m: answer.arc_m,
            limited: answer.limited != 0,
            outside_table: answer.outside_table != 0,
            end_reached: answer.end_reached != 0,
        });
        let task = match self.phase {
            Phase::Idle => LateralTask::Rest,
            Phase::RestoringAngle | Phase::Succeeded => LateralTask::Restore(answer.wheel_angle_rad),
            Phase::Failed(_) => LateralTask::Freeze,
            _ => LateralTask::Hold(answer.wheel_angle_rad),
        };
        Ok(Outputs {
            torque_nm: answer.torque_nm,
            wheel_angle_rad: answer.wheel_angle_rad,
            gear,
            phase: self.phase,
            direction: self.request.as_ref().map(|request| request.direction),
            angle: if self.phase == Phase::Driving { AngleStatus::Reached } else { AngleStatus::InProgress },
            task,
            restore: answer.restore != 0,
            drive,
        })
    }

    /// The commands after a fault: no torque, the wheel where it was.
    fn stopped(&self, inputs: &Inputs) -> Outputs {
        Outputs {
            torque_nm: 0.0,
            wheel_angle_rad: self.wheel_angle_rad,
            gear: inputs.gear,
            phase: Phase::Idle,
            direction: self.request.as_ref().map(|request| request.direction),
            angle: AngleStatus::InProgress,
            task: LateralTask::Rest,
            restore: false,
            drive: None,
        }
    }

    fn breaks(&mut self, fault: String) {
        self.fault.get_or_insert(fault);
        (self.controller, self.phase) = (None, Phase::Idle);
    }
}

fn pose_of(pose: Pose) -> LibraryPose {
    LibraryPose { x_m: pose.x_m, y_m: pose.y_m, heading_rad: pose.heading_rad }
}

impl PivotControl for LibraryUnderTest {
    fn request(&mut self, turn_rad: f64, pose: Pose) -> Result<()> {
        self.request = Some(self.planning.plan(turn_rad, pose)?);
        if let Some(controller) = &mut self.controller {
            self.phase = Phase::WaitingForAngle;
            let answer = controller.request(turn_rad, &pose_of(pose));
            if answer != 0 {
                self.breaks(format!("it refuses a turn of {:.1}° with the answer {answer}; allowed: 0", turn_rad.to_degrees()));
            }
        }
        Ok(())
    }

    fn phase(&self) -> Phase {
        self.phase
    }

    fn current(&self) -> Option<&PivotRequest> {
        self.request.as_ref()
    }

    fn step(&mut self, t_s: f64, inputs: &Inputs) -> Outputs {
        if self.controller.is_none() {
            return self.stopped(inputs);
        }
        match self.ask(inputs) {
            Ok(outputs) => {
                self.wheel_angle_rad = outputs.wheel_angle_rad;
                outputs
            }
            Err(fault) => {
                self.breaks(format!("at {t_s:.2} s: {fault}"));
                self.stopped(inputs)
            }
        }
    }

    fn fault(&self) -> Option<&str> {
        self.fault.as_deref()
    }
}
