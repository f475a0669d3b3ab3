//! Who drives the campaign: steers to the angle, spins up, holds the level, lets coast, pauses; by what the sensors say.

use crate::map::{Gear, Vehicle};
use crate::record::campaign::RunPlan;
use crate::record::event::EventKind;
use crate::sim::{Fault, Measurement, Random, Stream, World, WorldCommand};
use crate::units::RAD_PER_DEG;
use serde::{Deserialize, Serialize};

/// Why a level ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum End {
    /// It was held as long as planned.
    TimeUp,
    /// The speed limit was reached.
    SpeedLimit,
    /// A braking level had slowed the wheel to its end speed.
    Slowed,
    /// The wheel did not move.
    Stalled,
    /// The emergency stop was pressed.
    EmergencyStop,
    /// The spin-up did not reach its speed.
    NoSpinUp,
}

/// One run as it was driven.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct RunOutcome {
    /// The group, from 0.
    pub group: usize,
    /// Gear.
    pub gear: Gear,
    /// Torque level [N·m], gear frame.
    pub torque_nm: f64,
    /// When the level was applied, from the log's start [s].
    pub start_s: f64,
    /// How long it was held [s].
    pub duration_s: f64,
    /// Speed when it was applied, by the encoder [m/s], gear frame.
    pub start_speed_mps: f64,
    /// Speed when it ended [m/s].
    pub end_speed_mps: f64,
    /// Why it ended.
    pub end: End,
}

/// Time between two decisions [s]: a usual control cycle.
pub(crate) const CYCLE_S: f64 = 0.02;
/// The wheel counts as at its angle within this [°] ...
const AT_ANGLE_DEG: f64 = 1.5;
/// ... and as at rest below this speed [m/s], three quanta of a usual encoder with its noise ...
const AT_REST_MPS: f64 = 0.035;
/// ... for so long [s].
const SETTLED_S: f64 = 0.3;
/// A spin-up that takes longer is given up [s].
const SPIN_UP_LIMIT_S: f64 = 10.0;
/// Steering that takes longer is given up [s], and the run driven where the wheel is.
const STEER_LIMIT_S: f64 = 20.0;
/// A dithered torque changes this often [s].
const DITHER_S: f64 = 0.3;

#[derive(Debug, Clone, Copy, PartialEq)]
enum RunPhase {
    Steer,
    SpinUp,
    Hold,
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
            RunPhase::Steer => self.steer(now_s, &seen, angle_rad, &run, world),
            RunPhase::SpinUp => {
                if speed_mps >= run.settings.start_speed_mps {
                    self.go(RunPhase::Hold, now_s);
                } else if now_s - self.since_s > SPIN_UP_LIMIT_S {
                    self.begin_level(&run, now_s, speed_mps);
                    self.end_level(End::NoSpinUp, now_s, speed_mps);
                }
            }
            RunPhase::Hold | RunPhase::Coast | RunPhase::Pause => {}
        }
        match self.phase {
            RunPhase::Hold => self.hold(now_s, speed_mps, &run, world, &mut command),
            RunPhase::SpinUp => command.torque_nm = sign * run.settings.spin_up_nm,
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

    fn steer(&mut self, now_s: f64, seen: &Measurement, angle_rad: f64, run: &RunPlan, world: &mut World) {
        if (seen.wheel_angle_rad - angle_rad).abs() > AT_ANGLE_DEG * RAD_PER_DEG {
            self.settled_since_s = now_s;
        }
        let settled = now_s - self.settled_since_s >= SETTLED_S && now_s - self.moved_at_s >= SETTLED_S;
        if settled || now_s - self.since_s > STEER_LIMIT_S {
            world.begin_run();
            self.go(if run.settings.start_speed_mps > 0.0 { RunPhase::SpinUp } else { RunPhase::Hold }, now_s);
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

    fn hold(&mut self, now_s: f64, speed_mps: f64, run: &RunPlan, world: &mut World, command: &mut WorldCommand) {
        let settings = &run.settings;
        if self.outcome.is_none() {
            self.begin_level(run, now_s, speed_mps);
        }
        let held_s = now_s - self.since_s;
        let end = if settings.start_speed_mps > 0.0 && speed_mps < settings.end_speed_mps {
            Some(End::Slowed)
        } else if speed_mps >= settings.speed_limit_mps {
            Some(End::SpeedLimit)
        } else if now_s - self.moved_at_s > settings.stall_s {
            Some(End::Stalled)
        } else if held_s >= settings.hold_s {
            Some(End::TimeUp)
        } else {
            self.happen(held_s, run, world, command)
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

    /// Lets the run's event happen.
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
