//! The clock that stamped the messages of one signal, compared with the clock of the log.
//!
//! Stamp minus log time is minus the delay of the message, plus the offset of the stamp's clock. The delay varies from message to message,
//! but it is never negative, so the highest differences follow the clock. Where they jump the clock was set; where they rise or fall slowly
//! it drifts; where many messages have one stamp it stands still.

use crate::log::signal_map::SignalName;
use crate::log::timing::message_times::{FEWEST, SignalTimes, TimeSource, to_s, usual};
use crate::log::timing::rhythm::{Rhythm, middle};

/// A stamp that stands still for longer than this is not used [s].
const FROZEN_S: f64 = 0.3;
/// A jump of a stamp that may be the scatter of stamps and arrivals [s].
const LEAST_JUMP_S: f64 = 0.05;
/// The same for signals without a period.
const LEAST_RARE_JUMP_S: f64 = 0.25;
/// A shorter part between two jumps shows no clock.
const SHORTEST_PART: usize = 5;
/// Messages at the border of a part that show its offset.
const BORDER: usize = 100;
/// Windows for the drift, and fewest messages in each.
const WINDOWS: usize = 24;
const FEWEST_OF_WINDOW: usize = 30;
/// A drift counts if it is at least this many standard errors, and at least this change over the log [s].
const SIGNIFICANT: f64 = 6.0;
const LEAST_DRIFT_S: f64 = 0.005;
/// A scatter of the stamps above this hides a drift [s].
const MOST_SCATTER_S: f64 = 0.006;
/// A larger drift is not that of a clock.
const MOST_DRIFT: f64 = 0.02;

/// The stamps of one signal after their clock's own faults are removed.
#[derive(Debug, Clone)]
pub(crate) struct StampClock {
    pub source: TimeSource,
    /// The stamps [s]; absent where the log's time is used.
    pub time_s: Option<Vec<f64>>,
    /// How far the earliest arrivals are stamped ahead of the log's time [s]: minus the shortest delay, if the clocks agree.
    pub ahead_s: f64,
    /// Whether the recorder wrote the messages in bursts.
    pub log_in_bursts: bool,
    /// Whether any stamp differs from that of its message.
    is_moved: bool,
    faults: Vec<String>,
}

impl StampClock {
    /// From the times of a signal whose log times are `log_s`, after the clock of the log was set back by each of `set_back_s`.
    pub(crate) fn of(signal: &SignalTimes<'_>, log_s: &[f64], base_ns: i64, set_back_s: &[f64]) -> Self {
        let have = |source: TimeSource| signal.times.iter().filter(|t| source.of(t).is_some()).count();
        let source = if 2 * have(TimeSource::Stamp) > signal.times.len() {
            TimeSource::Stamp
        } else if 2 * have(TimeSource::Publish) > signal.times.len() && signal.times.iter().any(|t| t.publish_ns != t.log_ns) {
            TimeSource::Publish
        } else {
            TimeSource::Log
        };
        let log_in_bursts = Rhythm::of(log_s).is_some_and(|rhythm| rhythm.comes_in_bursts);
        if source == TimeSource::Log {
            // a few stamps among messages without one would mix two clocks
            let mixed = signal.times.iter().any(|t| usual(t) != t.log_ns);
            let faults = if mixed { vec!["most messages have none: the log's time is used".to_owned()] } else { Vec::new() };
            return Self { source, time_s: None, ahead_s: 0.0, log_in_bursts, is_moved: false, faults };
        }
        let mut time_s: Vec<f64> = signal.times.iter().map(|t| source.of(t).map_or(f64::NAN, |t| to_s(t, base_ns))).collect();
        let mut clock = Self { source, time_s: None, ahead_s: 0.0, log_in_bursts, is_moved: false, faults: Vec::new() };
        if time_s.len() >= FEWEST && !clock.repair(&mut time_s, log_s, set_back_s) {
            return clock;
        }
        clock.ahead_s = highest(time_s.iter().zip(log_s).map(|(t, l)| t - l));
        clock.time_s = Some(time_s);
        clock
    }

    /// Whether the stamps differ from those of the messages.
    pub(crate) fn is_corrected(&self) -> bool {
        self.is_moved || !self.faults.is_empty()
    }

    /// The note on the faults of the clock.
    pub(crate) fn note(&self, signal: SignalName) -> Option<String> {
        let name = if self.source == TimeSource::Publish { TimeSource::Publish.name() } else { TimeSource::Stamp.name() };
        (!self.faults.is_empty()).then(|| format!("{name} of {signal}: {}", self.faults.join("; ")))
    }

