//! The driver of the campaign. From the sensor readings, it steers to the angle, spins up, holds the level, coasts and pauses.

use crate::campaign::driving::{AT_REST_MPS, End, RunCommand, RunDriver, RunOrder, SETTLED_S};
use crate::map::{Gear, Vehicle};
use crate::record::campaign::RunPlan;
use crate::record::event::EventKind;
use crate::sim::{Fault, Measurement, Random, Stream, World, WorldCommand};
use crate::units::RAD_PER_DEG;
use serde::{Deserialize, Serialize};

/// One driven run.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct RunOutcome {
    /// The group, from 0.
    pub group: usize,
    /// Gear.
    pub gear: Gear,
    /// Torque level [N·m], gear frame.
    pub torque_nm: f64,
    /// Time when the level was applied, from the log's start [s].
    pub start_s: f64,
    /// Hold time [s].
    pub duration_s: f64,
    /// Encoder speed when it was applied [m/s], gear frame.
    pub start_speed_mps: f64,
    /// Speed at its end [m/s].
    pub end_speed_mps: f64,
    /// Reason for its end.
    pub end: End,
}

/// The wheel counts as at its angle within this [°].
const AT_ANGLE_DEG: f64 = 1.5;
/// A longer spin-up is aborted [s].
const SPIN_UP_LIMIT_S: f64 = 10.0;
/// Longer steering is aborted [s], and the run is driven at the current wheel angle.
const STEER_LIMIT_S: f64 = 20.0;
/// Time between changes of a dithered torque [s].
const DITHER_S: f64 = 0.3;

#[derive(Debug, Clone, Copy, PartialEq)]
enum RunPhase {
    Steer,
    Drive(RunDriver),
    Coast,
    Pause,
}

/// The driver of a campaign.
pub(crate) struct Runner {
    plan: Vec<RunPlan>,
    test_angle_deg: f64,
    index: usize,
    phase: RunPhase,
    since_s: f64,
    settled_since_s: f64,
    moved_at_s: f64,
    dither: Random,
    dithered: (f64, f64),
    event_on: bool,
    outcome: Option<RunOutcome>,
    outcomes: Vec<RunOutcome>,
}

impl Runner {
    pub(crate) fn new(plan: Vec<RunPlan>, vehicle: &Vehicle, seed: u64) -> Self {
        Self {
            plan,
            test_angle_deg: vehicle.test_angle_deg,
            index: 0,
            phase: RunPhase::Steer,
            since_s: 0.0,
            settled_since_s: 0.0,
            moved_at_s: 0.0,
            dither: Random::new(seed, Stream::Dither),
            dithered: (f64::NEG_INFINITY, 0.0),
            event_on: false,
            outcome: None,
            outcomes: Vec::new(),
        }
    }

    /// The runs driven so far.
    pub(crate) fn into_outcomes(self) -> Vec<RunOutcome> {
        self.outcomes
    }

    /// Decides for the next cycle; `None` when the campaign is over.
    pub(crate) fn decide(&mut self, world: &mut World) -> Option<WorldCommand> {
        let now_s = world.state().t_s;
        let seen = world.measure();
        let run = self.plan.get(self.index)?.clone();
        let sign = run.settings.gear.sign();
        let speed_mps = sign * seen.speed_mps.unwrap_or(0.0);
        let angle_rad = run.wheel_angle_deg.unwrap_or(self.test_angle_deg) * RAD_PER_DEG;
        let mut command = WorldCommand { torque_nm: 0.0, wheel_angle_rad: angle_rad, gear: Some(run.settings.gear) };
        if speed_mps.abs() > AT_REST_MPS {
            self.moved_at_s = now_s;
        }
        match self.phase {
            RunPhase::Steer => self.steer(now_s, &seen, angle_rad, world),
            RunPhase::Drive(_) | RunPhase::Coast | RunPhase::Pause => {}
        }
        match self.phase {
            RunPhase::Drive(driver) => self.drive(driver, (now_s, speed_mps), &run, world, &mut command),
            RunPhase::Coast => {
                if now_s - self.moved_at_s > SETTLED_S && now_s - self.since_s > SETTLED_S {
                    world.set_estop(false);
                    self.go(RunPhase::Pause, now_s);
                }
            }
            RunPhase::Pause => {
                if now_s - self.since_s >= run.settings.pause_s {
                    self.index += 1;
                    self.go(RunPhase::Steer, now_s);
                }
            }
            RunPhase::Steer => {}
        }
        Some(command)
    }

