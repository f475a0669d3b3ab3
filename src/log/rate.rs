//! The true rate of a signal: a slow value that is repeated in a fast message is found out.

use super::recording::Signal;
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
}

/// Changes that are needed before their spacing says anything.
const ENOUGH_CHANGES: usize = 20;

/// Messages that may hold the same value before it counts as constant rather than repeated.
const MOST_REPEATS: i64 = 20;

/// The rate of `signal`; `None` with fewer than two values or without any time between them.
///
/// While a value that is measured anew with each message moves, it changes with most messages. If even the closest tenth of the changes
/// are two or more messages apart, the value behind them is slower than the messages.
pub fn rate(signal: &Signal) -> Option<Rate> {
    let spacing = quantile(&mut signal.time_ns.windows(2).map(|pair| pair[1] - pair[0]).collect::<Vec<_>>(), 2)?;
    let logged_hz = (spacing > 0).then(|| NS_PER_S / spacing as f64)?;
    let changes: Vec<usize> =
        signal.value.windows(2).enumerate().filter(|(_, pair)| pair[0] != pair[1]).map(|(index, _)| index + 1).collect();
    if changes.len() < ENOUGH_CHANGES {
        return Some(Rate { logged_hz, true_hz: logged_hz });
    }
    let mut steps: Vec<i64> = changes.windows(2).map(|pair| (pair[1] - pair[0]) as i64).collect();
    let closest = quantile(&mut steps, 10)?;
    let all = steps.len();
    // a rate that is no whole fraction shows up in the mean over the moving part, where changes follow each other closely
    let close: Vec<i64> = steps.into_iter().filter(|step| *step <= closest + closest.div_euclid(2) + 1).collect();
    let mean = close.iter().sum::<i64>() as f64 / close.len().max(1) as f64;
    // a command that is held, with changes far apart or at any distance, is not repeated but constant
    let is_regular = close.len() * 2 >= all && closest <= MOST_REPEATS;
    Some(Rate { logged_hz, true_hz: if closest >= 2 && is_regular { logged_hz / mean } else { logged_hz } })
}

/// The value that one in `part` lies below or at.
fn quantile(values: &mut [i64], part: usize) -> Option<i64> {
    let place = values.len() / part;
    (!values.is_empty()).then(|| *values.select_nth_unstable(place.min(values.len() - 1)).1)
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
        assert!((found.logged_hz - 100.0).abs() < 1e-6 && (found.true_hz - 20.0).abs() < 0.5, "{found:?}");
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
