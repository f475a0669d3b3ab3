//! From the stretches of a survey to segments of readings: where a resting wheel breaks away, where it comes to rest again, and the cuts
//! between.

use crate::campaign::Stretch;
use crate::fit::calibration::Calibration;
use crate::fit::drive::effective_torque::{EffectiveTorque, TorqueCursor};
use crate::fit::drive::torque_input::TorqueInput;
use crate::fit::motion::coarse_readings::replace_coarse_of;
use crate::fit::motion::expected_stop::readings_before_stop;
use crate::fit::motion::integration::Course;
use crate::fit::motion::log_data::LogData;
use crate::fit::motion::segment::Segment;
use crate::fit::motion::so_far::SoFar;
use crate::fit::noise::model::{Reading, UNKNOWN_SPEED_MPS};

/// Fewest readings of a segment.
const FEWEST_READINGS: usize = 8;
/// Shortest segment [s].
const SHORTEST_S: f64 = 0.08;
/// Largest speed at breakaway at which a start counts as a start from 0 [m/s].
const BELIEVABLE_START_MPS: f64 = 0.03;
/// Standard deviation of the speed at breakaway [m/s].
const ANCHOR_MPS: f64 = 3e-3;
/// Standard deviation of the time at which a step takes effect, beyond the log's dead time: jitter and sampling [s].
const STEP_TIMING_S: f64 = 2e-3;

/// Longest time from breakaway to the first sign of motion [s], and how much longer it takes with coarse steps.
const LONGEST_UNSEEN_S: f64 = 0.4;
const MORE_UNSEEN_S: f64 = 1.0;

/// The segments of all logs.
///
/// The results so far determine when a resting wheel breaks away and when it comes to rest. Without them starts are not anchored, and stops
/// are those of the survey. `transients` are skipped, unless the stretch starts from rest there.
pub(crate) fn all_segments(
    logs: &[LogData],
    calibration: &Calibration,
    lagged: &[EffectiveTorque],
    so_far: Option<SoFar>,
    transients: &[Vec<(f64, f64)>],
) -> Vec<Segment> {
    segments_of(logs, calibration, lagged, so_far, transients, |log, run| logs[log].chosen[run])
}

/// The segments of the stretches for which `is_wanted` holds, by log and stretch; otherwise as [`all_segments`].
pub(crate) fn segments_of(
    logs: &[LogData],
    calibration: &Calibration,
    lagged: &[EffectiveTorque],
    so_far: Option<SoFar>,
    transients: &[Vec<(f64, f64)>],
    is_wanted: impl Fn(usize, usize) -> bool,
) -> Vec<Segment> {
    let of_log = |(number, log)| {
        let of_log = OfLog { number, log, calibration, lagged: &lagged[number], so_far };
        of_log.segments(&transients[number], |run| is_wanted(number, run))
    };
    logs.iter().enumerate().flat_map(of_log).collect()
}

/// The log whose stretches become segments.
struct OfLog<'a> {
    number: usize,
    log: &'a LogData<'a>,
    calibration: &'a Calibration,
    lagged: &'a EffectiveTorque,
    so_far: Option<SoFar<'a>>,
}

/// Where a wheel starts from rest, and how well that is known.
struct StartFromRest {
    t_s: f64,
    start_std_mps: f64,
}

