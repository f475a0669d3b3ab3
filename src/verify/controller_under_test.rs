//! A process of the user's in place of the bundled controller. Whatever it does wrong ends its run as a fault with a text.

use crate::control::{AngleStatus, DriveStep, Inputs, LateralTask, Outputs, Phase, PivotRequest, PivotSettings, PlanningSettings, Pose};
use crate::map::Gear;
use crate::verify::Result;
use crate::verify::controller_command::ControllerCommand;
use crate::verify::controller_process::ControllerProcess;
use crate::verify::controller_protocol::{ControllerAnswer, StartLine, readings_line};
use crate::verify::pivot_law::{PivotControl, PivotLaw};

/// The process that each run starts.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ProcessLaw<'a> {
    pub(crate) command: &'a ControllerCommand,
    pub(crate) period_s: f64,
    pub(crate) wheel_radius_m: f64,
    pub(crate) torque_limit_nm: f64,
}

/// The process of one run.
pub(crate) struct ControllerUnderTest {
    planning: PlanningSettings,
    /// `None` after a fault.
    process: Option<ControllerProcess>,
    request: Option<PivotRequest>,
    turn_rad: f64,
    /// Number of turns requested.
    number: usize,
    phase: Phase,
    /// Commands that a fault leaves in force: the wheel where it is, no torque.
    wheel_angle_rad: f64,
    fault: Option<String>,
}

impl PivotLaw for ProcessLaw<'_> {
    type Controller = ControllerUnderTest;

    fn controller(self, settings: &PivotSettings) -> Result<ControllerUnderTest> {
        let planning = settings.planning.checked()?;
        let mut process = ControllerProcess::start(self.command)?;
        process.say(&StartLine::new(settings, self.period_s, self.wheel_radius_m, self.torque_limit_nm).line());
        Ok(ControllerUnderTest {
            planning,
            process: Some(process),
            request: None,
            turn_rad: 0.0,
            number: 0,
            phase: Phase::Idle,
            wheel_angle_rad: 0.0,
            fault: None,
        })
    }
}

impl ControllerUnderTest {
    /// Asks the process; `Err` holds what it did wrong.
    fn ask(&mut self, t_s: f64, inputs: &Inputs) -> Option<std::result::Result<ControllerAnswer, String>> {
        let turn = self.request.as_ref().map(|request| (self.number, self.turn_rad, request));
        let line = readings_line(t_s, inputs, turn);
        let answer = self.process.as_mut()?.ask(&line).map_err(|fault| fault.to_string());
        Some(answer.and_then(|answer| ControllerAnswer::read(&answer, self.request.is_some())))
    }

    fn outputs(&self, answer: &ControllerAnswer, inputs: &Inputs) -> Outputs {
        let sign = answer.gear.map_or(1.0, Gear::sign);
        let driving = self.phase == Phase::Driving;
        let drive = answer.desired.filter(|_| driving).map(|(target_speed_mps, accel_mps2)| DriveStep {
            torque_nm: sign * answer.torque_nm,
            target_speed_mps,
            speed_mps: sign * inputs.speed_mps.unwrap_or_default(),
            accel_mps2,
            ..DriveStep::default()
        });
        let task = match self.phase {
            Phase::Idle | Phase::Succeeded => LateralTask::Rest,
            Phase::RestoringAngle => LateralTask::Restore(answer.wheel_angle_rad),
            Phase::Failed(_) => LateralTask::Freeze,
            _ => LateralTask::Hold(answer.wheel_angle_rad),
        };
        Outputs {
            torque_nm: answer.torque_nm,
            wheel_angle_rad: answer.wheel_angle_rad,
            gear: answer.gear,
            phase: self.phase,
            direction: self.request.as_ref().map(|request| request.direction),
            angle: if driving { AngleStatus::Reached } else { AngleStatus::InProgress },
            task,
            restore: self.phase == Phase::RestoringAngle,
            drive,
        }
    }
}

impl PivotControl for ControllerUnderTest {
    fn request(&mut self, turn_rad: f64, pose: Pose) -> Result<()> {
        self.request = Some(self.planning.plan(turn_rad, pose)?);
        (self.turn_rad, self.number) = (turn_rad, self.number + 1);
        if self.fault.is_none() {
            self.phase = Phase::WaitingForAngle;
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
        let answer = match self.ask(t_s, inputs) {
            Some(Ok(answer)) => {
                // an end is final until the next request
                if self.phase.is_active() {
                    self.phase = answer.phase;
                }
                answer
            }
            broken => {
                if let Some(Err(fault)) = broken {
                    self.fault = Some(format!("at {t_s:.2} s: {fault}"));
                }
                self.process = None;
                self.phase = Phase::Idle;
                let wheel_angle_rad = self.wheel_angle_rad;
                ControllerAnswer { torque_nm: 0.0, wheel_angle_rad, gear: inputs.gear, phase: Phase::Idle, desired: None }
            }
        };
        self.wheel_angle_rad = answer.wheel_angle_rad;
        self.outputs(&answer, inputs)
    }

    fn fault(&self) -> Option<&str> {
        self.fault.as_deref()
    }
}
