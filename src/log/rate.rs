//! The true rate of a signal: a slow value that is repeated in a fast message is found out.

use crate::log::recording::Signal;
use crate::units::NS_PER_S;
use serde::Serialize;

/// How often a signal is logged, and how often it really changes.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Rate {
    /// Values per second, from the median spacing.
    pub logged_hz: f64,
    /// New values per second: less than `logged_hz` when each value is repeated. Equal to it when the value hardly changes, because
    /// then nothing can be told.
    pub true_hz: f64,
    /// How many messages hold each value: 1 when none is repeated.
    pub repeats: usize,
}

/// Runs of equal values that are needed before their lengths say anything.
const ENOUGH_RUNS: usize = 20;
/// Messages that may hold the same value before it counts as constant rather than repeated.
const MOST_REPEATS: usize = 20;

/// The rate of `signal`; `None` with fewer than two values or without any time between them.
///
/// While a value that is measured anew with each message moves, it changes with each message. It is repeated when runs of equal values
/// share a length k ≥ 2: at least 80 % of those of up to 20 messages last k, or a multiple of it where two values were equal (± a lost
/// message). If more than 20 % of the runs are longer than that, it is a command that is held, in steps of any length.
pub fn rate(signal: &Signal) -> Option<Rate> {
    let mut spacing: Vec<i64> = signal.time_ns.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let middle = spacing.len() / 2;
    let median = (!spacing.is_empty()).then(|| *spacing.select_nth_unstable(middle).1).filter(|median| *median > 0)?;
    let logged_hz = NS_PER_S / median as f64;
    Some(repeated(&signal.value).map_or(Rate { logged_hz, true_hz: logged_hz, repeats: 1 }, |(repeats, each)| Rate {
        logged_hz,
        true_hz: logged_hz / each,
        repeats,
    }))
}

/// How many messages hold each value, as a whole number and in the mean; `None` when no value is repeated.
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
    // runs that last k, 2k, … messages, with how many values they hold; runs of a single message speak against repetition
    let values_in = |length: usize| ((length + k / 2) / k).max(1);
    let fits = |length: &&usize| length.abs_diff(values_in(**length) * k) <= 1 && **length + 1 >= k;
    let fitting: Vec<usize> = runs.iter().filter(fits).copied().collect();
    if k < 2 || fitting.len() * 5 < runs.len() * 4 {
        return None;
    }
    // a rate that is no whole fraction shows up in the mean
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
    fn a_slow_value_repeated_at_a_fast_rate_is_found_out() {
        let found = rate(&logged(|i| ((i / 5) as f64 * 0.3).sin())).unwrap();
        assert!((found.logged_hz - 100.0).abs() < 1e-6 && (found.true_hz - 20.0).abs() < 0.1, "{found:?}");
        assert_eq!(found.repeats, 5);
    }

    #[test]
    fn a_slow_value_whose_rate_is_no_whole_fraction_is_found_out() {
        let found = rate(&logged(|i| ((i * 2 / 5) as f64 * 0.3).sin())).unwrap();
        assert!((found.true_hz - 40.0).abs() < 0.5 && (2..=3).contains(&found.repeats), "{found:?}");
    }

    #[test]
    fn a_fast_value_that_sometimes_rests_keeps_its_rate() {
        let found = rate(&logged(|i| if i % 200 < 100 { 0.0 } else { (i as f64 * 0.37).sin() })).unwrap();
        assert!((found.true_hz - 100.0).abs() < 1e-6, "{found:?}");
    }

    #[test]
    fn a_command_in_steps_is_not_called_repeated() {
        let step = |i: usize| if i % 35 < 12 { 1.0 } else { (i / 35) as f64 };
        let found = rate(&logged(step)).unwrap();
        assert!((found.true_hz - 100.0).abs() < 1e-6, "{found:?}");
    }

    #[test]
    fn a_value_that_hardly_changes_says_nothing() {
        assert_eq!(rate(&logged(|i| (i / 300) as f64)).unwrap().true_hz, 100.0);
        assert_eq!(rate(&Signal::default()), None);
    }
}
