//! What a message of a signal means: one reading of many, or a value that holds until the next message.
//!
//! Found from the messages themselves. A periodic signal repeats its value or measures a new one in every period. A signal that is logged on
//! change has long, irregular intervals, and nearly every message brings a new value. With a heartbeat, the same value is repeated after a
//! fixed time, and changes come in between. A latched signal has one message.

use crate::log::timing::rhythm::middle;
use std::fmt;

/// How a signal was logged.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum MessageKind {
    /// A message per period.
    Periodic,
    /// A message per period, more than 2 % of them lost.
    PeriodicWithLosses,
    /// A message where the value changes.
    OnChange,
    /// A message where the value changes, and after a fixed time without a change.
    OnChangeWithHeartbeat,
    /// One message for the whole log.
    Once,
}

/// A median interval above this is too long for a periodic command whose value changes in every message [s].
const LONG_S: f64 = 0.15;
/// Share of equal neighbours below which nearly every message brings a new value.
const FEW_REPEATS: f64 = 0.05;
/// Share of the log's time in long intervals above which the log mostly waits for a change.
const MOSTLY_WAITING: f64 = 0.5;
/// Number of long intervals that may be pauses of the recording.
const PAUSES: usize = 2;
/// An interval is regular within this share of the median interval.
const REGULAR: f64 = 0.25;
/// Share of regular intervals of a slow sensor, and its longest period [s].
const MOSTLY_REGULAR: f64 = 0.8;
const LONGEST_PERIOD_S: f64 = 1.0;
/// An interval is a heartbeat's within this share of it.
const BEAT: f64 = 0.1;
/// Share of regular intervals before repeated values for a heartbeat.
const HEARTBEAT: f64 = 0.6;
/// A shorter interval is a period [s].
const SHORTEST_HEARTBEAT_S: f64 = 0.06;
/// Fewest changes that distinguish a heartbeat from a period.
const FEWEST_CHANGES: usize = 3;
/// Share of lost messages that is mentioned.
const LOSSES: f64 = 0.02;

impl MessageKind {
    /// The kind of a signal, from the times [s] and values of its messages, in order of time.
    pub fn of(time_s: &[f64], values: &[f64]) -> Self {
        if time_s.len() < 2 {
            return Self::Once;
        }
        let intervals: Vec<f64> = time_s.windows(2).map(|t| t[1] - t[0]).collect();
        let Some(period_s) = middle(intervals.iter().copied().filter(|d| *d > 0.0).collect()) else { return Self::Periodic };
        let repeated: Vec<bool> = values.windows(2).map(|v| v[0] == v[1]).collect();
        let repeats = repeated.iter().filter(|r| **r).count();
        let share = |count: usize| count as f64 / intervals.len() as f64;
        let span_s: f64 = intervals.iter().sum();
        let mut long: Vec<f64> = intervals.iter().copied().filter(|d| *d > (4.0 * period_s).max(LONG_S)).collect();
        long.sort_unstable_by(f64::total_cmp);
        // a pause of the recording is not a property of the signal
        let pauses_s: f64 = long.iter().rev().take(PAUSES).sum();
        let waiting_s = long.iter().sum::<f64>() - pauses_s;
        let near = intervals.iter().filter(|d| (**d - period_s).abs() <= REGULAR * period_s).count();
        let is_measured = period_s < LONGEST_PERIOD_S && share(near) > MOSTLY_REGULAR && is_varied(values);
        if !is_measured && share(repeats) < FEW_REPEATS && (period_s > LONG_S || waiting_s > MOSTLY_WAITING * (span_s - pauses_s)) {
            return Self::OnChange;
        }
        let regular_where = |wanted: bool| {
            let chosen: Vec<f64> = intervals.iter().zip(&repeated).filter(|(_, r)| **r == wanted).map(|(d, _)| *d).collect();
            let regular = chosen.iter().filter(|d| (**d - period_s).abs() <= BEAT * period_s).count();
            regular as f64 / chosen.len().max(1) as f64
        };
        let changes = intervals.len() - repeats;
        let by_heartbeat = regular_where(true);
        if period_s > SHORTEST_HEARTBEAT_S
            && changes >= FEWEST_CHANGES
            && by_heartbeat >= HEARTBEAT
            && regular_where(false) < HEARTBEAT * by_heartbeat
        {
            return Self::OnChangeWithHeartbeat;
        }
        let lost: f64 = intervals.iter().map(|d| ((d / period_s).round() - 1.0).max(0.0)).sum();
        if lost > LOSSES * (lost + intervals.len() as f64) { Self::PeriodicWithLosses } else { Self::Periodic }
    }

