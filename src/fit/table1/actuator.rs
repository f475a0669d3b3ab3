//! Dead times, lag and clock offsets of the drive, each with its status.

use crate::campaign::Survey;
use crate::fit::FitSettings;
use crate::fit::drive::torque_input::TorqueChoice;
use crate::fit::drive::undelivered::Undelivered;
use crate::fit::drive_form::campaign_drift::SPANS;
use crate::fit::drive_form::drive_model::DriveModel;
use crate::fit::drive_form::parameters::{LIMIT, PARAMETERS};
use crate::fit::rounds::estimate::Estimate;
use crate::fit::table1::runs::round;
use crate::map::{
    Actuator, CampaignChange, ComparedDrive, DelayEstimate, DelayStatus, DriveFamily, DriveLimit, IdentifiedDrive, LimitKind, LogActuator,
};

/// Least offset between the clocks of command and speed that counts [s]: smaller ones are sampling phases.
const CLOCK_OFFSET_S: f64 = 0.02;
/// A delay with a larger standard error is weakly determined [s].
const WEAK_S: f64 = 0.01;

/// Delays as estimated, one dead time per log.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Delays {
    pub(crate) dead_time_s: Vec<f64>,
    pub(crate) dead_time_std_err_s: Vec<f64>,
    pub(crate) drive: DriveModel,
    /// Standard errors of the drive's parameters: times [s], and the limit's logarithm.
    pub(crate) drive_std_err_s: [f64; PARAMETERS],
}

impl From<&Estimate<'_>> for Delays {
    fn from(estimate: &Estimate<'_>) -> Self {
        Self {
            dead_time_s: estimate.calibration.dead_time_s.clone(),
            dead_time_std_err_s: estimate.calibration_errors.dead_time_s.clone(),
            drive: estimate.calibration.drive,
            drive_std_err_s: estimate.calibration_errors.drive_s,
        }
    }
}

/// Dead times, lag and clock offsets, each with its status; one survey per log.
///
/// If the feedback was the input, the estimated delays are those from feedback to speed. A controller needs those from the command: the
/// feedback's own dead time is added, and its lag replaces the missing one.
pub(crate) fn actuator(
    found: &Delays,
    estimate_at_test: &Estimate,
    surveys: &[&Survey],
    choice: &TorqueChoice,
    settings: &FitSettings,
) -> Actuator {
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
            let feedback = choice.feedback_dead_time(&survey.track, &found.drive);
            // dead time from command to speed, and its part after the feedback
            let ((total, std_err), offset) = match feedback {
                Some((late_s, std_err_s)) if choice.is_feedback() => ((late_s + own.0, own.1.hypot(std_err_s)), Some(own)),
                Some((late_s, std_err_s)) => (own, Some((own.0 - late_s, own.1.hypot(std_err_s)))),
                None => (own, None),
            };
            std_errs_s.push(std_err);
            if let Some(given_s) = settings.dead_time_s {
                return LogActuator {
                    sha256: survey.track.source.sha256.clone(),
                    file: survey.track.source.file.clone(),
                    dead_time: estimate(given_s, std_err, true),
                    clock_offset: offset_estimate(total - given_s, std_err),
                };
            }
            let (clock_offset, dead_time) = match (offset, feedback) {
                (Some((offset, error)), Some((late_s, _))) => {
                    let offset = offset_estimate(offset, error);
                    let dead_time = if offset.status == DelayStatus::Estimated { late_s } else { total };
                    (offset, dead_time)
                }
                // no drive acts before its command: the speed's clock is ahead
                _ if total < 0.0 => (offset_estimate(total, std_err), total),
                _ => (DelayEstimate { value_s: 0.0, std_err_s: None, status: DelayStatus::NotSeparable }, total),
            };
            LogActuator {
                sha256: survey.track.source.sha256.clone(),
                file: survey.track.source.file.clone(),
                dead_time: estimate(dead_time.max(0.0), std_err, given),
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
        (found.drive.mean_lag_s(), found.drive.mean_lag_std_err_s(found.drive_std_err_s))
    };
    Actuator {
        dead_time: estimate(mean, spread.max(of_errors), given),
        lag: estimate(lag_s, lag_std_err_s, settings.lag_s.is_some()),
        input: choice.named(),
        drive: identified_drive(found, estimate_at_test, surveys, choice),
        changes: campaign_changes(estimate_at_test),
        per_log,
    }
}

/// An offset between the clocks of command and speed, and whether it counts as one.
fn offset_estimate(offset_s: f64, std_err_s: f64) -> DelayEstimate {
    let real = offset_s.abs() > CLOCK_OFFSET_S.max(4.0 * std_err_s);
    DelayEstimate {
        value_s: round(offset_s, 1e6),
        std_err_s: Some(round(std_err_s, 1e6)),
        status: if real { DelayStatus::Estimated } else { DelayStatus::NoneFound },
    }
}

