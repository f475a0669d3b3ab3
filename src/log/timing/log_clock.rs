//! The recorder's own clock, which may be set back while it records.
//!
//! Messages that follow the step would be sorted among earlier ones. They are moved forward by the time that the clock was set back, so
//! that the log continues without a gap. A log whose parts are not in order of time looks similar, but its parts do not overlap.

use crate::log::timing::message_times::{SignalTimes, to_s};

/// A smaller step back is the disorder of a recorder with several threads [ns].
pub(crate) const LEAST_STEP_NS: i64 = 300_000_000;
/// Fewest messages on both sides of a step, in the time that passed twice, that show that the clock was set.
const FEWEST_TWICE: usize = 3;
/// Messages within this many intervals after a late part continue it.
const BESIDE: i64 = 5;
/// More steps than this are not caused by a clock.
const MOST_STEPS: usize = 50;
/// A time without any message that is worth a note [s].
const LONG_PAUSE_S: f64 = 5.0;

/// A place where the time of the log goes back.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct ClockStep {
    /// The latest time before it, and the first after it [ns].
    pub before_ns: i64,
    pub after_ns: i64,
    /// Number of values of each signal before it.
    pub values: Vec<usize>,
}

impl ClockStep {
    /// The same step after `so_far` more values of each signal.
    pub(crate) fn after(mut self, so_far: &[usize]) -> Self {
        self.values.iter_mut().zip(so_far).for_each(|(values, before)| *values += before);
        self
    }
}

/// The times of the log, with steps back removed.
pub(crate) struct LogTimes {
    /// One per value of each signal [s since the base].
    pub time_s: Vec<Vec<f64>>,
    /// By how much the clock was set back at each step [s].
    pub set_back_s: Vec<f64>,
}

/// Removes the `steps` that a clock made.
pub(crate) fn unfold(signals: &[SignalTimes<'_>], steps: &[ClockStep], base_ns: i64, notes: &mut Vec<String>) -> LogTimes {
    let mut time_s: Vec<Vec<f64>> = signals.iter().map(|s| s.times.iter().map(|t| to_s(t.log_ns, base_ns)).collect()).collect();
    let mut set_back_s = Vec::new();
    let is_clock = |step: &&ClockStep| steps.len() <= MOST_STEPS && is_clock(signals, step);
    let mut moved_s = 0.0;
    for step in steps.iter().filter(is_clock) {
        let (before_s, after_s) = (to_s(step.before_ns, base_ns), to_s(step.after_ns, base_ns));
        // the next message comes as soon after the last one as messages usually do
        let per_s: f64 = time_s.iter().map(|t| rate_hz(t)).sum();
        let back_s = before_s - after_s + if per_s > 0.0 { (1.0 / per_s).min(0.1) } else { 0.0 };
        for (times, from) in time_s.iter_mut().zip(&step.values) {
            times.iter_mut().skip(*from).for_each(|t| *t += back_s);
        }
        notes.push(format!(
            "the clock of the log was set back by {:.1} s at {:.1} s: later times are moved forward, without a gap",
            before_s - after_s,
            before_s + moved_s
        ));
        moved_s += back_s;
        set_back_s.push(back_s);
    }
    pause_note(&time_s, notes);
    LogTimes { time_s, set_back_s }
}

/// Messages per second, whatever the clock does in between.
fn rate_hz(time_s: &[f64]) -> f64 {
    let whole_s: f64 = time_s.windows(2).map(|t| (t[1] - t[0]).max(0.0)).sum();
    if whole_s > 0.0 { time_s.len() as f64 / whole_s } else { 0.0 }
}

/// Whether the clock was set at a step. A part of the log that was written late looks similar; but it fills a hole, and the messages
/// continue after the hole.
fn is_clock(signals: &[SignalTimes<'_>], step: &ClockStep) -> bool {
    signals.iter().zip(&step.values).any(|(signal, values)| {
        let (before, after) = signal.times.split_at((*values).min(signal.times.len()));
        let again: Vec<i64> = after.iter().map(|t| t.log_ns).take_while(|t| *t <= step.before_ns).collect();
        let (Some(&first), Some(&last)) = (again.first(), again.last()) else { return false };
        if again.len() < FEWEST_TWICE {
            return false;
        }
        let twice = before.iter().filter(|t| (first..=last).contains(&t.log_ns)).count();
        let beside = ((last - first) / again.len() as i64).saturating_mul(BESIDE);
        let goes_on = before.iter().any(|t| t.log_ns > last && t.log_ns - last <= beside);
        twice >= FEWEST_TWICE.max(again.len() / 4) || (twice == 0 && !goes_on)
    })
}

/// A note on the longest time in which nothing was recorded.
fn pause_note(time_s: &[Vec<f64>], notes: &mut Vec<String>) {
    let mut all: Vec<f64> = Vec::new();
    for times in time_s {
        // the ends of long intervals are enough
        let long = times.windows(2).filter(|t| t[1] - t[0] > LONG_PAUSE_S);
        all.extend(times.first().into_iter().chain(times.last()).chain(long.flatten()));
    }
    all.sort_unstable_by(f64::total_cmp);
    let Some(longest) = all.windows(2).max_by(|a, b| (a[1] - a[0]).total_cmp(&(b[1] - b[0]))) else { return };
    let inside = |t: &f64| *t > longest[0] && *t < longest[1];
    if longest[1] - longest[0] > LONG_PAUSE_S && !time_s.iter().flatten().any(inside) {
        notes.push(format!(
            "no message for {:.1} s from {:.1} s on: the recording paused, or its clock was set ahead",
            longest[1] - longest[0],
            longest[0]
        ));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::log::signal_map::SignalName;
    use crate::log::timing::message_times::MessageTimes;

    fn times(log_ms: impl Iterator<Item = i64>) -> Vec<MessageTimes> {
        log_ms.map(|ms| MessageTimes { log_ns: ms * 1_000_000, ..MessageTimes::default() }).collect()
    }

    fn unfolded(log_ms: &[i64], values: usize) -> (Vec<f64>, Vec<String>) {
        let times = times(log_ms.iter().copied());
        let step = ClockStep { before_ns: log_ms[values - 1] * 1_000_000, after_ns: log_ms[values] * 1_000_000, values: vec![values] };
        let mut notes = Vec::new();
        let signals = [SignalTimes { signal: SignalName::Speed, times: &times }];
        let found = unfold(&signals, &[step], times[0].log_ns, &mut notes);
        (found.time_s[0].clone(), notes)
    }

    #[test]
    fn a_clock_that_is_set_back_goes_on_without_a_gap() {
        let log_ms: Vec<i64> = (0..400).map(|k| 20 * k - if k >= 300 { 4000 } else { 0 }).collect();
        let (time_s, notes) = unfolded(&log_ms, 300);
        assert!(time_s.windows(2).all(|t| (t[1] - t[0] - 0.02).abs() < 0.006), "{time_s:?}");
        assert!(notes.len() == 1 && notes[0].contains("set back by 4.0 s"), "{notes:?}");
    }

    #[test]
    fn parts_out_of_order_are_no_clock() {
        let log_ms: Vec<i64> = (200..400).chain(0..200).map(|k| 20 * k).collect();
        let (time_s, notes) = unfolded(&log_ms, 200);
        assert!((time_s[200] + 4.0).abs() < 1e-9 && notes.is_empty());
    }
}
