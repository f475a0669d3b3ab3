//! Dead times, lag and clock offsets of the drive, each with its status.

use crate::campaign::Survey;
use crate::fit::FitSettings;
use crate::fit::drive::torque_input::TorqueChoice;
use crate::fit::rounds::estimate::Estimate;
use crate::fit::table1::runs::round;
use crate::map::{Actuator, DelayEstimate, DelayStatus, LogActuator};

/// Least offset between the clocks of command and speed that counts [s]: smaller ones are sampling phases.
const CLOCK_OFFSET_S: f64 = 0.02;
/// A delay with a larger standard error is weakly determined [s].
const WEAK_S: f64 = 0.01;

/// Delays as estimated, one dead time per log.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Delays {
    pub(crate) dead_time_s: Vec<f64>,
    pub(crate) dead_time_std_err_s: Vec<f64>,
    pub(crate) lag_s: f64,
    pub(crate) lag_std_err_s: f64,
}

impl From<&Estimate<'_>> for Delays {
    fn from(estimate: &Estimate<'_>) -> Self {
        Self {
            dead_time_s: estimate.calibration.dead_time_s.clone(),
            dead_time_std_err_s: estimate.calibration_errors.dead_time_s.clone(),
            lag_s: estimate.calibration.lag_s,
            lag_std_err_s: estimate.calibration_errors.lag_s,
        }
    }
}

/// Dead times, lag and clock offsets, each with its status; one survey per log.
///
/// If the feedback was the input, the estimated delays are those from feedback to speed. A controller needs those from the command: the
/// feedback's own dead time is added, and its lag replaces the missing one.
pub(crate) fn actuator(found: &Delays, surveys: &[&Survey], choice: &TorqueChoice, settings: &FitSettings) -> Actuator {
    let status = |given: bool, std_err_s: f64| {
        if given {
            DelayStatus::Given
        } else if std_err_s > WEAK_S {
            DelayStatus::WeaklyDetermined
        } else {
            DelayStatus::Estimated
        }
    };
    let estimate = |value_s: f64, std_err_s: f64, given: bool| DelayEstimate {
        value_s: round(value_s, 1e6),
        std_err_s: (!given).then(|| round(std_err_s, 1e6)),
        status: status(given, std_err_s),
    };
    let given = settings.dead_time_s.is_some();
    let mut std_errs_s = Vec::new();
    let per_log: Vec<LogActuator> = surveys
        .iter()
        .enumerate()
        .map(|(k, survey)| {
            let own = (found.dead_time_s[k], found.dead_time_std_err_s[k]);
            let feedback = choice.delays(&survey.track.source);
            // dead time from command to speed, and its part after the feedback
            let ((total, std_err), offset) = match feedback {
                Some(f) if choice.is_feedback() => ((f.dead_time_s + own.0, own.1.hypot(f.misfit() * f.dead_time_std_err_s)), Some(own)),
                Some(f) => (own, Some((own.0 - f.dead_time_s, (own.1 * own.1 + f.dead_time_std_err_s * f.dead_time_std_err_s).sqrt()))),
                None => (own, None),
            };
            std_errs_s.push(std_err);
            let (clock_offset, dead_time) = match (offset, feedback) {
                (Some((offset, error)), Some(f)) => {
                    let real = offset.abs() > CLOCK_OFFSET_S.max(4.0 * error);
                    let offset = DelayEstimate {
                        value_s: round(offset, 1e6),
                        std_err_s: Some(round(error, 1e6)),
                        status: if real { DelayStatus::Estimated } else { DelayStatus::NoneFound },
                    };
                    (offset, if real { f.dead_time_s } else { total })
                }
                _ => (DelayEstimate { value_s: 0.0, std_err_s: None, status: DelayStatus::NotSeparable }, total),
            };
            LogActuator {
                sha256: survey.track.source.sha256.clone(),
                file: survey.track.source.file.clone(),
                dead_time: estimate(dead_time, std_err, given),
                clock_offset,
            }
        })
        .collect();
    let (mean, spread) = mean_and_error(&per_log.iter().map(|l| l.dead_time.value_s).collect::<Vec<_>>());
    let of_errors = std_errs_s.iter().map(|e| e * e).sum::<f64>().sqrt() / std_errs_s.len() as f64;
    let (lag_s, lag_std_err_s) = if choice.is_feedback() {
        let (lag_s, spread) = mean_and_error(&choice.all_delays().map(|f| f.lag_s).collect::<Vec<_>>());
        let squares: f64 = choice.all_delays().map(|f| (f.misfit() * f.lag_std_err_s).powi(2)).sum();
        (lag_s, spread.max(squares.sqrt() / choice.all_delays().len() as f64))
    } else {
        (found.lag_s, found.lag_std_err_s)
    };
    Actuator {
        dead_time: estimate(mean, spread.max(of_errors), given),
        lag: estimate(lag_s, lag_std_err_s, settings.lag_s.is_some()),
        input: choice.named(),
        per_log,
    }
}

/// Mean, and its standard error by the spread of the values; 0 for a single one.
fn mean_and_error(values: &[f64]) -> (f64, f64) {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let spread =
        if values.len() > 1 { (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (count - 1.0) / count).sqrt() } else { 0.0 };
    (mean, spread)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_error_of_a_mean_is_that_of_the_spread() {
        assert_eq!(mean_and_error(&[0.05]), (0.05, 0.0));
        let (mean, error) = mean_and_error(&[0.04, 0.05, 0.06]);
        // standard deviation 0.01 over √3
        assert!((mean - 0.05).abs() < 1e-12 && (error - 0.01 / 3f64.sqrt()).abs() < 1e-12, "{mean} {error}");
    }
}