/// The drive, where it is more than a first-order lag.
fn identified_drive(found: &Delays, estimate: &Estimate, surveys: &[&Survey], choice: &TorqueChoice) -> Option<IdentifiedDrive> {
    let mut drive = found.drive.identified(found.drive_std_err_s[LIMIT]);
    if choice.is_feedback() {
        drive = IdentifiedDrive { family: DriveFamily::Feedback, lag_s: None, ..drive };
    }
    drive.compared = estimate
        .other_drives
        .iter()
        .map(|(drive, worse, std_err)| ComparedDrive { drive: drive.to_string(), worse: round(*worse, 1e1), std_err: round(*std_err, 1e1) })
        .collect();
    drive.better_than_given = estimate.better_than_given.map(|(drive, worse)| ComparedDrive {
        drive: drive.to_string(),
        worse: round(-worse, 1e1),
        std_err: 0.0,
    });
    drive.exceeded_s = choice.exceeded_s().map(|seconds| round(seconds, 1e2));
    if let Some(limit) = choice.speed_limit() {
        let intervals = surveys.iter().flat_map(|survey| limit.undelivered_s(survey));
        drive.undelivered_s = Some(round(intervals.map(|(from_s, to_s)| to_s - from_s).sum(), 1e2));
        let governor = DriveLimit { kind: LimitKind::Speed, value: round(limit.speed_mps, 1e3), std_err: None };
        drive.limit = drive.limit.or(Some(governor));
    }
    let undelivered = undelivered_samples(surveys, choice);
    if !undelivered.is_empty() {
        let shown_s: f64 = undelivered.iter().map(|u| u.seconds).sum();
        drive.undelivered_s = Some(round(shown_s.max(drive.undelivered_s.unwrap_or(0.0)), 1e2));
        drive.undelivered_share = common_share(&undelivered).map(|share| round(share, 1e3));
        drive.limit = drive.limit.or_else(|| limit_of(&undelivered)).filter(|_| drive.undelivered_share.is_none());
    }
    let departs = drive.undelivered_s.is_some() || drive.better_than_given.is_some() || drive.exceeded_s.is_some();
    let plain = drive.family == DriveFamily::FirstOrder && drive.limit.is_none() && drive.compared.is_empty() && !departs;
    (!plain).then_some(drive)
}

/// Torques are different from this ratio on, and shares of them the same within this distance.
const DIFFERENT_TORQUES: f64 = 1.3;
const SAME_SHARE: f64 = 0.05;
/// Shares beyond this are no shares of what was asked for.
const LARGEST_SHARE: f64 = 2.0;

/// Torque that was not delivered in one interval.
struct UndeliveredTorque {
    seconds: f64,
    /// Median torque [N·m] and speed [m/s].
    torque_nm: f64,
    speed_mps: f64,
    /// Median share of the commanded torque that was delivered.
    share: f64,
}

fn undelivered_samples(surveys: &[&Survey], choice: &TorqueChoice) -> Vec<UndeliveredTorque> {
    let of_log = |survey: &&Survey| -> Vec<UndeliveredTorque> {
        let encoder = &survey.track.encoder_mps;
        let one = |u: &Undelivered| {
            let speeds: Vec<f64> = encoder.range(u.from_s, u.to_s).map(|k| encoder.value[k].abs()).collect();
            let (seconds, torque_nm) = (u.to_s - u.from_s, u.torque_nm.abs());
            UndeliveredTorque { seconds, torque_nm, speed_mps: crate::signal::median(&speeds), share: u.share }
        };
        choice.undelivered(&survey.track.source).iter().map(one).filter(|u| u.speed_mps.is_finite()).collect()
    };
    surveys.iter().flat_map(of_log).collect()
}

/// The share of the commanded torque that was delivered, where it is the same at different torques: another scale, and not a limit.
fn common_share(undelivered: &[UndeliveredTorque]) -> Option<f64> {
    // right after a step to none, next to nothing is asked for
    let asked: Vec<&UndeliveredTorque> = undelivered.iter().filter(|u| u.share.is_finite() && u.share.abs() < LARGEST_SHARE).collect();
    if asked.is_empty() {
        return None;
    }
    let range = |of: &dyn Fn(&UndeliveredTorque) -> f64| {
        let mut values: Vec<f64> = asked.iter().map(|u| of(u)).collect();
        values.sort_unstable_by(f64::total_cmp);
        let at = |share: f64| values[(share * (values.len() - 1) as f64).round() as usize];
        (at(0.1), at(0.9))
    };
    let (torques, shares) = (range(&|u| u.torque_nm), range(&|u| u.share));
    let is_common = torques.1 > DIFFERENT_TORQUES * torques.0 && (shares.1 - shares.0).abs() < SAME_SHARE;
    is_common.then(|| crate::signal::median(&asked.iter().map(|u| u.share).collect::<Vec<_>>()))
}

/// The limit that explains the intervals best: of speed, torque or power, the one that varies least among them.
fn limit_of(undelivered: &[UndeliveredTorque]) -> Option<DriveLimit> {
    let spread = |of: &dyn Fn(&UndeliveredTorque) -> f64| {
        let values: Vec<f64> = undelivered.iter().map(of).collect();
        let centre = crate::signal::median(&values);
        let away: Vec<f64> = values.iter().map(|v| (v - centre).abs()).collect();
        (crate::signal::median(&away) / centre.abs().max(1e-9), centre)
    };
    let candidates = [
        (LimitKind::Torque, spread(&|u| u.torque_nm)),
        (LimitKind::Power, spread(&|u| u.torque_nm * u.speed_mps)),
        (LimitKind::Speed, spread(&|u| u.speed_mps)),
    ];
    let best = candidates.into_iter().min_by(|a, b| a.1.0.total_cmp(&b.1.0))?;
    Some(DriveLimit { kind: best.0, value: round(best.1.1, 1e3), std_err: None })
}

/// What clearly changed over the campaign, and over each log.
fn campaign_changes(estimate: &Estimate) -> Vec<CampaignChange> {
    let (found, error) = (&estimate.calibration.drift, &estimate.calibration_errors.drift);
    let change = |k: usize| CampaignChange {
        of_each_log: k > 0,
        friction_share: round(found.friction_share[k], 1e6),
        friction_share_std_err: round(error.friction_share[k], 1e6),
        torque_share: round(found.torque_share[k], 1e6),
        torque_share_std_err: round(error.torque_share[k], 1e6),
    };
    (0..SPANS).filter(|k| found.friction_share[*k] != 0.0 || found.torque_share[*k] != 0.0).map(change).collect()
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
