//! The survey of one log: a verdict on every sample, the usable stretches for a fit, the runs.

use crate::campaign::gates::within;
use crate::campaign::hold::{Hold, holds};
use crate::campaign::ledger::missing_seconds;
use crate::campaign::{Error, Result, SampleVerdict, SurveySettings, gates, ledger, sample_seconds, slip};
use crate::map::Gear;
use crate::signal::{Alignment, RestDetector, Series, Track};
use crate::units::RAD_PER_DEG;

/// An uninterrupted interval of motion with only usable samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stretch {
    /// Gear.
    pub gear: Gear,
    /// First usable time [s]. For a start from rest it is a little before the motion, which begins at breakaway.
    pub from_s: f64,
    /// Last usable time [s]. If the stretch ends in a stop, it is estimated from the readings alone.
    pub to_s: f64,
    /// For a stretch that ends in a stop: time from which the vehicle is at rest [s]. With a better estimate of the stop, the samples
    /// before this time are usable too.
    pub stopped_s: Option<f64>,
    /// Whether the vehicle was at rest just before, so that the speed starts from 0.
    pub from_rest: bool,
}

/// A held torque at rest, and whether it set the vehicle in motion: a bound of the breakaway torque.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct StartTrial {
    /// Gear.
    pub gear: Gear,
    /// Held torque [N·m], gear frame, positive.
    pub torque_nm: f64,
    /// Whether the vehicle moved.
    pub moved: bool,
}

/// Shortest hold that shows the acceleration by its torque [s].
const SHORTEST_HOLD_S: f64 = 0.25;

/// Result for the samples of one log, from its signals alone.
#[derive(Debug, Clone)]
pub struct Survey {
    /// The signals.
    pub track: Track,
    /// One verdict per encoder sample.
    pub verdicts: Vec<SampleVerdict>,
    /// The time that each encoder sample represents [s].
    pub seconds: Vec<f64>,
    /// Usable stretches, in order.
    pub stretches: Vec<Stretch>,
    /// Intervals of constant command, in order.
    pub(crate) holds: Vec<Hold>,
    /// Starts from rest, successful or not.
    pub(crate) start_trials: Vec<StartTrial>,
    /// Scale and delay of the encoder relative to the yaw rate, if there is one.
    pub(crate) alignment: Option<Alignment>,
    /// Bias of the yaw speed at rest [m/s], if there is one.
    pub yaw_bias_mps: f64,
    /// Range of the wheel angle while the vehicle moved: lowest, median, highest [°].
    pub moving_angle_deg: Option<[f64; 3]>,
}

impl Survey {
    /// The torques at which the runs of a gear were held, one for each hold of one value [N·m], gear frame.
    pub(crate) fn held_torques_nm(&self, gear: Gear) -> Vec<f64> {
        let in_gear = |hold: &&Hold| self.stretches.iter().any(|s| s.gear == gear && s.from_s < hold.to_s && s.to_s > hold.from_s);
        let held = self.holds.iter().filter(|h| h.steady && h.to_s - h.from_s > SHORTEST_HOLD_S);
        held.filter(in_gear).map(|h| gear.sign() * h.torque_nm).collect()
    }

