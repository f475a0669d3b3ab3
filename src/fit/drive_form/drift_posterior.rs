//! What is known of the changes during a campaign, clear or not, and what that means for the map of another time.
//!
//! The surface is that of the mean of a gear's runs; the end of the campaign lies elsewhere. With the estimate x̂ and covariance Σ of the changes and a prior N(0, T) of their ordinary size, the
//! posterior has the covariance P = (Σ⁻¹ + T⁻¹)⁻¹ and the mean P·Σ⁻¹·x̂: changes that the data do not show count for little, and how
//! large they may be stands in P.

use crate::fit::drive_form::campaign_drift::{CampaignDrift, DriftNow, Progress, SPANS};
use faer::Mat;
use faer::linalg::solvers::Solve;

/// Number of changes: of friction, then of torque, each over the campaign and over each log.
pub(crate) const CHANGES: usize = 2 * SPANS;
/// Ordinary change of friction over half of the campaign, or of a log, as a share (standard deviation).
const ORDINARY_FRICTION: f64 = 0.05;
/// The same of the torque under the same command: a magnet loses about 0.1 % of its field with each kelvin.
const ORDINARY_TORQUE: f64 = 0.02;

/// Mean and covariance of the changes.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct DriftPosterior {
    mean: [f64; CHANGES],
    covariance: Mat<f64>,
}

impl Default for DriftPosterior {
    /// Nothing changes, and that is known.
    fn default() -> Self {
        Self { mean: [0.0; CHANGES], covariance: Mat::zeros(CHANGES, CHANGES) }
    }
}

impl DriftPosterior {
    /// From the estimate with its covariance; `free` are those that were estimated, the others are zero. `None` if the covariance is none.
    pub(crate) fn new(estimate: [f64; CHANGES], covariance: &Mat<f64>, free: [bool; CHANGES]) -> Option<Self> {
        let prior = |k: usize| if k < SPANS { ORDINARY_FRICTION } else { ORDINARY_TORQUE };
        let own: Vec<usize> = (0..CHANGES).filter(|k| free[*k]).collect();
        if own.is_empty() {
            return Some(Self::default());
        }
        let inverse = |of: &Mat<f64>| Some(of.llt(faer::Side::Lower).ok()?.solve(Mat::<f64>::identity(own.len(), own.len())));
        let information = inverse(&Mat::from_fn(own.len(), own.len(), |a, b| covariance[(own[a], own[b])]))?;
        let sum = Mat::from_fn(own.len(), own.len(), |a, b| {
            let of_prior = if a == b { prior(own[a]).powi(-2) } else { 0.0 };
            0.5 * (information[(a, b)] + information[(b, a)]) + of_prior
        });
        let posterior = inverse(&sum)?;
        let seen = Mat::from_fn(own.len(), 1, |a, _| estimate[own[a]]);
        let mean_of_free = &posterior * &(&information * &seen);
        let mut found = Self::default();
        for (a, k) in own.iter().enumerate() {
            found.mean[*k] = mean_of_free[(a, 0)];
            for (b, l) in own.iter().enumerate() {
                found.covariance[(*k, *l)] = posterior[(a, b)];
            }
        }
        Some(found)
    }

    /// The same with the changes that are estimated with the surface in place of those here.
    pub(crate) fn with_clear(&self, clear: [bool; CHANGES], drift: &CampaignDrift, std_err: &CampaignDrift) -> Self {
        let values = |of: &CampaignDrift| -> [f64; CHANGES] {
            std::array::from_fn(|k| if k < SPANS { of.friction_share[k] } else { of.torque_share[k - SPANS] })
        };
        let mut all = self.clone();
        if clear == [false; CHANGES] {
            return all;
        }
        // what was found for the others depends on those that are now known better
        for k in 0..CHANGES {
            for l in (0..CHANGES).filter(|l| *l != k) {
                all.covariance[(k, l)] = 0.0;
            }
            all.mean[k] = if clear[k] { values(drift)[k] } else { 0.0 };
            if clear[k] {
                all.covariance[(k, k)] = values(std_err)[k].powi(2);
            }
        }
        all
    }

