//! Longitudinal: waits for the wheel, sets the gear, runs the drive law, stops, returns the wheel; and fails on any fault.

use crate::Gear;
use crate::drive_law::{DriveInputs, DriveLaw};
use crate::messages::{AngleStatus, DriveStep, Failure, Inputs, LateralTask, Phase, PivotRequest};
use crate::phase::Event;

/// Reaction after a failure. Never a driving torque.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum AfterFailure {
    /// No torque: friction stops it.
    Coast,
    /// Brakes with this deceleration [m/s²], by the map; the torque fades out below `fade_mps` so that a late speed reading does not turn
    /// braking into driving backwards.
    Brake {
        /// Deceleration [m/s²], positive.
        decel_mps2: f64,
        /// Speed below which the torque fades out [m/s].
        fade_mps: f64,
    },
}

/// Times and limits of the longitudinal module.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct LongitudinalSettings {
    /// Control period [s]. Default 0.02.
    pub period_s: f64,
    /// Below this speed [m/s] the wheel counts as resting. Default 0.02.
    pub standstill_mps: f64,
    /// Time constant of the low-pass for the detection of rest [s]. Default 0.1: the noise of a speed sensor at rest, 0.015 m/s for a
    /// bad one, then stays below the limit.
    pub standstill_filter_s: f64,
    /// … for this long [s] after the end: it rests. Default 0.3.
    pub stood_still_s: f64,
    /// … for this long [s] short of the end: the pivot has failed. Default 1.
    pub stood_short_s: f64,
    /// No speed reading for this long [s]: the sensor is lost. Default 0.1, five periods.
    pub speed_lost_s: f64,
    /// Longest wait for the gear [s]. Default 2.
    pub gear_s: f64,
    /// Longest drive, as a multiple of the planned time … Default 3.
    pub drive_factor: f64,
    /// … plus this [s]. Default 5.
    pub drive_extra_s: f64,
    /// Longest wait for standstill after the end [s]. Default 3.
    pub standstill_wait_s: f64,
    /// Reaction after a failure. Default: brake with 1 m/s², fading out below 0.15 m/s, which is the deceleration times 0.15 s of dead time
    /// and lag.
    pub after_failure: AfterFailure,
}

impl Default for LongitudinalSettings {
    fn default() -> Self {
        Self {
            period_s: 0.02,
            standstill_mps: 0.02,
            standstill_filter_s: 0.1,
            stood_still_s: 0.3,
            stood_short_s: 1.0,
            speed_lost_s: 0.1,
            gear_s: 2.0,
            drive_factor: 3.0,
            drive_extra_s: 5.0,
            standstill_wait_s: 3.0,
            after_failure: AfterFailure::Brake { decel_mps2: 1.0, fade_mps: 0.15 },
        }
    }
}

/// Commands and messages of the longitudinal module.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct LongitudinalOutputs {
    /// Torque [N·m], vehicle frame.
    pub torque_nm: f64,
    /// Gear; `None` is neutral.
    pub gear: Option<Gear>,
    /// Message to lateral.
    pub task: LateralTask,
    /// Message to planning.
    pub phase: Phase,
    /// Output of the drive law.
    pub drive: Option<DriveStep>,
}

/// The longitudinal module with its drive law and state.
#[derive(Debug, Clone)]
pub(crate) struct Longitudinal<L> {
    settings: LongitudinalSettings,
    law: L,
    request: Option<PivotRequest>,
    phase: Phase,
    in_phase_s: f64,
    standing_s: f64,
    no_speed_s: f64,
    /// Last speed reading [m/s], vehicle frame.
    speed_mps: f64,
    /// The same, low-pass filtered [m/s].
    smooth_mps: f64,
}

impl<L: DriveLaw> Longitudinal<L> {
    /// A module at rest.
    pub(crate) fn new(settings: LongitudinalSettings, law: L) -> Self {
        Self {
            settings,
            law,
            request: None,
            phase: Phase::Idle,
            in_phase_s: 0.0,
            standing_s: 0.0,
            no_speed_s: 0.0,
            speed_mps: 0.0,
            smooth_mps: 0.0,
        }
    }

    /// Phase of the pivot.
    pub(crate) fn phase(&self) -> Phase {
        self.phase
    }

    /// The request in force, or the last one; `None` before the first.
    pub(crate) fn current(&self) -> Option<&PivotRequest> {
        self.request.as_ref()
    }

    /// Accepts planning's request. Ignored during a pivot.
    pub(crate) fn request(&mut self, request: PivotRequest) {
        if !self.phase.is_active() {
            self.request = Some(request);
            self.go(Event::Requested);
            self.no_speed_s = 0.0;
        }
    }

    fn go(&mut self, event: Event) {
        let next = self.phase.after(event);
        if next != self.phase {
            self.phase = next;
            (self.in_phase_s, self.standing_s) = (0.0, 0.0);
        }
    }