    /// Judges every sample of `track`.
    ///
    /// # Errors
    /// A gate removes all samples; the error gives its threshold, the values found and values that would pass.
    pub fn new(track: Track, settings: &SurveySettings) -> Result<Self> {
        let encoder = &track.encoder_mps;
        let n = encoder.len();
        let rest = RestDetector::new(track.witnesses());
        let at_rest: Vec<bool> = rest.are_at_rest(encoder.t_s.iter().copied()).collect();
        let angle = gates::clean_angle(&track.angle_rad);
        let off_angle = gates::off_angle(&angle, track.wheel_angle_deg, settings);
        let steering = gates::steering(&angle, settings);
        let stops = track.estop.as_ref().map(gates::emergency_stops).unwrap_or_default();
        let command_gaps = gates::command_gaps(&track.command_nm, settings);
        let outliers = gates::outliers(encoder, settings.hampel_mads);
        let holds = holds(&track.command_nm, settings);
        let at_angle = |t: f64| !within(&off_angle, t) && !within(&steering, t);
        let alignment = track.yaw_speed_mps.as_ref().and_then(|yaw| Alignment::of(encoder, yaw, at_angle));
        let slips = match (&track.yaw_speed_mps, alignment) {
            (Some(yaw), Some(alignment)) => slip::slips(encoder, yaw, alignment, settings),
            _ => Vec::new(),
        };
        let speed = smoothed_speed(&track, alignment.unwrap_or(Alignment::SAME));
        let gears = gears(&track, &speed);
        let moving_angle_deg = moving_angle(&angle, encoder, &at_rest);
        let commanded = largest(&track.command_nm.value);

        let mut command = track.command_nm.cursor();
        let mut verdicts: Vec<SampleVerdict> = (0..n)
            .map(|i| {
                let t = encoder.t_s[i];
                let idle = command.held(t).is_none_or(|c| c.abs() <= settings.hold_tolerance * commanded);
                if within(&stops, t) {
                    SampleVerdict::EmergencyStop
                } else if at_rest[i] && idle {
                    SampleVerdict::NoTorque
                } else if within(&steering, t) {
                    SampleVerdict::SteeringMoving
                } else if within(&off_angle, t) {
                    SampleVerdict::WheelNotAtAngle
                } else if at_rest[i] {
                    SampleVerdict::AtRest
                } else if gears[i].is_none_or(|g| g.sign() * speed[i] < -settings.stopping_mps) {
                    SampleVerdict::WrongGear
                } else if within(&command_gaps, t) {
                    SampleVerdict::Gap
                } else if within(&slips, t) {
                    SampleVerdict::Slip
                } else if outliers[i] {
                    SampleVerdict::Outlier
                } else {
                    SampleVerdict::Used
                }
            })
            .collect();
        mark_aborted(encoder, &stops, &holds, &at_rest, &mut verdicts);
        mark_stopping(encoder, &speed, &at_rest, settings, &mut verdicts);
        let stretches = stretches(encoder, &gears, &at_rest, settings, &mut verdicts);
        let start_trials = start_trials(encoder, &gears, &holds, &verdicts, commanded * settings.hold_tolerance);
        let seconds = sample_seconds(encoder);
        let yaw_bias_mps = rest.biases_mps().get(1).copied().unwrap_or(0.0);
        let survey = Self { track, verdicts, seconds, stretches, holds, start_trials, alignment, yaw_bias_mps, moving_angle_deg };
        survey.check(settings, &at_rest, commanded)?;
        Ok(survey)
    }

    /// Time of the log without any encoder sample [s].
    pub fn missing_s(&self) -> f64 {
        missing_seconds(&self.track.encoder_mps, &self.seconds)
    }

    /// Reports the gate that removed all samples, if there is one.
    fn check(&self, settings: &SurveySettings, at_rest: &[bool], commanded: f64) -> Result<()> {
        let values = &self.track.command_nm.value;
        let (low_nm, high_nm) =
            (values.iter().fold(f64::INFINITY, |m, v| m.min(*v)), values.iter().fold(f64::NEG_INFINITY, |m, v| m.max(*v)));
        if high_nm - low_nm <= 1e-6 * commanded.max(1e-9) || commanded == 0.0 {
            return Err(Error::NoTorqueStep { low_nm, high_nm });
        }
        if !self.stretches.is_empty() {
            return Ok(());
        }
        let wanted_deg = self.track.wheel_angle_deg;
        let near = |d: f64| (d - wanted_deg).abs() <= settings.angle_tolerance_deg;
        let at_angle = self.track.angle_rad.value.iter().any(|a| near(a / RAD_PER_DEG));
        if let Some([low_deg, median_deg, high_deg]) = self.moving_angle_deg
            && (!at_angle || (low_deg > wanted_deg && !near(low_deg)) || (high_deg < wanted_deg && !near(high_deg)))
        {
            return Err(Error::NothingAtAngle { tolerance_deg: settings.angle_tolerance_deg, wanted_deg, low_deg, high_deg, median_deg });
        }
        if at_rest.iter().all(|r| *r) {
            return Err(Error::NoMotion { largest_mps: largest(&self.track.encoder_mps.value), torque_nm: commanded });
        }
        let rows = ledger(self.verdicts.iter().copied().zip(self.seconds.iter().copied()));
        let reasons = rows.iter().map(|r| format!("{} {:.1} s", r.verdict, r.seconds)).collect::<Vec<_>>().join(", ");
        Err(Error::NothingLeft { reasons })
    }
}

fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0f64, |m, v| m.max(v.abs()))
}

/// The encoder's mean over ±0.04 s, divided by its scale [m/s].
fn smoothed_speed(track: &Track, alignment: Alignment) -> Vec<f64> {
    track.encoder_mps.smoothed(0.04).iter().map(|v| v / alignment.scale).collect()
}

/// The gear engaged at each encoder sample, from the direction of travel if the log has no gear. `None` in neutral.
fn gears(track: &Track, speed_mps: &[f64]) -> Vec<Option<Gear>> {
    let mut logged = track.gear.as_ref().map(Series::cursor);
    let mut command = track.command_nm.cursor();
    let gear_at = |(t_s, speed_mps): (&f64, &f64)| {
        let direction = match &mut logged {
            Some(gear) => gear.held(*t_s)?,
            None if speed_mps.abs() > 0.01 => *speed_mps,
            None => command.held(*t_s)?,
        };
        if direction > 0.0 {
            Some(Gear::Forward)
        } else if direction < 0.0 {
            Some(Gear::Reverse)
        } else {
            None
        }
    };
    track.encoder_mps.t_s.iter().zip(speed_mps).map(gear_at).collect()
}

fn moving_angle(angle: &Series, encoder: &Series, at_rest: &[bool]) -> Option<[f64; 3]> {
    let mut angle_along = angle.cursor();
    let moving = (0..encoder.len()).filter(|i| !at_rest[*i]);
    let mut degrees: Vec<f64> = moving.filter_map(|i| angle_along.interpolated(encoder.t_s[i])).map(|a| a / RAD_PER_DEG).collect();
    if degrees.is_empty() {
        return None;
    }
    degrees.sort_unstable_by(f64::total_cmp);
    Some([degrees[0], degrees[degrees.len() / 2], degrees[degrees.len() - 1]])
}

/// A run interrupted by an emergency stop is lost from its torque step on until the vehicle is at rest.
fn mark_aborted(encoder: &Series, stops: &[(f64, f64)], holds: &[Hold], at_rest: &[bool], verdicts: &mut [SampleVerdict]) {
    for (from, to) in stops {
        // the command may fall to zero shortly before the stop's own message
        let before = from - 0.05;
        let run_from = holds.iter().rev().find(|h| h.from_s <= before).map_or(*from, |h| h.from_s);
        for i in encoder.range(run_from, *from) {
            if verdicts[i] == SampleVerdict::Used {
                verdicts[i] = SampleVerdict::Aborted;
            }
        }
        for i in encoder.count_until(*to)..encoder.len() {
            if at_rest[i] {
                break;
            }
            verdicts[i] = SampleVerdict::EmergencyStop;
        }
    }
}

/// The last interval before rest. A mean over some samples detects rest late, especially in hard braking, and readings at rest would look
/// like motion without acceleration. So the time of the stop is extrapolated from the readings before it, and the samples from a little
/// earlier on are left out.
fn mark_stopping(encoder: &Series, speed: &[f64], at_rest: &[bool], settings: &SurveySettings, verdicts: &mut [SampleVerdict]) {
    let stands = |verdicts: &[SampleVerdict], i: usize| at_rest[i] || verdicts[i] == SampleVerdict::WrongGear;
    for i in 1..encoder.len() {
        if !stands(verdicts, i) || verdicts[i - 1] != SampleVerdict::Used {
            continue;
        }
        let before: Vec<usize> =
            (0..i).rev().take_while(|k| verdicts[*k] == SampleVerdict::Used && encoder.t_s[i] - encoder.t_s[*k] < STOP_WINDOW_S).collect();
        let clear: Vec<usize> = before.iter().copied().filter(|k| encoder.value[*k].abs() > CLEARLY_MOVING_MPS).take(6).collect();
        let stop_s = stop_time(encoder, &clear).map_or(encoder.t_s[i] - 0.045, |t| t.min(encoder.t_s[i])) - STOP_MARGIN_S;
        for k in before {
            if encoder.t_s[k] > stop_s || speed[k].abs() < settings.stopping_mps {
                verdicts[k] = SampleVerdict::Stopping;
            }
        }
    }
}

