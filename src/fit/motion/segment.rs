//! Segments: stretches of readings on one clock, ready to be integrated.

use crate::campaign::{Survey, Verdict};
use crate::fit::drive::effective_torque::EffectiveTorque;
use crate::fit::drive::step_timing::StepTiming;
use crate::fit::drive::torque_input::Input;
use crate::fit::motion::expected_stop::readings_before_stop;
use crate::fit::motion::integration::Course;
use crate::fit::noise::kalman::{Noise, Reading, UNKNOWN_SPEED_MPS};
use crate::fit::surface::lattice::LatticeSurface;
use crate::map::Gear;
use crate::signal::Series;
use std::collections::BTreeSet;

/// What turns raw readings into speeds on one clock, and commands into torques. Estimated with the surface.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Calibration {
    /// T_d of each log [s].
    pub(crate) dead_time_s: Vec<f64>,
    /// T_c [s].
    pub(crate) lag_s: f64,
    /// Encoder reading over true speed.
    pub(crate) encoder_scale: f64,
    /// How much later the encoder reads than the yaw rate [s].
    pub(crate) encoder_delay_s: f64,
}

/// A stretch of readings without interruption.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Segment {
    /// Index of the log.
    pub(crate) log: usize,
    /// Index of the stretch in the log's survey: the unit that is left out in cross-validation, and resampled in the sandwich.
    pub(crate) run: usize,
    pub(crate) gear: Gear,
    /// Where integration starts [s].
    pub(crate) start_s: f64,
    /// Whether the speed is 0 at the start.
    pub(crate) anchored: bool,
    /// Prior standard deviation of the speed at the start [m/s], before the noise of starts from rest is known.
    pub(crate) start_std_mps: f64,
    pub(crate) readings: Vec<Reading>,
}

impl Segment {
    /// Standard deviation of the speed at the start [m/s]: where it starts from rest, as unsure as starts have turned out to be.
    pub(crate) fn start_std(&self, noise: &Noise) -> f64 {
        if self.anchored { noise.start_scale * self.start_std_mps } else { self.start_std_mps }
    }
}

/// Surfaces and noise as found so far.
#[derive(Clone, Copy)]
pub(crate) struct SoFar<'a> {
    /// Forward, reverse.
    pub(crate) surfaces: &'a [LatticeSurface; 2],
    pub(crate) noise: &'a Noise,
}

/// What is left out of one log.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Cuts {
    /// Intervals [s], each with its verdict.
    pub(crate) intervals: Vec<(f64, f64, Verdict)>,
    /// Single readings: (witness, sample).
    pub(crate) readings: BTreeSet<(u8, u32)>,
}

/// Fewest readings of a segment.
const FEWEST_READINGS: usize = 8;
/// Shortest segment [s].
const SHORTEST_S: f64 = 0.08;
/// Speed at breakaway above which a start is not believed to start from 0 [m/s].
const BELIEVABLE_START_MPS: f64 = 0.03;
/// Standard deviation of the speed at breakaway [m/s].
const ANCHOR_MPS: f64 = 3e-3;
/// Standard deviation of the time at which a step takes effect, beyond the log's dead time: jitter and sampling [s].
const STEP_TIMING_S: f64 = 2e-3;

/// One log as the estimator sees it.
#[derive(Debug, Clone)]
pub(crate) struct LogData<'a> {
    pub(crate) survey: &'a Survey,
    /// The command [N·m], where it changes.
    pub(crate) command: Series,
    /// Where its effective torque comes from.
    pub(crate) input: Input,
    /// How well the steps of its command are known in time.
    pub(crate) timing: StepTiming,
    /// Outliers among the yaw readings.
    pub(crate) yaw_outliers: Vec<bool>,
    pub(crate) cuts: Cuts,
    /// Whether a start from rest may be taken as v = 0 at breakaway.
    pub(crate) may_anchor: bool,
    /// Which of the survey's stretches take part.
    pub(crate) chosen: Vec<bool>,
}