impl OfLog<'_> {
    fn segments(&self, transients: &[(f64, f64)], is_wanted: impl Fn(usize) -> bool) -> Vec<Segment> {
        let (condemned, gaps) = (self.condemned(), self.gaps());
        let mut cursor = self.lagged.cursor();
        let mut segments = Vec::new();
        for (run, stretch) in self.log.survey.stretches.iter().enumerate().filter(|(run, _)| is_wanted(*run)) {
            let breakaway = self.breakaway(stretch, &gaps, &mut cursor);
            let to_s = if self.so_far.is_some() { stretch.stopped_s.unwrap_or(stretch.to_s) } else { stretch.to_s };
            let mut whole = self.whole(run, stretch, breakaway.as_ref(), to_s);
            self.end_at_the_stop(&mut whole, stretch);
            let mut cuts: Vec<(f64, f64)> = near(&condemned, whole.start_s, to_s).to_vec();
            cuts.extend(near(&gaps, whole.start_s, to_s));
            // the time after the first step of a start from rest is anchored, and worth keeping
            cuts.extend(near(transients, whole.start_s, to_s).iter().filter(|c| !(whole.anchored && c.0 <= whole.start_s + 0.02)));
            let readings = std::mem::take(&mut whole.readings);
            split(&readings, &cuts, &whole, &mut segments);
        }
        segments
    }

    /// The cut intervals, with ends that rise.
    fn condemned(&self) -> Vec<(f64, f64)> {
        let mut intervals: Vec<(f64, f64)> = self.log.cuts.intervals.iter().map(|c| (c.0, c.1)).collect();
        intervals.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
        for k in 1..intervals.len() {
            intervals[k].1 = intervals[k].1.max(intervals[k - 1].1);
        }
        intervals
    }

    /// Where the effective torque is unknown or was not delivered, on the clock of the readings, with starts and ends that rise.
    fn gaps(&self) -> Vec<(f64, f64)> {
        let dead_time_s = self.dead_time_s();
        let unknown = self.lagged.gaps().iter().chain(&self.log.undelivered_s);
        let mut gaps: Vec<(f64, f64)> = unknown.map(|gap| (gap.0 + dead_time_s, gap.1 + dead_time_s)).collect();
        gaps.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
        for k in 1..gaps.len() {
            gaps[k].1 = gaps[k].1.max(gaps[k - 1].1);
        }
        gaps
    }

    fn dead_time_s(&self) -> f64 {
        self.calibration.dead_time_s[self.number]
    }

    /// When a wheel at rest breaks away: when the torque passes the holding torque. `None` if the stretch does not start from rest or the
    /// time is unknown.
    fn breakaway(&self, stretch: &Stretch, gaps: &[(f64, f64)], cursor: &mut TorqueCursor) -> Option<StartFromRest> {
        let surface = self.so_far?.surface(stretch.gear);
        if !stretch.from_rest {
            return None;
        }
        let threshold = surface.zero_torque_nm(0.002).unwrap_or(0.0).max(0.0);
        let mut torque = |t: f64| stretch.gear.sign() * cursor.at(t - self.dead_time_s()).torque_nm;
        // a speed in coarse steps shows motion late
        let [coarse_mps, _] = self.log.coarse_mps;
        let before_s = LONGEST_UNSEEN_S + if coarse_mps > 0.01 { MORE_UNSEEN_S } else { 0.0 };
        let t_s = first_crossing(stretch.from_s - before_s, stretch.from_s + 0.15, threshold, &mut torque)?;
        let believable = near(gaps, t_s, t_s).is_empty()
            && self.log.mean_speed(stretch.gear, t_s, self.calibration).is_none_or(|v| v < BELIEVABLE_START_MPS);
        believable.then(|| {
            // a step known to 2 ms only is a speed known to 2 ms × the acceleration it leads to
            let accel = surface.accel_mps2(0.0, torque(t_s + 0.2)).max(0.0);
            StartFromRest { t_s, start_std_mps: ANCHOR_MPS.hypot(STEP_TIMING_S * accel) }
        })
    }

    /// A stretch with all its readings up to `to_s`, uncut.
    fn whole(&self, run: usize, stretch: &Stretch, breakaway: Option<&StartFromRest>, to_s: f64) -> Segment {
        let (start_s, start_std_mps) = breakaway.map_or((stretch.from_s, UNKNOWN_SPEED_MPS), |b| (b.t_s, b.start_std_mps));
        let mut readings = self.log.readings(stretch.gear, start_s, to_s, self.calibration);
        if let Some(so_far) = self.so_far
            && self.log.input == TorqueInput::Command
        {
            let surface = so_far.surface(stretch.gear);
            let drive = (stretch.gear.sign(), self.dead_time_s(), self.calibration.drive.mean_lag_s());
            self.log.timing.add_to(&mut readings, start_s, drive, |v, u| surface.accel_mps2(v, u));
        }
        Segment {
            log: self.number,
            run,
            gear: stretch.gear,
            progress: self.log.progress[run],
            start_s,
            anchored: breakaway.is_some(),
            start_std_mps,
            readings,
        }
    }

    /// Removes the readings after the stop, if the stretch comes to rest.
    fn end_at_the_stop(&self, whole: &mut Segment, stretch: &Stretch) {
        let Some(so_far) = self.so_far.filter(|_| stretch.stopped_s.is_some()) else { return };
        let mut judged = whole.clone();
        replace_coarse_of(&mut judged, self.log, self.calibration.encoder_scale, (self.lagged, self.dead_time_s()), so_far);
        let course = Course::new(&judged, self.lagged, self.dead_time_s());
        // where a wrong surface expects no stop, the survey's stop counts
        let before = readings_before_stop(&course, so_far.surface(stretch.gear), so_far.noise, FEWEST_READINGS);
        let surveyed = whole.readings.partition_point(|r| r.t_s <= stretch.to_s);
        whole.readings.truncate(before.unwrap_or(surveyed));
    }
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

/// Readings further apart are in different segments [s].
const LONGEST_GAP_S: f64 = 0.15;

/// Splits readings at cuts and gaps into segments like `model`; the part after a cut is not anchored.
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
    // a slow speed source has longer intervals
    let intervals: Vec<f64> = readings.windows(2).map(|r| r[1].t_s - r[0].t_s).collect();
    let longest_s = if intervals.is_empty() { LONGEST_GAP_S } else { LONGEST_GAP_S.max(2.5 * crate::signal::median(&intervals)) };
    for reading in readings {
        let last = current.readings.last().map_or(if whole { model.start_s } else { reading.t_s }, |r| r.t_s);
        let broken = reading.t_s - last > longest_s || between(last, reading.t_s);
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
    use crate::map::Gear;

    #[test]
    fn a_cut_splits_a_segment_and_only_the_first_part_stays_anchored() {
        let readings: Vec<Reading> = (0..100u32).map(|k| Reading::single(f64::from(k) * 0.01, 0.1, 1, k)).collect();
        let model = Segment {
            log: 0,
            run: 0,
            gear: Gear::Forward,
            progress: [0.0; 2],
            start_s: -0.005,
            anchored: true,
            start_std_mps: 3e-3,
            readings: Vec::new(),
        };
        let mut segments = Vec::new();
        split(&readings, &[(0.405, 0.505)], &model, &mut segments);
        assert_eq!(segments.len(), 2);
        assert!(segments[0].anchored && (segments[0].start_s + 0.005).abs() < 1e-12 && segments[0].readings.len() == 41);
        assert!(!segments[1].anchored && (segments[1].start_s - 0.51).abs() < 1e-9);
    }
}
