//! Brings the stamps of all signals onto one clock.
//!
//! A message arrives some milliseconds after it was stamped. A stamp that is later than the arrival, or long before the earliest arrival, is
//! of another clock. Such signals are moved so that their earliest messages arrive without delay; those that share a clock are moved together.

use crate::log::signal_map::SignalName;
use crate::log::timing::message_times::{SignalTimes, TimeSource};
use crate::log::timing::stamp_clock::StampClock;

/// The earliest arrivals may be stamped this much ahead of the log's time [s]: rounding.
const MOST_AHEAD_S: f64 = 0.005;
/// Longest delay of the earliest arrivals [s], of signals from a vehicle's bus and of those that are computed.
const LONGEST_DELAY_S: f64 = 0.08;
const LONGEST_COMPUTED_DELAY_S: f64 = 0.3;
/// Offsets within this are of one clock [s].
const ONE_CLOCK_S: f64 = 0.05;
/// A common offset from the log's time that is worth a note [s].
const LARGE_S: f64 = 1.0;

/// What to add to the times of each signal [s].
pub(crate) fn one_clock(signals: &[SignalTimes<'_>], clocks: &[StampClock], notes: &mut Vec<String>) -> Vec<f64> {
    let mut shifts_s = vec![0.0; clocks.len()];
    // a recorder that writes in bursts delays every message
    let bursts = clocks.iter().any(|c| c.log_in_bursts);
    let is_of_the_log = |k: usize| is_of_the_log(signals[k].signal, &clocks[k], bursts);
    let near = |k: usize| {
        (0..clocks.len()).any(|other| {
            let (a, b) = (&clocks[k], &clocks[other]);
            a.source == b.source && is_of_the_log(other) && (a.ahead_s - b.ahead_s).abs() < ONE_CLOCK_S
        })
    };
    let mut others: Vec<usize> = (0..clocks.len()).filter(|&k| !is_of_the_log(k) && !near(k)).collect();
    others.sort_by(|a, b| clocks[*a].ahead_s.total_cmp(&clocks[*b].ahead_s));
    let Some((lowest, highest)) = others.first().zip(others.last()).map(|(a, b)| (clocks[*a].ahead_s, clocks[*b].ahead_s)) else {
        return shifts_s;
    };
    let is_whole = others.len() == clocks.len() && clocks.iter().all(|c| c.source == TimeSource::Stamp);
    if is_whole && highest - lowest < ONE_CLOCK_S {
        if highest.abs() > LARGE_S {
            notes.push(format!(
                "the stamps of all signals differ from the log's time by {highest:.1} s: they share one clock and are not changed"
            ));
        }
        return shifts_s;
    }
    for group in others.chunk_by(|a, b| clocks[*b].ahead_s - clocks[*a].ahead_s < ONE_CLOCK_S) {
        let ahead_s = group.iter().map(|k| clocks[*k].ahead_s).fold(f64::NEG_INFINITY, f64::max);
        for k in group {
            shifts_s[*k] = -ahead_s;
        }
        let names: Vec<&str> = group.iter().map(|k| signals[*k].signal.key()).collect();
        let sources: Vec<&str> = [TimeSource::Stamp, TimeSource::Publish]
            .into_iter()
            .filter(|source| group.iter().any(|k| clocks[*k].source == *source))
            .map(TimeSource::name)
            .collect();
        let way = if ahead_s > 0.0 { "ahead of" } else { "behind" };
        notes.push(format!(
            "the {} of {} are on another clock, {:.3} s {way} the log's time: they are moved by {:+.3} s",
            sources.join(" and "),
            names.join(", "),
            ahead_s.abs(),
            -ahead_s
        ));
    }
    shifts_s
}

/// Whether the delay of the earliest arrivals is one.
fn is_of_the_log(signal: SignalName, clock: &StampClock, bursts: bool) -> bool {
    let longest_s = if SignalName::ALL.contains(&signal) && !bursts { LONGEST_DELAY_S } else { LONGEST_COMPUTED_DELAY_S };
    clock.source == TimeSource::Log || (-longest_s..=MOST_AHEAD_S).contains(&clock.ahead_s)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::log::timing::message_times::MessageTimes;

    fn shifts(signals: &[(SignalName, i64)]) -> (Vec<f64>, Vec<String>) {
        let times: Vec<Vec<MessageTimes>> = signals
            .iter()
            .map(|(_, ahead_ms)| {
                let at = |k: i64, later_ms: i64| (1000 + 20 * k + later_ms) * 1_000_000;
                let stamp = |k: i64| if *ahead_ms == 0 { 0 } else { at(k, *ahead_ms) };
                (0..200).map(|k| MessageTimes { stamp_ns: stamp(k), publish_ns: 0, log_ns: at(k, 0) }).collect()
            })
            .collect();
        let of: Vec<SignalTimes> = signals.iter().zip(&times).map(|((signal, _), times)| SignalTimes { signal: *signal, times }).collect();
        let log_s = |times: &[MessageTimes]| times.iter().map(|t| t.log_ns as f64 * 1e-9).collect::<Vec<_>>();
        let clocks: Vec<StampClock> = of.iter().map(|s| StampClock::of(s, &log_s(s.times), 0, &[])).collect();
        let mut notes = Vec::new();
        (one_clock(&of, &clocks, &mut notes), notes)
    }

    #[test]
    fn stamps_of_another_clock_are_moved_together_and_delays_are_not() {
        use SignalName::{Angle, Speed, Torque, YawRate};
        assert_eq!(shifts(&[(Speed, -3), (YawRate, -30), (Torque, 0)]).0, [0.0; 3]);
        let (shifts_s, notes) = shifts(&[(Speed, 1998), (YawRate, 2000), (Torque, 0)]);
        assert!((shifts_s[0] + 2.0).abs() < 1e-6 && (shifts_s[1] + 2.0).abs() < 1e-6 && shifts_s[2] == 0.0);
        assert!(notes.len() == 1 && notes[0].contains("2.000 s ahead"), "{notes:?}");
        // if all of them share one clock, nothing is moved
        assert_eq!(shifts(&[(Speed, -60_000), (YawRate, -60_001), (Torque, -60_002), (Angle, -60_000)]).0, [0.0; 4]);
        let (shifts_s, notes) = shifts(&[(Speed, -2), (YawRate, 3_600_000), (Torque, 0)]);
        assert!(shifts_s[0] == 0.0 && (shifts_s[1] + 3600.0).abs() < 1e-6 && notes.len() == 1);
    }
}
