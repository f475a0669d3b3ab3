//! Runs that could be driven, simulated on the fitted surface as `record` drives them.

use crate::campaign::driving::{AT_REST_MPS, CYCLE_S, End, RunCommand, RunDriver, RunOrder, SETTLED_S};
use crate::fit::drive::effective_torque::EffectiveTorque;
use crate::fit::drive::lagged_command::LaggedCommand;
use crate::fit::drive::step_timing::StepTiming;
use crate::fit::motion::segment::Segment;
use crate::fit::noise::model::{Reading, UNKNOWN_SPEED_MPS};
use crate::map::{AccelTable, Gear, PlannedRun};
use crate::signal::Series;

/// Steps of the simulation between two readings, and between two decisions of the driver.
const STEPS_PER_READING: u32 = 4;
/// Step of the simulation [s].
const STEP_S: f64 = CYCLE_S / STEPS_PER_READING as f64;
/// Time between two readings [s].
pub(crate) const READING_S: f64 = STEP_S * STEPS_PER_READING as f64;
/// Age of the speed that the driver sees, in steps: half the time of a reading, and its transmission in the vehicle.
const SEEN_LATE: usize = 3;
/// Mean time from reaching a speed to the command in response [s].
const ANSWER_S: f64 = SEEN_LATE as f64 * STEP_S + 0.5 * READING_S;
/// Longest time at a level [s], as in most campaigns; the longer one is for levels that hardly change the speed.
const HOLDS_S: [f64; 2] = [2.5, 6.0];
/// A level at which the wheel rests ends after this time [s].
pub(crate) const STALL_S: f64 = 1.0;
/// Pause at rest after a run [s]; settling is rest enough.
pub(crate) const PAUSE_S: f64 = 0.0;
/// A level after a spin-up ends below this speed [m/s].
const END_MPS: f64 = 0.03;
/// Time to settle at rest and at the wheel angle around a run, besides the pause [s], with the driver's cycles.
const SETTLE_S: f64 = 2.0 * SETTLED_S + 0.03;
/// Longest spin-up [s].
const LONGEST_SPIN_UP_S: f64 = 5.0;
/// Longest coast [s].
const LONGEST_COAST_S: f64 = 10.0;
/// Scatter of the delay of the messages that carry a step, root mean square [s]: of a usual bus.
const STEPS_LATE_S: f64 = 1e-3;
/// Margin of the speed limit of a level that slows down, above noise and the surface's error [m/s].
const SPEED_MARGIN_MPS: f64 = 0.2;
/// Below this speed the fit treats the wheel as coming to rest [m/s].
const SLOWEST_MPS: f64 = 0.02;
/// Standard deviations of the speed at breakaway [m/s] and of the time at which a step takes effect [s], as in the fit.
const ANCHOR_MPS: f64 = 3e-3;
const STEP_TIMING_S: f64 = 2e-3;
/// Fewest readings of a stretch.
const FEWEST_READINGS: usize = 8;

/// A stretch of a run: readings without noise, and the command.
pub(crate) struct DrivenPart {
    pub(crate) segment: Segment,
    pub(crate) speed_mps: Vec<f64>,
    pub(crate) command: EffectiveTorque,
}

/// A run driven on the surface.
pub(crate) struct Driven {
    /// With settling, coast and pause.
    pub(crate) seconds: f64,
    pub(crate) parts: Vec<DrivenPart>,
}

/// The vehicle in one gear, as fitted. All numbers are in the gear's frame.
pub(crate) struct PlannedVehicle {
    pub(crate) gear: Gear,
    pub(crate) surface: AccelTable,
    pub(crate) dead_time_s: f64,
    pub(crate) lag_s: f64,
    pub(crate) transient_s: f64,
    pub(crate) breakaway_nm: f64,
    pub(crate) fastest_mps: f64,
}

impl PlannedVehicle {
    /// A(V, U), extended linearly beyond the torques of the surface.
    pub(crate) fn accel_mps2(&self, speed_mps: f64, torque_nm: f64) -> f64 {
        let at = |u: f64| self.surface.accel_from_torque_clamped(speed_mps, u).unwrap_or(0.0);
        let breaks = self.surface.torque_nm().breaks();
        let (first, last) = (breaks[0], breaks[breaks.len() - 1]);
        let end = torque_nm.clamp(first, last);
        if end == torque_nm {
            return at(torque_nm);
        }
        let inner = if torque_nm < first { breaks[1] } else { breaks[breaks.len() - 2] };
        at(end) + (torque_nm - end) * (at(end) - at(inner)) / (end - inner)
    }

