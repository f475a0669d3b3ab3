//! Runs that could be driven, simulated along the fitted surface as `record` drives them.

use super::super::actuator::LaggedCommand;
use super::super::kalman::{Reading, UNKNOWN_SPEED_MPS};
use super::super::segment::Segment;
use crate::map::{AccelTable, Gear};
use crate::signal::Series;

/// Step of the simulation [s].
const STEP_S: f64 = 5e-3;
/// Steps between two readings.
const STEPS_PER_READING: u32 = 4;
/// Time between two readings [s].
pub(super) const READING_S: f64 = STEP_S * STEPS_PER_READING as f64;
/// Longest time at a level [s].
pub(super) const HOLD_S: f64 = 2.5;
/// A level at which the wheel rests ends after this time [s].
pub(super) const STALL_S: f64 = 1.0;
/// Pause at rest after a run [s].
pub(super) const PAUSE_S: f64 = 0.15;
/// A level after a spin-up ends below this speed [m/s].
pub(super) const END_MPS: f64 = 0.03;
/// What settling at rest and at the wheel angle takes around a run, beside the pause [s].
const SETTLE_S: f64 = 0.6;
/// A spin-up that takes longer is no good [s].
const LONGEST_SPIN_UP_S: f64 = 5.0;
/// Longest coast [s].
const LONGEST_COAST_S: f64 = 10.0;
/// Below this speed the fit takes the wheel as coming to rest [m/s].
const SLOWEST_MPS: f64 = 0.02;
/// Standard deviation of the speed at breakaway [m/s], as the fit takes it.
const ANCHOR_MPS: f64 = 3e-3;
/// Fewest readings of a stretch.
const FEWEST_READINGS: usize = 8;

/// A run that could be driven: from rest, or after a spin-up.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Candidate {
    pub(super) gear: Gear,
    pub(super) torque_nm: f64,
    pub(super) start_speed_mps: f64,
    pub(super) spin_up_nm: f64,
    pub(super) speed_limit_mps: f64,
}

/// A stretch of a run: readings without noise, the command behind them.
pub(super) struct Part {
    pub(super) segment: Segment,
    pub(super) speed_mps: Vec<f64>,
    pub(super) command: LaggedCommand,
}

/// A run driven on the surface.
pub(super) struct Driven {
    /// With settling, coast and pause.
    pub(super) seconds: f64,
    pub(super) parts: Vec<Part>,
}

/// The vehicle in one gear, as the fit knows it. All numbers are in the gear's frame.
pub(super) struct Vehicle {
    pub(super) gear: Gear,
    pub(super) surface: AccelTable,
    pub(super) dead_time_s: f64,
    pub(super) lag_s: f64,
    pub(super) transient_s: f64,
    pub(super) breakaway_nm: f64,
    pub(super) fastest_mps: f64,
}

impl Vehicle {
    pub(super) fn accel_mps2(&self, speed_mps: f64, torque_nm: f64) -> f64 {
        self.surface.accel_from_torque_clamped(speed_mps, torque_nm).unwrap_or(0.0)
    }

    /// Every level from rest to the full speed and to half of it, and after spin-ups of several torques to several speeds.
    pub(super) fn candidates(&self, levels_nm: &[f64]) -> Vec<Candidate> {
        let limit = self.fastest_mps;
        let to = |share: f64| (limit * share * 20.0).round() / 20.0;
        let mut candidates = Vec::new();
        for &torque_nm in levels_nm {
            if torque_nm > 0.0 {
                for speed_limit_mps in [limit, to(0.5)] {
                    candidates.push(Candidate { gear: self.gear, torque_nm, start_speed_mps: 0.0, spin_up_nm: 0.0, speed_limit_mps });
                }
            }
            let driving: Vec<f64> = levels_nm.iter().copied().filter(|u| *u > 1.3 * self.breakaway_nm).collect();
            for spin_up_nm in driving.iter().rev().step_by(2).copied() {
                for start_speed_mps in [to(0.3), to(0.6), to(0.9)] {
                    if start_speed_mps > 0.1 && (spin_up_nm - torque_nm).abs() > 1e-9 {
                        candidates.push(Candidate { gear: self.gear, torque_nm, start_speed_mps, spin_up_nm, speed_limit_mps: limit });
                    }
                }
            }
        }
        candidates
    }

    /// Drives a run; `None` when its speed is never reached.
    pub(super) fn drive(&self, run: &Candidate) -> Option<Driven> {
        let mut way = Way::new(self, 0.0, 0.0);
        if run.start_speed_mps > 0.0 {
            way.command(run.spin_up_nm);
            while way.speed_mps < run.start_speed_mps {
                way.step();
                if way.t_s > LONGEST_SPIN_UP_S {
                    return None;
                }
            }
        }
        way.command(run.torque_nm);
        let from_s = way.t_s;
        while way.t_s - from_s < HOLD_S && way.speed_mps < run.speed_limit_mps {
            way.step();
            let slowed = run.start_speed_mps > 0.0 && way.speed_mps < END_MPS;
            if slowed || way.t_s - from_s.max(way.moved_s) > STALL_S {
                break;
            }
        }
        way.command(0.0);
        let from_s = way.t_s;
        while way.speed_mps > 0.0 && way.t_s - from_s < LONGEST_COAST_S {
            way.step();
        }
        let seconds = way.t_s + SETTLE_S + PAUSE_S;
        Some(Driven { seconds, parts: way.parts() })
    }

