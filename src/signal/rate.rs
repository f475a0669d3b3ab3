//! The rate at which a signal really brings news: a slow value repeated at a fast rate is found out.

use super::Series;

/// How often a signal is logged and how often it is new.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrueRate {
    /// Messages per second.
    pub logged_hz: f64,
    /// New values per second; equal to `logged_hz` where repetition is no more than chance and rest explain.
    pub true_hz: f64,
    /// How many messages repeat each value (1 = none).
    pub repeats: usize,
}

/// Rate of `series`, or `None` with fewer than ten samples.
///
/// Values count as repeated when runs of equal values in the changing part of the signal share one length k ≥ 2: of the runs shorter than
/// 20 samples that are not at the signal's resting level, at least 80 % last k or a multiple of k (± a lost message).
pub fn true_rate(series: &Series) -> Option<TrueRate> {
    if series.len() < 10 {
        return None;
    }
    let span = series.t_s[series.len() - 1] - series.t_s[0];
    let logged_hz = if span > 0.0 { (series.len() - 1) as f64 / span } else { 0.0 };
    let repeats = repeats(&series.value);
    Some(TrueRate { logged_hz, true_hz: logged_hz / repeats as f64, repeats })
}

fn repeats(values: &[f64]) -> usize {
    let mut lengths = Vec::new();
    let mut length = 1;
    for pair in values.windows(2) {
        if pair[0] == pair[1] {
            length += 1;
        } else {
            lengths.push(length);
            length = 1;
        }
    }
    lengths.retain(|l| *l < 20);
    if lengths.len() < 20 {
        return 1;
    }
    let mut sorted = lengths.clone();
    sorted.sort_unstable();
    let k: usize = sorted[sorted.len() / 2];
    if k < 2 {
        return 1;
    }
    // A run of news every k messages has length k, k − 1 or k + 1 where a message was lost or the clocks drift, and multiples where the
    // value did not change. Single-sample runs speak against repetition.
    let fitting = lengths.iter().filter(|l| (**l).abs_diff(((**l + k / 2) / k).max(1) * k) <= 1 && **l + 1 >= k).count();
    if fitting as f64 >= 0.8 * lengths.len() as f64 { k } else { 1 }
}

/// The samples of `series` that are new, given that each value is logged `repeats` times: the first of each run of equal values, and
/// within longer runs every `repeats`-th.
pub fn new_values_only(series: &Series, repeats: usize) -> Series {
    if repeats < 2 {
        return series.clone();
    }
    let mut kept = Series::default();
    let mut since = 0;
    for i in 0..series.len() {
        if i == 0 || series.value[i] != series.value[i - 1] || since + 1 >= repeats {
            kept.t_s.push(series.t_s[i]);
            kept.value.push(series.value[i]);
            since = 0;
        } else {
            since += 1;
        }
    }
    kept
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn held(hold: usize) -> Series {
        let n = 600;
        Series { t_s: (0..n).map(|k| k as f64 * 0.01).collect(), value: (0..n).map(|k| ((k / hold) as f64 * 0.7).sin()).collect() }
    }

    #[test]
    fn a_ten_hertz_value_logged_at_a_hundred_is_found_out() {
        let rate = true_rate(&held(10)).unwrap();
        assert_eq!(rate.repeats, 10);
        assert!((rate.true_hz - 10.0).abs() < 0.1);
        assert_eq!(new_values_only(&held(10), 10).len(), 60);
    }

    #[test]
    fn a_signal_that_is_new_each_time_keeps_its_rate() {
        assert_eq!(true_rate(&held(1)).unwrap().repeats, 1);
    }
}