/// Length of the search for a stop [s].
const STOP_WINDOW_S: f64 = 0.4;
/// A reading above this shows motion; noise and quantum are smaller [m/s].
const CLEARLY_MOVING_MPS: f64 = 0.04;
/// Time left out before a stop [s]: the encoder's delay, and the noise of the extrapolation.
const STOP_MARGIN_S: f64 = 0.02;

/// Time at which the line through the magnitudes of the readings `at` crosses zero, if it falls.
fn stop_time(encoder: &Series, at: &[usize]) -> Option<f64> {
    if at.len() < 3 {
        return None;
    }
    let n = at.len() as f64;
    let mean_t = at.iter().map(|k| encoder.t_s[*k]).sum::<f64>() / n;
    let mean_v = at.iter().map(|k| encoder.value[*k].abs()).sum::<f64>() / n;
    let (mut stt, mut stv) = (0.0, 0.0);
    for k in at {
        let dt = encoder.t_s[*k] - mean_t;
        stt += dt * dt;
        stv += dt * (encoder.value[*k].abs() - mean_v);
    }
    (stv < 0.0).then(|| mean_t - mean_v * stt / stv)
}

/// Joins used samples into stretches; samples of too short ones are marked.
fn stretches(
    encoder: &Series,
    gears: &[Option<Gear>],
    at_rest: &[bool],
    settings: &SurveySettings,
    verdicts: &mut [SampleVerdict],
) -> Vec<Stretch> {
    let longest_step = settings.gap_s.max(4.0 * encoder.median_period_s().min(1.0));
    let mut found = Vec::new();
    let mut i = 0;
    while i < encoder.len() {
        let Some(gear) = gears[i].filter(|_| verdicts[i] == SampleVerdict::Used) else {
            i += 1;
            continue;
        };
        let (first, mut last) = (i, i);
        let mut k = i + 1;
        while k < encoder.len() && gears[k] == Some(gear) && encoder.t_s[k] - encoder.t_s[last] <= longest_step {
            match verdicts[k] {
                SampleVerdict::Used => last = k,
                SampleVerdict::Outlier => {}
                _ => break,
            }
            k += 1;
        }
        i = last + 1;
        if encoder.t_s[last] - encoder.t_s[first] < settings.shortest_stretch_s {
            (first..=last)
                .filter(|s| verdicts[*s] == SampleVerdict::Used)
                .collect::<Vec<_>>()
                .into_iter()
                .for_each(|s| verdicts[s] = SampleVerdict::TooShort);
            continue;
        }
        let rested = |s: usize| at_rest[s] && matches!(verdicts[s], SampleVerdict::AtRest | SampleVerdict::NoTorque);
        let from_rest = first >= 3 && (first - 3..first).all(rested) && encoder.t_s[first] - encoder.t_s[first - 1] <= longest_step;
        let stopping = (i..encoder.len()).take_while(|k| verdicts[*k] == SampleVerdict::Stopping && gears[*k] == Some(gear)).last();
        let stopped_s = stopping.map(|k| encoder.t_s[k]);
        found.push(Stretch { gear, from_s: encoder.t_s[first], to_s: encoder.t_s[last], stopped_s, from_rest });
    }
    found
}

/// Torque steps with the vehicle at rest, long enough (0.5 s) to show whether it moves.
fn start_trials(encoder: &Series, gears: &[Option<Gear>], holds: &[Hold], verdicts: &[SampleVerdict], least_nm: f64) -> Vec<StartTrial> {
    holds
        .iter()
        .filter(|h| h.steady && h.torque_nm.abs() > least_nm && h.to_s - h.from_s >= 0.5)
        .filter_map(|h| {
            let samples = encoder.range(h.from_s, h.to_s);
            let first = samples.start;
            let gear = (*gears.get(first)?)?;
            let torque_nm = h.torque_nm * gear.sign();
            let starts_at_rest = matches!(verdicts.get(first)?, SampleVerdict::AtRest | SampleVerdict::NoTorque);
            let moving = samples.clone().filter(|i| verdicts[*i] == SampleVerdict::Used).count();
            let resting = samples.clone().filter(|i| verdicts[*i] == SampleVerdict::AtRest).count();
            (starts_at_rest && torque_nm > 0.0 && moving + resting > samples.len() / 2).then_some(StartTrial {
                gear,
                torque_nm,
                moved: moving > resting,
            })
        })
        .collect()
}