impl LogData<'_> {
    /// The effective torque; the lag counts for a command only.
    pub(crate) fn torque(&self, lag_s: f64) -> EffectiveTorque {
        self.input.torque(&self.survey.track, &self.command, lag_s)
    }

    /// The segments of this log. What was found so far tells when a resting wheel breaks away and when it comes to rest; without it starts are
    /// not anchored, and stops are where the survey has them. `transients` are left out, unless the stretch starts from rest there.
    pub(crate) fn segments(
        &self,
        log: usize,
        calibration: &Calibration,
        lagged: &EffectiveTorque,
        so_far: Option<SoFar>,
        transients: &[(f64, f64)],
    ) -> Vec<Segment> {
        let mut intervals: Vec<(f64, f64)> = self.cuts.intervals.iter().map(|c| (c.0, c.1)).collect();
        intervals.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
        for k in 1..intervals.len() {
            intervals[k].1 = intervals[k].1.max(intervals[k - 1].1);
        }
        let shifted = |gap: &(f64, f64)| (gap.0 + calibration.dead_time_s[log], gap.1 + calibration.dead_time_s[log]);
        let gaps: Vec<(f64, f64)> = lagged.gaps().iter().map(shifted).collect();
        let mut segments = Vec::new();
        let mut cursor = lagged.cursor();
        for (run, stretch) in self.survey.stretches.iter().enumerate().filter(|(run, _)| self.chosen[*run]) {
            let dead_time_s = calibration.dead_time_s[log];
            let mut start_s = stretch.from_s;
            let mut anchored = false;
            let mut start_std_mps = UNKNOWN_SPEED_MPS;
            if stretch.from_rest
                && self.may_anchor
                && let Some(SoFar { surfaces, .. }) = so_far
            {
                let surface = &surfaces[usize::from(stretch.gear == Gear::Reverse)];
                let threshold = surface.zero_torque_nm(0.002).unwrap_or(0.0).max(0.0);
                let mut torque = |t: f64| stretch.gear.sign() * cursor.at(t - dead_time_s).torque_nm;
                if let Some(t) = first_crossing(stretch.from_s - 0.4, stretch.from_s + 0.15, threshold, &mut torque)
                    && near(&gaps, t, t).is_empty()
                    && self.mean_speed(stretch.gear, t, calibration).is_none_or(|v| v < BELIEVABLE_START_MPS)
                {
                    start_s = t;
                    anchored = true;
                    // a step known to 2 ms only is a speed known to 2 ms × the acceleration it leads to
                    let accel = surface.accel_mps2(0.0, torque(t + 0.2)).max(0.0);
                    start_std_mps = ANCHOR_MPS.hypot(STEP_TIMING_S * accel);
                }
            }
            let to_s = if so_far.is_some() { stretch.stopped_s.unwrap_or(stretch.to_s) } else { stretch.to_s };
            let mut readings = self.readings(stretch.gear, start_s, to_s, calibration);
            if let Some(SoFar { surfaces, .. }) = so_far
                && self.input == Input::Command
            {
                let surface = &surfaces[usize::from(stretch.gear == Gear::Reverse)];
                let drive = (stretch.gear.sign(), dead_time_s, calibration.lag_s);
                self.timing.tell(&mut readings, start_s, drive, |v, u| surface.accel_mps2(v, u));
            }
            let mut whole = Segment { log, run, gear: stretch.gear, start_s, anchored, start_std_mps, readings };
            if let Some(SoFar { surfaces, noise }) = so_far
                && stretch.stopped_s.is_some()
            {
                let course = Course::new(&whole, lagged, dead_time_s);
                let surface = &surfaces[usize::from(stretch.gear == Gear::Reverse)];
                // where a surface that is wrong expects none, the survey's stop stands
                let before = readings_before_stop(&course, surface, noise, FEWEST_READINGS);
                let surveyed = whole.readings.partition_point(|r| r.t_s <= stretch.to_s);
                whole.readings.truncate(before.unwrap_or(surveyed));
            }
            let mut cuts: Vec<(f64, f64)> = near(&intervals, start_s, to_s).to_vec();
            cuts.extend(near(&gaps, start_s, to_s));
            // what follows the first step of a start from rest is anchored, and worth keeping
            cuts.extend(near(transients, start_s, to_s).iter().filter(|c| !(anchored && c.0 <= start_s + 0.02)));
            let readings = std::mem::take(&mut whole.readings);
            split(&readings, &cuts, &whole, &mut segments);
        }
        segments
    }

    fn readings(&self, gear: Gear, from_s: f64, to_s: f64, calibration: &Calibration) -> Vec<Reading> {
        let track = &self.survey.track;
        let encoder = &track.encoder_mps;
        let mut readings: Vec<Reading> = encoder
            .range(from_s + calibration.encoder_delay_s, to_s)
            .filter(|&k| !matches!(self.survey.verdicts[k], Verdict::Outlier))
            .map(|k| {
                let speed_mps = gear.sign() * encoder.value[k] / calibration.encoder_scale;
                Reading::single(encoder.t_s[k] - calibration.encoder_delay_s, speed_mps, 0, k as u32)
            })
            .collect();
        if let Some(yaw) = &track.yaw_speed_mps {
            readings.extend(yaw.range(from_s, to_s).filter(|&k| !self.yaw_outliers[k]).map(|k| {
                let speed_mps = gear.sign() * (yaw.value[k] - self.survey.yaw_bias_mps);
                Reading::single(yaw.t_s[k], speed_mps, 1, k as u32)
            }));
        }
        readings.retain(|r| !self.cuts.readings.contains(&(r.witness, r.sample)));
        readings.sort_by(|a, b| a.t_s.total_cmp(&b.t_s).then(a.witness.cmp(&b.witness)));
        readings
    }

    /// Mean speed over the 60 ms around `t_s`, gear frame.
    fn mean_speed(&self, gear: Gear, t_s: f64, calibration: &Calibration) -> Option<f64> {
        let readings = self.readings(gear, t_s - 0.04, t_s + 0.02, calibration);
        (!readings.is_empty()).then(|| readings.iter().map(|r| r.speed_mps).sum::<f64>() / readings.len() as f64)
    }
}

