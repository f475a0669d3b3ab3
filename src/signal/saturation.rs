//! Saturation of a noisy signal: the same extreme value again and again.

/// Fewest readings at the extreme value.
const FEWEST: usize = 20;
/// Least ratio of their number to that at the next value: readings in coarse steps repeat every value.
const OVER_THE_NEXT: usize = 10;

/// The values at which a signal saturates, the lower and the upper one. A noisy signal reaches its extreme once; one in coarse steps has as
/// many readings at the step before. A signal of few values, such as a command, saturates nowhere.
pub(crate) fn saturation(values: &[f64]) -> [Option<f64>; 2] {
    let mut sorted: Vec<f64> = values.iter().copied().filter(|v| v.is_finite()).collect();
    sorted.sort_unstable_by(f64::total_cmp);
    let at_start = |sorted: &[f64]| -> Option<f64> {
        let extreme = *sorted.first()?;
        let equal = |value: f64, from: &[f64]| from.iter().take_while(|v| **v == value).count();
        let here = equal(extreme, sorted);
        let next = *sorted.get(here)?;
        (here >= FEWEST && here >= OVER_THE_NEXT * equal(next, &sorted[here..])).then_some(extreme)
    };
    let lower = at_start(&sorted);
    sorted.reverse();
    [lower, at_start(&sorted)]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn noise(k: usize) -> f64 {
        (k * 7919 % 1013) as f64 / 1013.0 - 0.5
    }

    #[test]
    fn a_noisy_signal_that_is_cut_saturates_and_one_in_steps_does_not() {
        let smooth = |k: usize| 40.0 * (k as f64 * 0.01).sin() + noise(k);
        let values = |of: &dyn Fn(usize) -> f64| (0..4000).map(of).collect::<Vec<_>>();
        assert_eq!(saturation(&values(&smooth)), [None, None]);
        assert_eq!(saturation(&values(&|k| smooth(k).min(37.0))), [None, Some(37.0)]);
        assert_eq!(saturation(&values(&|k| smooth(k).max(-38.0))), [Some(-38.0), None]);
        assert_eq!(saturation(&values(&|k| smooth(k).round())), [None, None]);
        assert_eq!(saturation(&[]), [None, None]);
    }
}
