//! The gates that need no model: each looks at one signal and marks intervals.

use crate::campaign::SurveySettings;
use crate::signal::{Series, median_of_few};
use crate::units::RAD_PER_DEG;

/// Closed intervals of time [s], ordered and apart.
pub(crate) type Intervals = Vec<(f64, f64)>;

/// Whether `t_s` lies in one of `intervals`.
pub(crate) fn within(intervals: &[(f64, f64)], t_s: f64) -> bool {
    let k = intervals.partition_point(|(from, _)| *from <= t_s);
    k > 0 && t_s <= intervals[k - 1].1
}

/// Intervals in which `marked` holds at the samples of `series`, each reaching half a step beyond its samples and `margin_s` more, joined
/// where they overlap.
fn intervals(series: &Series, margin_s: f64, marked: impl Fn(usize) -> bool) -> Intervals {
    let reach = margin_s + 0.5 * series.median_period_s().min(1.0);
    let mut found: Intervals = Vec::new();
    for i in (0..series.len()).filter(|&i| marked(i)) {
        let (from, to) = (series.t_s[i] - reach, series.t_s[i] + reach);
        match found.last_mut() {
            Some(last) if from <= last.1 => last.1 = last.1.max(to),
            _ => found.push((from, to)),
        }
    }
    found
}

/// The wheel angle over time, its spikes removed (median of five).
pub(crate) fn clean_angle(angle_rad: &Series) -> Series {
    let n = angle_rad.len();
    let mut around = [0.0; 5];
    let value = (0..n)
        .map(|i| {
            let window = &angle_rad.value[i.saturating_sub(2)..(i + 3).min(n)];
            let around = &mut around[..window.len()];
            around.copy_from_slice(window);
            median_of_few(around)
        })
        .collect();
    Series { t_s: angle_rad.t_s.clone(), value }
}

/// Where the wheel is away from the test angle.
pub(crate) fn off_angle(angle_rad: &Series, test_angle_deg: f64, settings: &SurveySettings) -> Intervals {
    intervals(angle_rad, 0.02, |i| (angle_rad.value[i] / RAD_PER_DEG - test_angle_deg).abs() > settings.angle_tolerance_deg)
}

/// Where the steering moves.
pub(crate) fn steering(angle_rad: &Series, settings: &SurveySettings) -> Intervals {
    let rates = angle_rad.slopes(0.1);
    intervals(angle_rad, 0.05, |i| rates[i].abs() / RAD_PER_DEG > settings.steering_rate_deg_s)
}

/// Where an emergency stop is on: from the last message that says it is off to the first that says so again.
pub(crate) fn emergency_stops(estop: &Series) -> Intervals {
    let mut found: Intervals = Vec::new();
    let mut on = false;
    for i in 0..estop.len() {
        let active = estop.value[i] != 0.0;
        if active && !on {
            found.push((if i > 0 { estop.t_s[i - 1] } else { f64::NEG_INFINITY }, f64::INFINITY));
        } else if !active
            && on
            && let Some(last) = found.last_mut()
        {
            last.1 = estop.t_s[i];
        }
        on = active;
    }
    found
}

/// Where the torque command is unknown: gaps with different commands on both sides, and the time that the drive needs to settle after.
pub(crate) fn command_gaps(command: &Series, settings: &SurveySettings) -> Intervals {
    let longest = settings.command_gap_s.max(4.0 * command.median_period_s().min(1.0));
    let settle_s = 0.4;
    let mut found: Intervals = Vec::new();
    for i in 1..command.len() {
        if command.t_s[i] - command.t_s[i - 1] > longest && command.value[i] != command.value[i - 1] {
            found.push((command.t_s[i - 1], command.t_s[i] + settle_s));
        }
    }
    // beyond the command's ends nothing is known
    if let (Some(first), Some(last)) = (command.t_s.first(), command.t_s.last()) {
        found.insert(0, (f64::NEG_INFINITY, *first));
        found.push((last + longest, f64::INFINITY));
    }
    found
}

/// Samples that their neighbours do not share: Hampel's rule over ±3 samples, with a floor so that a quantum is no outlier.
pub(crate) fn outliers(series: &Series, mads: f64) -> Vec<bool> {
    let floor = crate::signal::noise_std(&series.value).max(crate::signal::quantum(&series.value)).max(1e-6);
    crate::signal::hampel(&series.value, mads, floor)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn series(values: &[f64]) -> Series {
        Series { t_s: (0..values.len()).map(|k| k as f64 * 0.1).collect(), value: values.to_vec() }
    }

    #[test]
    fn an_emergency_stop_reaches_back_to_the_last_message_that_says_off() {
        let stops = emergency_stops(&series(&[0.0, 0.0, 1.0, 1.0, 0.0]));
        assert_eq!(stops.len(), 1);
        assert!(within(&stops, 0.15) && within(&stops, 0.35) && !within(&stops, 0.05));
    }

    #[test]
    fn a_gap_between_equal_commands_is_known_and_one_between_different_ones_is_not() {
        let command = Series { t_s: vec![0.0, 0.02, 0.5, 0.52, 1.0, 1.02], value: vec![4.0, 4.0, 4.0, 4.0, 8.0, 8.0] };
        let gaps = command_gaps(&command, &SurveySettings::default());
        assert!(!within(&gaps, 0.3) && within(&gaps, 0.8));
    }

    #[test]
    fn one_spike_is_an_outlier_and_a_step_is_not() {
        let spike = outliers(&series(&[0.0, 0.0, 0.0, 0.0, 9.0, 0.0, 0.0, 0.0, 0.0]), 6.0);
        assert_eq!(spike.iter().filter(|o| **o).count(), 1);
        let step = outliers(&series(&[0.0, 0.0, 0.0, 0.0, 0.0, 9.0, 9.0, 9.0, 9.0, 9.0]), 6.0);
        assert!(step.iter().all(|o| !o));
    }
}