    /// A stretch that was driven: `torque_nm` held for `seconds` from `start_speed_mps`.
    pub(super) fn driven(&self, torque_nm: f64, start_speed_mps: f64, seconds: f64) -> Vec<Part> {
        let from_rest = start_speed_mps < 0.05 && torque_nm > 0.0;
        let mut way = if from_rest { Way::new(self, 0.0, 0.0) } else { Way::new(self, start_speed_mps, torque_nm) };
        way.command(torque_nm);
        let until_s = if from_rest { seconds + self.dead_time_s + self.lag_s } else { seconds };
        while way.t_s < until_s {
            way.step();
        }
        way.parts()
    }
}

/// A vehicle on its way.
struct Way<'a> {
    vehicle: &'a Vehicle,
    command: Series,
    torque_nm: f64,
    speed_mps: f64,
    t_s: f64,
    moved_s: f64,
    steps: u32,
    from_rest: bool,
    /// (time, speed) of the readings.
    readings: Vec<(f64, f64)>,
}

impl<'a> Way<'a> {
    fn new(vehicle: &'a Vehicle, speed_mps: f64, torque_nm: f64) -> Self {
        Self {
            vehicle,
            command: Series { t_s: vec![-1.0], value: vec![torque_nm] },
            torque_nm,
            speed_mps,
            t_s: 0.0,
            moved_s: 0.0,
            steps: 0,
            from_rest: speed_mps <= 0.0,
            readings: Vec::new(),
        }
    }

    fn command(&mut self, torque_nm: f64) {
        if self.command.value.last() != Some(&torque_nm) {
            self.command.t_s.push(self.t_s);
            self.command.value.push(torque_nm);
        }
    }

    fn step(&mut self) {
        let k = self.command.t_s.partition_point(|t| *t <= self.t_s + 0.5 * STEP_S - self.vehicle.dead_time_s);
        let target = self.command.value[k.max(1) - 1];
        let decay = if self.vehicle.lag_s > 1e-4 { (-STEP_S / self.vehicle.lag_s).exp() } else { 0.0 };
        self.torque_nm = target + (self.torque_nm - target) * decay;
        let half = self.speed_mps + 0.5 * STEP_S * self.vehicle.accel_mps2(self.speed_mps, self.torque_nm);
        self.speed_mps = (self.speed_mps + STEP_S * self.vehicle.accel_mps2(half.max(0.0), self.torque_nm)).max(0.0);
        self.t_s += STEP_S;
        self.steps += 1;
        if self.speed_mps > END_MPS {
            self.moved_s = self.t_s;
        }
        if self.steps.is_multiple_of(STEPS_PER_READING) {
            self.readings.push((self.t_s, self.speed_mps));
        }
    }

    /// The stretches that the fit would use: moving, without what follows a step.
    fn parts(&self) -> Vec<Part> {
        let lagged = LaggedCommand::new(&self.command, self.vehicle.lag_s);
        let moved = |r: &&(f64, f64)| r.1 > 0.0;
        let Some(first_s) = self.readings.iter().find(moved).map(|r| r.0 - READING_S) else { return Vec::new() };
        let dead = self.vehicle.dead_time_s;
        let cut = |t: f64| {
            let first = if self.from_rest { 2 } else { 1 };
            self.command.t_s.iter().skip(first).any(|s| t >= s + dead && t < s + dead + self.vehicle.transient_s)
        };
        let mut parts: Vec<Part> = Vec::new();
        let mut open: Option<Part> = None;
        let mut close = |part: Option<Part>| {
            if let Some(part) = part.filter(|p| p.segment.readings.len() >= FEWEST_READINGS) {
                parts.push(part);
            }
        };
        for (k, (t_s, speed_mps)) in self.readings.iter().copied().filter(|r| r.0 > first_s).enumerate() {
            let anchored = k == 0 && self.from_rest;
            let slow = speed_mps < SLOWEST_MPS && !open.as_ref().is_some_and(|p| p.segment.anchored && p.segment.readings.len() < 6);
            if cut(t_s) || (slow && !anchored) {
                close(open.take());
                continue;
            }
            let part = open.get_or_insert_with(|| Part {
                segment: Segment {
                    log: 0,
                    run: 0,
                    gear: Gear::Forward,
                    start_s: if anchored { first_s } else { t_s },
                    anchored,
                    start_std_mps: if anchored { ANCHOR_MPS } else { UNKNOWN_SPEED_MPS },
                    readings: Vec::new(),
                },
                speed_mps: Vec::new(),
                command: lagged.clone(),
            });
            part.segment.readings.push(Reading { t_s, speed_mps, witness: 0, sample: 0 });
            part.speed_mps.push(speed_mps);
        }
        close(open.take());
        parts
    }
}
