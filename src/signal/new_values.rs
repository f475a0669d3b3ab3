//! Removes values that are repeated at a fast rate.

use crate::signal::Series;

/// The new samples of `series`, if each value is logged `repeats` times: the first of each run of equal values, and every `repeats`-th in
/// longer runs.
pub(crate) fn new_values_only(series: &Series, repeats: usize) -> Series {
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
    use super::*;

    #[test]
    fn only_the_first_message_of_each_value_is_kept() {
        let n: usize = 600;
        let held =
            Series { t_s: (0..n).map(|k| k as f64 * 0.01).collect(), value: (0..n).map(|k| ((k / 10) as f64 * 0.7).sin()).collect() };
        let kept = new_values_only(&held, 10);
        assert_eq!(kept.len(), 60);
        assert!(kept.t_s.iter().enumerate().all(|(k, t_s)| (t_s - k as f64 * 0.1).abs() < 1e-9));
        assert_eq!(new_values_only(&held, 1), held);
    }
}