    /// Whether a value holds until the next message, so that any time between them is known.
    pub fn is_held(self) -> bool {
        matches!(self, Self::OnChange | Self::OnChangeWithHeartbeat | Self::Once)
    }
}

/// Whether most values occur once: those of a sensor, not the levels of a command.
fn is_varied(values: &[f64]) -> bool {
    let mut sorted = values.to_vec();
    sorted.sort_unstable_by(f64::total_cmp);
    sorted.dedup();
    2 * sorted.len() > values.len()
}

impl fmt::Display for MessageKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Periodic => "periodic",
            Self::PeriodicWithLosses => "periodic, with losses",
            Self::OnChange => "on change",
            Self::OnChangeWithHeartbeat => "on change, with a heartbeat",
            Self::Once => "once",
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn steps(t: f64) -> f64 {
        [0.0, 12.0, 0.0, -8.0, 20.0][(t / 2.9).floor() as usize % 5]
    }

    /// Messages of a stepped command at the times for which `keep` holds, given whether the value is new and the time since the last one.
    fn logged(rate_hz: f64, keep: impl Fn(bool, f64) -> bool) -> MessageKind {
        let (mut t_s, mut values): (Vec<f64>, Vec<f64>) = (Vec::new(), Vec::new());
        for k in 0..(120.0 * rate_hz) as usize {
            let t = k as f64 / rate_hz + 0.002 * ((k * 7919 % 101) as f64 / 50.0 - 1.0);
            let new = values.last() != Some(&steps(t));
            if keep(new, t - t_s.last().copied().unwrap_or(-1e9)) {
                t_s.push(t);
                values.push(steps(t));
            }
        }
        MessageKind::of(&t_s, &values)
    }

    #[test]
    fn each_habit_is_recognised_by_its_messages() {
        assert_eq!(logged(50.0, |_, _| true), MessageKind::Periodic);
        assert_eq!(logged(10.0, |_, _| true), MessageKind::Periodic);
        assert_eq!(logged(50.0, |new, _| new), MessageKind::OnChange);
        assert_eq!(logged(50.0, |new, since| new || since > 0.5), MessageKind::OnChangeWithHeartbeat);
        assert_eq!(logged(50.0, |new, since| new || since > 1.0), MessageKind::OnChangeWithHeartbeat);
        assert_eq!(logged(50.0, |_, since| since > 1e6), MessageKind::Once);
        let lost = std::cell::Cell::new(0u32);
        let every_tenth = |_: bool, _: f64| {
            lost.set(lost.get() + 1);
            !lost.get().is_multiple_of(10)
        };
        assert_eq!(logged(50.0, every_tenth), MessageKind::PeriodicWithLosses);
        let t_s: Vec<f64> = (0..3000).map(|k| f64::from(k) * 0.02).collect();
        let values: Vec<f64> = t_s.iter().map(|t| (3.0 * t).sin()).collect();
        assert_eq!(MessageKind::of(&t_s, &values), MessageKind::Periodic);
        // a sensor at 5 Hz
        let slow_s: Vec<f64> = t_s.iter().map(|t| 10.0 * t).collect();
        assert_eq!(MessageKind::of(&slow_s, &values), MessageKind::Periodic);
    }
}
