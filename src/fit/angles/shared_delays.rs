//! Delays that the wheel angles of a campaign share: dead times (one per log), lag, and the encoder's calibration.
//!
//! Each angle with a yaw rate is first fitted by itself. Its delays are pooled by their standard errors. The encoder's scale and delay come
//! from the angle with the largest |sin δ|, where the yaw rate shows speeds best. Angles without a yaw rate then give the dead times of
//! logs that no other angle shares.

use crate::campaign::AngleGroup;
use crate::fit::drive::torque_input::TorqueChoice;
use crate::fit::drive_form::drive_model::DriveModel;
use crate::fit::drive_form::parameters::PARAMETERS;
use crate::fit::rounds::estimate::Estimate;
use crate::fit::table1::actuator::Delays;
use crate::fit::{Error, FitSettings, KnownCalibration, rounds};
use crate::map::LogRef;
use crate::units::RAD_PER_DEG;
use std::collections::BTreeMap;

/// Least standard error when estimates are pooled [s].
const LEAST_DELAY_STD_ERR_S: f64 = 1e-4;

/// The shared values, and the angles that cannot be fitted.
#[derive(Debug)]
pub(crate) struct Shared {
    pub(crate) known: KnownCalibration,
    pub(crate) pooled: Pooled,
    pub(crate) failed: Vec<(f64, Error)>,
}

impl Shared {
    /// Fits the delays of each angle, those with a yaw rate first.
    pub(crate) fn new(groups: &[AngleGroup], choice: &TorqueChoice, settings: &FitSettings) -> Self {
        let has_yaw = |g: &&AngleGroup| g.surveys.iter().any(|s| s.track.yaw_speed_mps.is_some());
        let mut pooled = Pooled::default();
        let mut failed = Vec::new();
        let mut best: Option<(f64, (f64, f64))> = None;
        for group in groups.iter().filter(has_yaw) {
            match rounds::estimate(&group.surveys, choice, settings) {
                Ok(estimate) => {
                    pooled.add(&estimate);
                    let sine = (group.wheel_angle_deg * RAD_PER_DEG).sin().abs();
                    if best.is_none_or(|(s, _)| sine > s) {
                        best = Some((sine, (estimate.calibration.encoder_scale, estimate.calibration.encoder_delay_s)));
                    }
                }
                Err(error) => failed.push((group.wheel_angle_deg, error)),
            }
        }
        let encoder = best.map(|(_, encoder)| encoder);
        // the encoder alone: its delay is known by now, or is a part of the dead time
        let so_far = pooled.known(encoder);
        let mut others = Pooled::default();
        for group in groups.iter().filter(|g| !has_yaw(g)) {
            let all_known = group.surveys.iter().all(|s| so_far.dead_time_s.contains_key(&s.track.source.sha256));
            if all_known {
                continue;
            }
            let held = FitSettings { known: Some(so_far.clone()), ..settings.clone() };
            match rounds::estimate(&group.surveys, choice, &held) {
                Ok(estimate) => others.add(&estimate),
                Err(error) => failed.push((group.wheel_angle_deg, error)),
            }
        }
        for (log, pool) in others.dead_time_s {
            pooled.dead_time_s.entry(log).or_insert(pool);
        }
        if pooled.drive.is_none() {
            pooled.drive = others.drive;
        }
        Self { known: pooled.known(encoder), pooled, failed }
    }
}

/// Values pooled by their standard errors.
#[derive(Debug, Clone, Copy, Default)]
struct Pool {
    weight: f64,
    sum: f64,
}

impl Pool {
    fn add(&mut self, value: f64, std_err: f64) {
        let weight = std_err.max(LEAST_DELAY_STD_ERR_S).powi(-2);
        self.weight += weight;
        self.sum += weight * value;
    }

    fn mean(self) -> Option<(f64, f64)> {
        (self.weight > 0.0).then(|| (self.sum / self.weight, self.weight.powf(-0.5)))
    }
}

/// Delays of the logs and the drive, pooled over the angles.
#[derive(Debug, Default)]
pub(crate) struct Pooled {
    dead_time_s: BTreeMap<String, Pool>,
    /// The drive of the first angle, and the values of its parameters.
    drive: Option<(DriveModel, [Pool; PARAMETERS])>,
}

impl Pooled {
    fn add(&mut self, estimate: &Estimate) {
        let calibration = &estimate.calibration;
        for ((log, dead_time_s), std_err_s) in
            estimate.data.logs.iter().zip(&calibration.dead_time_s).zip(&estimate.calibration_errors.dead_time_s)
        {
            self.dead_time_s.entry(log.survey.track.source.sha256.clone()).or_default().add(*dead_time_s, *std_err_s);
        }
        let (_, pools) = self.drive.get_or_insert((calibration.drive, [Pool::default(); PARAMETERS]));
        for (pool, (value, std_err)) in
            pools.iter_mut().zip(calibration.drive.parameters().into_iter().zip(estimate.calibration_errors.drive_s))
        {
            pool.add(value, std_err);
        }
    }

    fn known(&self, encoder: Option<(f64, f64)>) -> KnownCalibration {
        KnownCalibration {
            dead_time_s: self.dead_time_s.iter().filter_map(|(log, pool)| Some((log.clone(), pool.mean()?.0))).collect(),
            drive: self.drive().map(|d| d.0),
            encoder,
        }
    }

    /// The drive, with the standard errors of its parameters [s].
    fn drive(&self) -> Option<(DriveModel, [f64; PARAMETERS])> {
        let (drive, pools) = self.drive?;
        let means = pools.map(|p| p.mean().unwrap_or((0.0, 0.0)));
        let own = drive.parameters();
        Some((drive.moved(std::array::from_fn(|p| means[p].0 - own[p])), means.map(|m| m.1)))
    }

    /// Delays of `logs`. A log whose only angle could not be fitted gets those of the test angle's first log.
    pub(crate) fn delays(&self, logs: &[LogRef], test: &Estimate) -> Delays {
        let of_log = |log: &LogRef| {
            let own = self.dead_time_s.get(&log.sha256).and_then(|p| p.mean());
            own.unwrap_or((test.calibration.dead_time_s[0], test.calibration_errors.dead_time_s[0]))
        };
        let dead_times: Vec<(f64, f64)> = logs.iter().map(of_log).collect();
        let (drive, drive_std_err_s) = self.drive().unwrap_or((test.calibration.drive, test.calibration_errors.drive_s));
        Delays {
            dead_time_s: dead_times.iter().map(|d| d.0).collect(),
            dead_time_std_err_s: dead_times.iter().map(|d| d.1).collect(),
            drive,
            drive_std_err_s,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_pooled_by_their_standard_errors() {
        let mut pool = Pool::default();
        assert_eq!(pool.mean(), None);
        pool.add(0.050, 0.010);
        pool.add(0.060, 0.020);
        // weights 4 to 1
        let Some((mean, std_err)) = pool.mean() else { unreachable!("there are two values") };
        assert!((mean - 0.052).abs() < 1e-12 && (std_err - 0.01 * 0.8f64.sqrt()).abs() < 1e-12, "{mean} {std_err}");
    }

    #[test]
    fn no_value_counts_for_more_than_a_delay_can_be_known() {
        let mut pool = Pool::default();
        pool.add(0.050, 0.0);
        pool.add(0.060, 0.0);
        let known = pool.mean().map(|(mean, std_err)| ((mean - 0.055).abs() < 1e-12, std_err > 0.0));
        assert_eq!(known, Some((true, true)));
    }
}
