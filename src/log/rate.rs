//! The true rate of a signal: detects a slow value that is repeated in a fast message.

use crate::log::recording::Signal;
use crate::units::NS_PER_S;
use serde::Serialize;

/// The logging rate of a signal, and the rate of new values.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Rate {
    /// Values per second, from the median spacing.
    pub logged_hz: f64,
    /// New values per second: less than `logged_hz` if each value is repeated. Equal to it if the value hardly changes, because the true
    /// rate is then unknown.
    pub true_hz: f64,
    /// Number of messages per value: 1 if none is repeated.
    pub repeats: usize,
}

/// Smallest number of runs of equal values for an estimate from their lengths.
const ENOUGH_RUNS: usize = 20;
/// Largest number of messages with the same value before it counts as constant instead of repeated.
const MOST_REPEATS: usize = 20;

/// The rate of `signal`; `None` with fewer than two values or without any time between them.
///
/// A moving value that is measured for each message changes with each message. It is repeated if runs of equal values have a common length
/// k ≥ 2: at least 80 % of the runs of up to 20 messages have the length k, or a multiple of k where two values were equal (± a lost
/// message). If more than 20 % of the runs are longer than that, it is a held command with steps of any length.
pub(crate) fn rate(signal: &Signal) -> Option<Rate> {
    let mut spacing: Vec<i64> = signal.time_ns.windows(2).map(|pair| pair[1].saturating_sub(pair[0])).collect();
    let middle = spacing.len() / 2;
    let median = (!spacing.is_empty()).then(|| *spacing.select_nth_unstable(middle).1).filter(|median| *median > 0)?;
    let logged_hz = NS_PER_S / median as f64;
    Some(repeated(&signal.value).map_or(Rate { logged_hz, true_hz: logged_hz, repeats: 1 }, |(repeats, each)| Rate {
        logged_hz,
        true_hz: logged_hz / each,
        repeats,
    }))
}

/// Number of messages per value, as an integer and as the mean; `None` if no value is repeated.
fn repeated(values: &[f64]) -> Option<(usize, f64)> {
    let mut runs: Vec<usize> = values.chunk_by(|a, b| a == b).map(<[f64]>::len).collect();
    runs.pop(); // the end of the log cuts the last one
    let all = runs.len();
    runs.retain(|length| *length < MOST_REPEATS);
    if runs.len() < ENOUGH_RUNS || runs.len() * 5 < all * 4 {
        return None;
    }
    let middle = runs.len() / 2;
    let k = *runs.select_nth_unstable(middle).1;
    // runs of k, 2k, … messages, with their number of values; runs of a single message are evidence against repetition
    let values_in = |length: usize| ((length + k / 2) / k).max(1);
    let fits = |length: &&usize| length.abs_diff(values_in(**length) * k) <= 1 && **length + 1 >= k;
    let fitting: Vec<usize> = runs.iter().filter(fits).copied().collect();
    if k < 2 || fitting.len() * 5 < runs.len() * 4 {
        return None;
    }
    // the mean shows a rate that is not an integer fraction
    let held: usize = fitting.iter().sum();
    let values: usize = fitting.iter().map(|length| values_in(*length)).sum();
    Some((k, held as f64 / values as f64))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn logged(value: impl Fn(usize) -> f64) -> Signal {
        let time_ns = (0..1000).map(|i| i64::from(i) * 10_000_000).collect();
        Signal { time_ns, value: (0..1000).map(value).collect(), ..Signal::default() }
    }

    #[test]
    fn a_slow_value_repeated_at_a_fast_rate_is_detected() {
        let found = rate(&logged(|i| ((i / 5) as f64 * 0.3).sin())).unwrap();
        assert!((found.logged_hz - 100.0).abs() < 1e-6 && (found.true_hz - 20.0).abs() < 0.1, "{found:?}");
        assert_eq!(found.repeats, 5);
    }

    #[test]
    fn a_slow_value_whose_rate_is_not_an_integer_fraction_is_detected() {
        let found = rate(&logged(|i| ((i * 2 / 5) as f64 * 0.3).sin())).unwrap();
        assert!((found.true_hz - 40.0).abs() < 0.5 && (2..=3).contains(&found.repeats), "{found:?}");
    }

    #[test]
    fn a_fast_value_that_is_sometimes_constant_keeps_its_rate() {
        let found = rate(&logged(|i| if i % 200 < 100 { 0.0 } else { (i as f64 * 0.37).sin() })).unwrap();
        assert!((found.true_hz - 100.0).abs() < 1e-6, "{found:?}");
    }

    #[test]
    fn a_command_in_steps_is_not_reported_as_repeated() {
        let step = |i: usize| if i % 35 < 12 { 1.0 } else { (i / 35) as f64 };
        let found = rate(&logged(step)).unwrap();
        assert!((found.true_hz - 100.0).abs() < 1e-6, "{found:?}");
    }

    #[test]
    fn a_value_that_hardly_changes_gives_no_rate() {
        assert_eq!(rate(&logged(|i| (i / 300) as f64)).unwrap().true_hz, 100.0);
        assert_eq!(rate(&Signal::default()), None);
    }
}