    /// One period.
    pub(crate) fn step(&mut self, inputs: &Inputs, angle: AngleStatus) -> LongitudinalOutputs {
        let settings = self.settings;
        match inputs.speed_mps.filter(|v| v.is_finite()) {
            Some(speed_mps) => (self.speed_mps, self.no_speed_s) = (speed_mps, 0.0),
            None => self.no_speed_s += settings.period_s,
        }
        self.smooth_mps +=
            (self.speed_mps - self.smooth_mps) * settings.period_s / (settings.standstill_filter_s.max(0.0) + settings.period_s);
        // an implausible reading must not stay in the low-pass
        if !self.smooth_mps.is_finite() || self.smooth_mps.abs() > 100.0 {
            self.smooth_mps = self.speed_mps;
        }
        let standing = self.smooth_mps.abs() < settings.standstill_mps;
        self.standing_s = if standing { self.standing_s + settings.period_s } else { 0.0 };
        self.in_phase_s += settings.period_s;
        let mut drive = None;
        if self.phase.is_active()
            && let Some(event) = self.general_failure(inputs, angle).map(Event::Broken).or_else(|| self.progress(inputs, angle, &mut drive))
        {
            self.go(event);
        }
        // a law's torque is used only while driving: neither at the end nor in the period of a failure
        let drive = drive.filter(|_| matches!(self.phase, Phase::Driving | Phase::WaitingForStandstill));
        let torque_nm = match self.phase {
            Phase::Driving => drive.map_or(0.0, |d: DriveStep| d.torque_nm),
            Phase::Failed(_) => self.stopping_torque_nm(),
            _ => 0.0,
        };
        let sign = self.request.as_ref().map_or(1.0, |r| r.gear.sign());
        LongitudinalOutputs { torque_nm: sign * torque_nm, gear: self.gear(), task: self.task(), phase: self.phase, drive }
    }

    /// Failures that can occur in every phase.
    fn general_failure(&self, inputs: &Inputs, angle: AngleStatus) -> Option<Failure> {
        if inputs.estop {
            return Some(Failure::ObstacleStop);
        }
        match angle {
            AngleStatus::Fault(fault) => Some(Failure::Steering(fault)),
            _ => (self.no_speed_s > self.settings.speed_lost_s).then_some(Failure::SpeedLost),
        }
    }

    /// The event that ends this phase, or its own failure.
    fn progress(&mut self, inputs: &Inputs, angle: AngleStatus, drive: &mut Option<DriveStep>) -> Option<Event> {
        let settings = self.settings;
        let request = self.request.as_ref()?;
        match self.phase {
            Phase::WaitingForAngle => (angle == AngleStatus::Reached).then_some(Event::AngleReached),
            Phase::SettingGear if inputs.gear == Some(request.gear) => {
                self.law.start(request, inputs.pose);
                Some(Event::GearSet)
            }
            Phase::SettingGear => (self.in_phase_s > settings.gear_s).then_some(Event::Broken(Failure::GearNotSet)),
            Phase::Driving => {
                let speed_mps = request.gear.sign() * self.speed_mps;
                let Some(step) = self.law.step(request, &DriveInputs { speed_mps, pose: inputs.pose }) else {
                    return Some(Event::Broken(Failure::OutsideTable));
                };
                *drive = Some(step);
                if step.end_reached {
                    Some(Event::EndReached)
                } else if self.standing_s >= settings.stood_short_s {
                    Some(Event::Broken(Failure::StoodStill))
                } else if self.in_phase_s > settings.drive_factor * request.planned_s + settings.drive_extra_s {
                    Some(Event::Broken(Failure::TimeOut))
                } else {
                    None
                }
            }
            Phase::WaitingForStandstill if self.standing_s >= settings.stood_still_s => Some(Event::StoodStill),
            Phase::WaitingForStandstill => (self.in_phase_s > settings.standstill_wait_s).then_some(Event::Broken(Failure::TimeOut)),
            Phase::RestoringAngle => (angle == AngleStatus::Reached).then_some(Event::AngleRestored),
            Phase::Idle | Phase::Succeeded | Phase::Failed(_) => None,
        }
    }

    /// Torque after a failure, in the request's gear: against the motion or none, and none without a speed reading.
    fn stopping_torque_nm(&self) -> f64 {
        let AfterFailure::Brake { decel_mps2, fade_mps } = self.settings.after_failure else { return 0.0 };
        let Some(gear) = self.request.as_ref().map(|r| r.gear) else { return 0.0 };
        let speed_mps = gear.sign() * self.speed_mps;
        if self.no_speed_s > 0.0 || speed_mps <= self.settings.standstill_mps {
            return 0.0;
        }
        let torque_nm = self.law.braking_torque_nm(gear, speed_mps, decel_mps2);
        if torque_nm < 0.0 { torque_nm * (speed_mps / fade_mps).min(1.0) } else { 0.0 }
    }

    fn gear(&self) -> Option<Gear> {
        let gear = self.request.as_ref().map(|r| r.gear);
        match self.phase {
            Phase::Idle | Phase::Succeeded | Phase::WaitingForAngle => None,
            _ => gear,
        }
    }

    /// The message to lateral. The task after a success is the restoring that has just succeeded.
    fn task(&self) -> LateralTask {
        match (self.phase, self.request.as_ref()) {
            (Phase::Idle, _) | (_, None) => LateralTask::Rest,
            (Phase::RestoringAngle | Phase::Succeeded, Some(request)) => LateralTask::Restore(request.return_angle_rad),
            (Phase::Failed(_), _) => LateralTask::Freeze,
            (_, Some(request)) => LateralTask::Hold(request.wheel_angle_rad),
        }
    }
}