    /// The change at a time.
    pub(crate) fn at(&self, progress: Progress) -> DriftNow {
        let (friction, torque) = self.mean.split_at(SPANS);
        let sum = |of: &[f64]| of.iter().zip(progress).map(|(change, w)| change * w).sum();
        DriftNow { friction_share: sum(friction), torque_share: sum(torque) }
    }

    /// Standard deviation of the change of A(v, u) at a time [m/s²], of A(v, 0) [m/s²] and of u·∂A/∂u [m/s²].
    pub(crate) fn std_mps2(&self, progress: Progress, friction_mps2: f64, torque_mps2: f64) -> f64 {
        let by = |k: usize| progress[k % SPANS] * if k < SPANS { friction_mps2 } else { torque_mps2 };
        let variance: f64 = (0..CHANGES).map(|k| (0..CHANGES).map(|l| by(k) * self.covariance[(k, l)] * by(l)).sum::<f64>()).sum();
        variance.max(0.0).sqrt()
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    const CAMPAIGN: [bool; CHANGES] = [true, false, true, false];

    fn diagonal(std: [f64; CHANGES]) -> Mat<f64> {
        Mat::from_fn(CHANGES, CHANGES, |a, b| if a == b { std[a] * std[a] } else { 0.0 })
    }

    #[test]
    fn an_estimate_as_uncertain_as_the_ordinary_size_counts_by_half() {
        let std = [ORDINARY_FRICTION, 1.0, ORDINARY_TORQUE, 1.0];
        let found = DriftPosterior::new([-0.06, 0.0, 0.0, 0.0], &diagonal(std), CAMPAIGN).unwrap();
        let at = found.at([1.0, 1.0]);
        assert!((at.friction_share + 0.03).abs() < 1e-6 && at.torque_share == 0.0, "{at:?}");
        // the standard deviation is 1/√2 of each
        assert!((found.std_mps2([1.0, 1.0], 2.0, 0.0) - 2.0 * ORDINARY_FRICTION / 2f64.sqrt()).abs() < 1e-6);
        assert!(found.std_mps2([0.0, 1.0], 2.0, 2.0) < 1e-12, "at the mean nothing is uncertain");
    }

    #[test]
    fn a_certain_estimate_stays_and_one_without_data_is_the_prior() {
        let found = DriftPosterior::new([-0.1, 0.0, 0.1, 0.0], &diagonal([1e-4, 0.0, 1e6, 0.0]), CAMPAIGN).unwrap();
        assert!((found.at([1.0, 0.0]).friction_share + 0.1).abs() < 1e-4);
        assert!(found.at([1.0, 0.0]).torque_share.abs() < 1e-9);
        assert!((found.std_mps2([1.0, 0.0], 0.0, 1.0) - ORDINARY_TORQUE).abs() < 1e-6);
    }

    #[test]
    fn a_clear_change_takes_the_place_of_the_shrunk_one() {
        let first = DriftPosterior::new([-0.1, 0.0, 0.01, 0.0], &diagonal([0.01; CHANGES]), CAMPAIGN).unwrap();
        let drift = CampaignDrift { friction_share: [-0.12, 0.0], torque_share: [0.0; SPANS] };
        let std_err = CampaignDrift { friction_share: [0.005, 0.0], torque_share: [0.0; SPANS] };
        let clear = first.with_clear([true, false, false, false], &drift, &std_err);
        assert_eq!(clear.at([1.0, 0.0]), DriftNow { friction_share: -0.12, torque_share: 0.0 });
        assert!((clear.std_mps2([1.0, 0.0], 1.0, 0.0) - 0.005).abs() < 1e-12);
        assert!(clear.std_mps2([1.0, 0.0], 0.0, 1.0) > 0.0, "how large the other may be is not forgotten");
    }
}