    /// Every level from rest to the full speed and to half of it, and after spin-ups of several torques to several speeds. A level that
    /// brakes hard ends before the wheel turns back. No run is faster than the vehicle was driven.
    pub(crate) fn candidates(&self, levels_nm: &[f64]) -> Vec<PlannedRun> {
        // to a millimetre per second: a sum of speeds is written into a campaign
        let top = (1e3 * self.fastest_mps).round() / 1e3;
        let rounded = |v: f64| (v * 20.0).floor() / 20.0;
        let late_s = self.dead_time_s + self.lag_s + ANSWER_S;
        let mut candidates = Vec::new();
        let mut add = |run: PlannedRun| candidates.extend(HOLDS_S.map(|hold_s| PlannedRun { hold_s, ..run }));
        let driving: Vec<f64> = levels_nm.iter().copied().filter(|u| *u > 1.3 * self.breakaway_nm).collect();
        for &torque_nm in levels_nm {
            let from_rest = PlannedRun {
                gear: self.gear,
                torque_nm,
                start_speed_mps: 0.0,
                spin_up_nm: None,
                speed_limit_mps: top,
                end_speed_mps: END_MPS,
                hold_s: 0.0,
            };
            if torque_nm > 0.0 {
                add(from_rest);
                add(PlannedRun { speed_limit_mps: rounded(0.5 * top), ..from_rest });
            }
            for &spin_up_nm in driving.iter().rev().step_by(2).filter(|u| (*u - torque_nm).abs() > 1e-9) {
                for share in [0.3, 0.6, 1.0] {
                    // the spin-up continues during the drive's delay
                    let start_speed_mps = rounded(share * top - late_s * self.accel_mps2(share * top, spin_up_nm).max(0.0));
                    let slows = self.accel_mps2(start_speed_mps, torque_nm) < 0.0;
                    let speed_limit_mps = if slows { rounded(share * top + SPEED_MARGIN_MPS) } else { top };
                    let run = PlannedRun { start_speed_mps, spin_up_nm: Some(spin_up_nm), speed_limit_mps, ..from_rest };
                    if start_speed_mps < 0.1 {
                        continue;
                    }
                    // braking past the stop would drive the wheel back
                    let early = (-self.accel_mps2(0.0, torque_nm) * late_s * 100.0).round() / 100.0;
                    let turns = torque_nm < -self.breakaway_nm;
                    if !turns || early < 0.5 * start_speed_mps {
                        add(PlannedRun { end_speed_mps: if turns { early.max(END_MPS) } else { END_MPS }, ..run });
                    }
                }
            }
        }
        candidates
    }

    /// Drives a run as `record` does; `None` when its speed is never reached, or when it ends before it differs from a shorter one.
    pub(crate) fn drive(&self, run: &PlannedRun) -> Option<Driven> {
        let mut way = SimulatedWay::new(self, 0.0, 0.0);
        let order = RunOrder {
            start_speed_mps: if run.spin_up_nm.is_some() { run.start_speed_mps } else { 0.0 },
            spin_up_limit_s: LONGEST_SPIN_UP_S,
            end_speed_mps: run.end_speed_mps,
            speed_limit_mps: run.speed_limit_mps,
            stall_s: STALL_S,
            hold_s: run.hold_s,
        };
        let mut driver = RunDriver::new(way.t_s);
        loop {
            match driver.decide(&order, way.t_s, way.seen_mps(), way.moved_s) {
                RunCommand::SpinUp => way.command(run.spin_up_nm?),
                RunCommand::Level => way.command(run.torque_nm),
                RunCommand::Ended(End::NoSpinUp) => return None,
                RunCommand::Ended(_) => break,
            }
            way.decide();
        }
        let held_s = way.t_s - driver.level_from_s()?;
        if run.hold_s > HOLDS_S[0] && held_s < HOLDS_S[0] {
            return None;
        }
        way.command(0.0);
        let from_s = way.t_s;
        while way.speed_mps != 0.0 && way.t_s - from_s < LONGEST_COAST_S {
            way.decide();
        }
        let seconds = from_s.max(way.moved_s) + SETTLE_S + PAUSE_S;
        Some(Driven { seconds, parts: way.parts() })
    }

    /// A driven stretch: `torque_nm` held for `seconds` from `start_speed_mps`.
    pub(crate) fn driven(&self, torque_nm: f64, start_speed_mps: f64, seconds: f64) -> Vec<DrivenPart> {
        let from_rest = start_speed_mps < 0.05 && torque_nm > 0.0;
        let mut way = if from_rest { SimulatedWay::new(self, 0.0, 0.0) } else { SimulatedWay::new(self, start_speed_mps, torque_nm) };
        way.command(torque_nm);
        let until_s = if from_rest { seconds + self.dead_time_s + self.lag_s } else { seconds };
        while way.t_s < until_s {
            way.step();
        }
        way.parts()
    }
}