    /// Removes the faults; `false` if the stamps are of no use.
    fn repair(&mut self, time_s: &mut [f64], log_s: &[f64], set_back_s: &[f64]) -> bool {
        let is_sound = sound(time_s, log_s);
        let parts = parts(time_s, log_s, &is_sound);
        let used: usize = parts.iter().map(ExactSizeIterator::len).sum();
        let (count, lost) = (time_s.len(), time_s.len() - used);
        if 2 * used <= count {
            self.faults.push(format!("{lost} of {count} stand still or jump: the log's time is used"));
            self.source = TimeSource::Log;
            return false;
        }
        let ahead = |t: &[f64], range: std::ops::Range<usize>| highest(range.map(|k| t[k] - log_s[k]));
        for pair in parts.windows(2) {
            let (before, after) = (pair[0].clone(), pair[1].clone());
            let border = ahead(time_s, before.end.saturating_sub(BORDER).max(before.start)..before.end);
            let jump_s = ahead(time_s, after.start..after.end.min(after.start + BORDER)) - border;
            time_s[after.start..after.end].iter_mut().for_each(|t| *t -= jump_s);
            self.is_moved = true;
            // a step of the log's own clock has its own note
            let is_known = jump_s.abs() < LEAST_JUMP_S || set_back_s.iter().any(|back| (back + jump_s).abs() < LEAST_JUMP_S);
            if parts.len() <= 4 && !is_known {
                let way = if jump_s > 0.0 { "ahead" } else { "back" };
                self.faults.push(format!("their clock was set {way} by {:.3} s at {:.1} s: removed", jump_s.abs(), log_s[after.start]));
            }
        }
        if parts.len() > 4 {
            self.faults.push(format!("they jump {} times: removed", parts.len() - 1));
        }
        // the delay of a recorder that writes in bursts may grow, which looks like a drift of the stamps
        let scatters = Rhythm::of(time_s).is_some_and(|rhythm| rhythm.scatter_s > MOST_SCATTER_S);
        if !self.log_in_bursts && !scatters {
            self.remove_drift(time_s, log_s, &parts);
        }
        if lost > 0 {
            let usual_s = median_ahead(time_s, log_s, &parts);
            let mut kept = vec![false; count];
            for part in &parts {
                kept[part.clone()].fill(true);
            }
            for k in (0..count).filter(|k| !kept[*k]) {
                time_s[k] = log_s[k] + usual_s;
            }
            self.faults.push(format!("{lost} of {count} stand still, jump or are missing: the log's time is used there"));
        }
        true
    }

    /// Removes a drift against the clock of the log.
    fn remove_drift(&mut self, time_s: &mut [f64], log_s: &[f64], parts: &[std::ops::Range<usize>]) {
        let used: Vec<usize> = parts.iter().flat_map(Clone::clone).collect();
        let windows = WINDOWS.min(used.len() / FEWEST_OF_WINDOW);
        if windows < 6 {
            return;
        }
        let points: Vec<(f64, f64)> = used
            .chunks(used.len().div_ceil(windows))
            .filter(|chunk| chunk.len() >= FEWEST_OF_WINDOW)
            .map(|chunk| (log_s[chunk[chunk.len() / 2]], highest(chunk.iter().map(|k| time_s[*k] - log_s[*k]))))
            .collect();
        let mut slopes = Vec::new();
        for (k, a) in points.iter().enumerate() {
            slopes.extend(points[..k].iter().map(|b| (a.1 - b.1) / (a.0 - b.0)).filter(|s| s.is_finite()));
        }
        let (Some(slope), Some(first), Some(last)) = (middle(slopes), points.first(), points.last()) else { return };
        let span_s = last.0 - first.0;
        let level = middle(points.iter().map(|p| p.1 - slope * p.0).collect()).unwrap_or(0.0);
        let scatter = 1.4826 * middle(points.iter().map(|p| (p.1 - slope * p.0 - level).abs()).collect()).unwrap_or(0.0);
        let std_err = scatter * (12.0 / points.len() as f64).sqrt() / span_s;
        if (slope * span_s).abs() < LEAST_DRIFT_S || slope.abs() < SIGNIFICANT * std_err || slope.abs() > MOST_DRIFT {
            return;
        }
        let centre_s = 0.5 * (first.0 + last.0);
        time_s.iter_mut().zip(log_s).for_each(|(t, l)| *t -= slope * (l - centre_s));
        self.faults.push(format!("their clock drifts by {:.0} ppm against that of the log: removed", slope * 1e6));
    }
}

/// Whether each stamp is there and moves on.
fn sound(time_s: &[f64], log_s: &[f64]) -> Vec<bool> {
    let mut is_sound: Vec<bool> = time_s.iter().map(|t| t.is_finite()).collect();
    let mut first = 0;
    for k in 1..=time_s.len() {
        if k < time_s.len() && (time_s[k] - time_s[first]).abs() < 1e-9 {
            continue;
        }
        if log_s[k - 1] - log_s[first] > FROZEN_S {
            // the first of them may be the last true one
            is_sound[first + 1..k].fill(false);
        }
        first = k;
    }
    is_sound
}