/// The segments of all logs.
pub(crate) fn all_segments(
    logs: &[LogData],
    calibration: &Calibration,
    lagged: &[EffectiveTorque],
    so_far: Option<SoFar>,
    transients: &[Vec<(f64, f64)>],
) -> Vec<Segment> {
    logs.iter().enumerate().flat_map(|(k, log)| log.segments(k, calibration, &lagged[k], so_far, &transients[k])).collect()
}

/// Time that a segment takes [s].
pub(crate) fn span_s(segment: &Segment) -> f64 {
    segment.readings.last().map_or(0.0, |r| r.t_s - segment.start_s)
}

/// The intervals that touch a stretch: both starts and ends rise.
fn near(intervals: &[(f64, f64)], from_s: f64, to_s: f64) -> &[(f64, f64)] {
    let first = intervals.partition_point(|c| c.1 < from_s);
    let last = intervals.partition_point(|c| c.0 <= to_s);
    &intervals[first..last.max(first)]
}

/// First time in an interval at which a rising torque passes `threshold`, to a millisecond.
fn first_crossing(from_s: f64, to_s: f64, threshold: f64, mut torque: impl FnMut(f64) -> f64) -> Option<f64> {
    let steps = ((to_s - from_s) / 1e-3) as usize;
    let mut before = torque(from_s);
    for k in 1..=steps {
        let t = from_s + k as f64 * 1e-3;
        let now = torque(t);
        if before <= threshold && now > threshold {
            return Some(t - 1e-3 * (now - threshold) / (now - before).max(1e-12));
        }
        before = now;
    }
    None
}

/// Splits readings at cuts and gaps into segments like `model`; what follows a cut is not anchored.
fn split(readings: &[Reading], cuts: &[(f64, f64)], model: &Segment, segments: &mut Vec<Segment>) {
    let inside = |t: f64| cuts.iter().any(|(from, to)| t >= *from && t <= *to);
    let between = |a: f64, b: f64| cuts.iter().any(|(from, to)| *from > a && *to < b);
    let mut current = Segment { readings: Vec::new(), ..model.clone() };
    let mut whole = true;
    let mut close = |current: &mut Segment| {
        let next = Segment { anchored: false, start_std_mps: UNKNOWN_SPEED_MPS, ..model.clone() };
        let done = std::mem::replace(current, next);
        if let (Some(first), Some(last)) = (done.readings.first(), done.readings.last())
            && done.readings.len() >= FEWEST_READINGS
            && last.t_s - first.t_s >= SHORTEST_S
        {
            let start_s = if done.anchored { done.start_s } else { first.t_s };
            segments.push(Segment { start_s, ..done });
        }
    };
    for reading in readings {
        let last = current.readings.last().map_or(if whole { model.start_s } else { reading.t_s }, |r| r.t_s);
        let broken = reading.t_s - last > 0.15 || between(last, reading.t_s);
        if broken || inside(reading.t_s) {
            close(&mut current);
            whole = false;
        }
        if !inside(reading.t_s) {
            current.readings.push(*reading);
        }
    }
    close(&mut current);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cut_splits_a_segment_and_only_the_first_part_stays_anchored() {
        let readings: Vec<Reading> = (0..100u32).map(|k| Reading::single(f64::from(k) * 0.01, 0.1, 1, k)).collect();
        let model =
            Segment { log: 0, run: 0, gear: Gear::Forward, start_s: -0.005, anchored: true, start_std_mps: 3e-3, readings: Vec::new() };
        let mut segments = Vec::new();
        split(&readings, &[(0.405, 0.505)], &model, &mut segments);
        assert_eq!(segments.len(), 2);
        assert!(segments[0].anchored && (segments[0].start_s + 0.005).abs() < 1e-12 && segments[0].readings.len() == 41);
        assert!(!segments[1].anchored && (segments[1].start_s - 0.51).abs() < 1e-9);
    }
}