    fn go(&mut self, phase: RunPhase, now_s: f64) {
        self.phase = phase;
        self.since_s = now_s;
        self.settled_since_s = now_s;
    }

    fn steer(&mut self, now_s: f64, seen: &Measurement, angle_rad: f64, world: &mut World) {
        if (seen.wheel_angle_rad - angle_rad).abs() > AT_ANGLE_DEG * RAD_PER_DEG {
            self.settled_since_s = now_s;
        }
        let settled = now_s - self.settled_since_s >= SETTLED_S && now_s - self.moved_at_s >= SETTLED_S;
        if settled || now_s - self.since_s > STEER_LIMIT_S {
            world.begin_run();
            self.go(RunPhase::Drive(RunDriver::new(now_s)), now_s);
        }
    }

    fn begin_level(&mut self, run: &RunPlan, now_s: f64, speed_mps: f64) {
        self.moved_at_s = now_s;
        self.outcome = Some(RunOutcome {
            group: run.group,
            gear: run.settings.gear,
            torque_nm: run.torque_nm,
            start_s: now_s,
            duration_s: 0.0,
            start_speed_mps: speed_mps,
            end_speed_mps: speed_mps,
            end: End::TimeUp,
        });
    }

    fn end_level(&mut self, end: End, now_s: f64, speed_mps: f64) {
        if let Some(outcome) = self.outcome.take() {
            self.outcomes.push(RunOutcome { duration_s: now_s - outcome.start_s, end_speed_mps: speed_mps, end, ..outcome });
        }
        self.go(RunPhase::Coast, now_s);
    }

    fn drive(
        &mut self,
        mut driver: RunDriver,
        (now_s, speed_mps): (f64, f64),
        run: &RunPlan,
        world: &mut World,
        command: &mut WorldCommand,
    ) {
        let settings = &run.settings;
        let order = RunOrder {
            start_speed_mps: settings.start_speed_mps,
            spin_up_limit_s: SPIN_UP_LIMIT_S,
            end_speed_mps: settings.end_speed_mps,
            speed_limit_mps: settings.speed_limit_mps,
            stall_s: settings.stall_s,
            hold_s: settings.hold_s,
        };
        let decided = driver.decide(&order, now_s, speed_mps, self.moved_at_s);
        self.phase = RunPhase::Drive(driver);
        if decided == RunCommand::SpinUp {
            command.torque_nm = settings.gear.sign() * settings.spin_up_nm;
            return;
        }
        if self.outcome.is_none() {
            self.begin_level(run, now_s, speed_mps);
        }
        let end = match decided {
            RunCommand::Ended(end) => Some(end),
            _ => self.happen(now_s - driver.level_from_s().unwrap_or(now_s), run, world, command),
        };
        if let Some(end) = end {
            if self.event_on {
                world.inject(Fault::Cleared);
                self.event_on = false;
            }
            self.end_level(end, now_s, speed_mps);
            return;
        }
        if settings.dither_nm > 0.0 && now_s - self.dithered.0 >= DITHER_S {
            self.dithered = (now_s, settings.dither_nm * self.dither.normal());
        }
        let dither_nm = if settings.dither_nm > 0.0 { self.dithered.1 } else { 0.0 };
        command.torque_nm = settings.gear.sign() * (run.torque_nm + dither_nm);
    }

    /// Applies the run's event.
    fn happen(&mut self, held_s: f64, run: &RunPlan, world: &mut World, command: &mut WorldCommand) -> Option<End> {
        let event = run.settings.event?;
        let on = event.is_on(held_s);
        if on && event.kind == EventKind::SteerAway {
            command.wheel_angle_rad = event.angle_deg * RAD_PER_DEG;
        }
        if on == self.event_on {
            return None;
        }
        self.event_on = on;
        match event.kind {
            EventKind::EmergencyStop if on => {
                world.set_estop(true);
                return Some(End::EmergencyStop);
            }
            EventKind::WetPatch if on => world.inject(Fault::WetFloor { grip_nm: event.grip_nm }),
            EventKind::HandPush if on => world.inject(Fault::Push { force_n: run.settings.gear.sign() * event.force_n }),
            EventKind::WetPatch | EventKind::HandPush => world.inject(Fault::Cleared),
            EventKind::EmergencyStop | EventKind::SteerAway => {}
        }
        None
    }
}