/// The parts between jumps, without unusable stamps.
fn parts(time_s: &[f64], log_s: &[f64], is_sound: &[bool]) -> Vec<std::ops::Range<usize>> {
    let rhythm = Rhythm::of(time_s).filter(|r| r.period_s < LEAST_RARE_JUMP_S);
    let (period_s, width_s) = rhythm.map_or((0.0, LEAST_RARE_JUMP_S), |r| (r.period_s, LEAST_JUMP_S.max(8.0 * r.scatter_s)));
    let is_jump = |k: usize| {
        let (stamped_s, logged_s) = (time_s[k] - time_s[k - 1], log_s[k] - log_s[k - 1]);
        let is_usual = rhythm.is_some() && (stamped_s - period_s).abs() <= width_s;
        !is_usual && (stamped_s - logged_s).abs() > width_s
    };
    let mut found: Vec<std::ops::Range<usize>> = Vec::new();
    let mut from = None;
    for k in 0..=time_s.len() {
        let goes_on = k < time_s.len() && is_sound[k] && (from.is_none() || !is_jump(k));
        if goes_on {
            from.get_or_insert(k);
            continue;
        }
        if let Some(first) = from.take()
            && k - first >= SHORTEST_PART
        {
            found.push(first..k);
        }
        if k < time_s.len() && is_sound[k] {
            from = Some(k);
        }
    }
    found
}

fn median_ahead(time_s: &[f64], log_s: &[f64], parts: &[std::ops::Range<usize>]) -> f64 {
    middle(parts.iter().flat_map(Clone::clone).map(|k| time_s[k] - log_s[k]).collect()).unwrap_or(0.0)
}

/// The highest of the values; of many values, without the highest 2 %.
fn highest(values: impl Iterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.filter(|v| v.is_finite()).collect();
    if values.is_empty() {
        return 0.0;
    }
    let at = values.len() - 1 - values.len() / 50;
    *values.select_nth_unstable_by(at, f64::total_cmp).1
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::log::timing::message_times::MessageTimes;

    const SECOND: i64 = 1_000_000_000;

    /// The clock of messages every 20 ms that arrive 1 to 3 ms late, stamped by `stamp`; and the largest error of its times [s].
    fn clock(stamp: impl Fn(i64) -> i64) -> (StampClock, f64) {
        let sampled = |k: i64| k * SECOND / 50;
        let arrived = |k: i64| sampled(k) + SECOND / 1000 * (1 + k * 7919 % 101 / 50);
        let times: Vec<MessageTimes> =
            (1..4000).map(|k| MessageTimes { stamp_ns: stamp(sampled(k)), publish_ns: 0, log_ns: arrived(k) }).collect();
        let log_s: Vec<f64> = times.iter().map(|t| to_s(t.log_ns, 0)).collect();
        let clock = StampClock::of(&SignalTimes { signal: SignalName::Speed, times: &times }, &log_s, 0, &[]);
        let time_s = clock.time_s.as_ref().unwrap_or(&log_s);
        let apart = (1..4000).zip(time_s).map(|(k, t)| t - to_s(sampled(k), 0));
        let (low, high) = apart.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(x), b.max(x)));
        (clock, high - low)
    }

    #[test]
    fn sound_stamps_stay() {
        let (clock, error_s) = clock(|t| t);
        assert!(!clock.is_corrected() && error_s < 1e-9 && (clock.ahead_s + 0.001).abs() < 1e-6, "{clock:?}");
        let (clock, _) = self::clock(|t| t + 3600 * SECOND);
        assert!(!clock.is_corrected() && (clock.ahead_s - 3599.999).abs() < 1e-6);
    }

    #[test]
    fn a_clock_that_is_set_stands_still_or_drifts_is_corrected() {
        type Fault = (&'static str, fn(i64) -> i64);
        let faults: [Fault; 5] = [
            ("set ahead by 13.000 s", |t| if t > 40 * SECOND { t + 13 * SECOND } else { t }),
            ("set back by 0.400 s", |t| if t > 40 * SECOND { t - 2 * SECOND / 5 } else { t }),
            ("stand still", |t| if t > 30 * SECOND && t < 40 * SECOND { 30 * SECOND } else { t }),
            ("drifts by -800 ppm", |t| t - t * 8 / 10_000),
            ("jump", |t| if t % (4 * SECOND) < SECOND { t - SECOND } else { t }),
        ];
        for (words, fault) in faults {
            let (clock, error_s) = clock(fault);
            let note = clock.note(SignalName::Speed).unwrap();
            assert!(note.contains(words) && error_s < 0.004, "{words}: {note} {error_s}");
        }
    }

    #[test]
    fn stamps_in_whole_seconds_are_of_no_use() {
        let (clock, _) = clock(|t| t / SECOND * SECOND);
        assert!(clock.time_s.is_none() && clock.source == TimeSource::Log);
    }
}