/// A driving vehicle.
struct SimulatedWay<'a> {
    vehicle: &'a PlannedVehicle,
    command: Series,
    torque_nm: f64,
    speed_mps: f64,
    t_s: f64,
    moved_s: f64,
    steps: u32,
    /// Speeds of the last steps, the latest first [m/s].
    recent_mps: [f64; SEEN_LATE],
    from_rest: bool,
    /// (time, speed) of the readings.
    readings: Vec<(f64, f64)>,
}

impl<'a> SimulatedWay<'a> {
    fn new(vehicle: &'a PlannedVehicle, speed_mps: f64, torque_nm: f64) -> Self {
        Self {
            vehicle,
            command: Series { t_s: vec![-1.0], value: vec![torque_nm] },
            torque_nm,
            speed_mps,
            t_s: 0.0,
            moved_s: 0.0,
            steps: 0,
            recent_mps: [speed_mps; SEEN_LATE],
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
        self.recent_mps.rotate_right(1);
        self.recent_mps[0] = self.speed_mps;
        self.speed_mps = self.moved();
        self.t_s += STEP_S;
        self.steps += 1;
        if self.recent_mps[SEEN_LATE - 1].abs() > AT_REST_MPS {
            self.moved_s = self.t_s;
        }
        if self.steps.is_multiple_of(STEPS_PER_READING) {
            self.readings.push((self.t_s, self.speed_mps));
        }
    }

    /// Speed after one step [m/s]; backward if braking continues after the stop.
    fn moved(&self) -> f64 {
        let (v, torque_nm) = (self.speed_mps, self.torque_nm);
        let forward = if v == 0.0 { torque_nm > 0.0 } else { v > 0.0 };
        let (speed_mps, drive_nm) = if forward { (v, torque_nm) } else { (-v, -torque_nm) };
        let half = speed_mps + 0.5 * STEP_S * self.vehicle.accel_mps2(speed_mps, drive_nm);
        let next = (speed_mps + STEP_S * self.vehicle.accel_mps2(half.max(0.0), drive_nm)).max(0.0);
        if forward { next } else { -next }
    }

    /// The speed that the driver sees [m/s].
    fn seen_mps(&self) -> f64 {
        self.recent_mps[SEEN_LATE - 1]
    }

    /// Advances to the driver's next decision.
    fn decide(&mut self) {
        for _ in 0..STEPS_PER_READING {
            self.step();
        }
    }

    /// The stretches that the fit would use: moving, without the time after a step.
    fn parts(&self) -> Vec<DrivenPart> {
        let lagged = EffectiveTorque::lagged(LaggedCommand::new(&self.command, self.vehicle.lag_s));
        let moved = |r: &&(f64, f64)| r.1 > 0.0;
        let Some(first_s) = self.readings.iter().find(moved).map(|r| r.0 - READING_S) else { return Vec::new() };
        let dead = self.vehicle.dead_time_s;
        let first_nm = self.command.value.iter().copied().find(|u| *u > 0.0).unwrap_or_default();
        let first_mps2 = self.vehicle.accel_mps2(0.0, first_nm).max(0.0);
        let cut = |t: f64| {
            let first = if self.from_rest { 2 } else { 1 };
            self.command.t_s.iter().skip(first).any(|s| t >= s + dead && t < s + dead + self.vehicle.transient_s)
        };
        let mut parts: Vec<DrivenPart> = Vec::new();
        let mut open: Option<DrivenPart> = None;
        let timing = StepTiming::late(&self.command, STEPS_LATE_S);
        let mut close = |part: Option<DrivenPart>| {
            if let Some(mut part) = part.filter(|p| p.segment.readings.len() >= FEWEST_READINGS) {
                let drive = (1.0, dead, self.vehicle.lag_s);
                timing.add_to(&mut part.segment.readings, part.segment.start_s, drive, |v, u| self.vehicle.accel_mps2(v, u));
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
            let part = open.get_or_insert_with(|| DrivenPart {
                segment: Segment {
                    log: 0,
                    run: 0,
                    gear: Gear::Forward,
                    progress: [0.0; 2],
                    start_s: if anchored { first_s } else { t_s },
                    anchored,
                    start_std_mps: if anchored { ANCHOR_MPS.hypot(STEP_TIMING_S * first_mps2) } else { UNKNOWN_SPEED_MPS },
                    readings: Vec::new(),
                },
                speed_mps: Vec::new(),
                command: lagged.clone(),
            });
            part.segment.readings.push(Reading::single(t_s, speed_mps, 0, 0));
            part.speed_mps.push(speed_mps);
        }
        close(open.take());
        parts
    }
}
