//! The standard error of each value of the surface.
//!
//! The larger of two variances: the posterior cᵀ(XᵀX + Λ)⁻¹c, right when the model is, and the sandwich cᵀ·H⁻¹(Σ_r s_r·s_rᵀ)H⁻¹·c over the
//! scores s_r of whole runs, right when runs differ more than in the model. X also holds the columns of the delays, so both include the
//! uncertainty of the delays. Added to it: the square of the smoothing bias cᵀ·H⁻¹Λβ, and the uncertainty of that bias by penalties that
//! are not exactly known (Kass & Steffey 1989; Wood, Pya & Säfken 2016, *Smoothing parameter and model selection for general smooth
//! models*). If only a share w of the surface's deviations is used, 1 − w of their square is added for the choice between form and surface.
//! The sum is then compared with a jackknife over runs, and multiplied where that spreads wider.

use crate::fit::motion::integration::{Course, courses};
use crate::fit::motion::regressors::add_score;
use crate::fit::rounds::estimate::Estimate;
use crate::map::{Gear, PerGear};
use crate::signal::median;
use faer::Mat;
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Fewest folds whose spread is used.
const FEWEST_FOLDS: usize = 4;
/// Largest factor on the standard errors: beyond it the model is wrong, which other checks report.
const MOST_INFLATION: f64 = 3.0;
/// Factor where readings in coarse steps count as intervals: they follow the surface that places them, so that the folds agree too well. On a
/// vehicle with steps of 0.05 m/s, two thirds of the values lay within 1.96 standard errors without it.
const COARSE_DOUBT: f64 = 2.5;
/// Median of a χ² distribution with four degrees of freedom, over its mean.
const MEDIAN_OF_CHI_SQUARE: f64 = 0.839;
/// Every seventh reading gives a place, and this number of places is enough.
const EVERY: usize = 7;
const MOST_POINTS: usize = 400;

/// Covariances of the coefficients, those of the design and of the nuisance columns.
pub(crate) struct Uncertainty {
    posterior: Mat<f64>,
    sandwich: Mat<f64>,
    /// Factor by which the spread of fits without a part of the runs exceeds these, at least 1.
    inflation: PerGear<f64>,
}

impl Uncertainty {
    /// From the final estimate.
    pub(crate) fn new(estimate: &Estimate) -> Self {
        let posterior = estimate.model.stacked.solution.covariance.clone();
        let half = &posterior * &meat(estimate);
        let sandwich = &half * &posterior;
        let plain = Self { posterior, sandwich, inflation: PerGear::from_fn(|_| 1.0) };
        let coarse = estimate.data.logs.iter().any(|log| log.coarse_mps != [0.0; 2]);
        let least = if coarse { COARSE_DOUBT } else { 1.0 };
        let inflation = PerGear::from_fn(|gear| plain.jackknife_ratio(estimate, gear).max(least));
        Self { inflation, ..plain }
    }

    /// The spread of the surfaces fitted without each fold of the runs, over these standard errors: the delete-a-group jackknife (Efron &
    /// Stein 1981; Kott 2001, *The delete-a-group jackknife*), with penalties chosen again in every fold. The median over the places where
    /// the runs have been, from 1 to [`MOST_INFLATION`].
    fn jackknife_ratio(&self, estimate: &Estimate, gear: Gear) -> f64 {
        let Some(validation) = &estimate.validation else { return 1.0 };
        let points = visited(estimate, gear);
        let folds = validation.without.len();
        if points.is_empty() || folds < FEWEST_FOLDS {
            return 1.0;
        }
        let std_errs = self.std_errs_mps2(estimate, gear, &points);
        let ratios: Vec<f64> = points
            .iter()
            .zip(std_errs)
            .map(|((v, u), std_err)| {
                let values: Vec<f64> = validation.without.iter().map(|w| w[gear].accel_mps2(*v, *u)).collect();
                let mean = values.iter().sum::<f64>() / folds as f64;
                let squares: f64 = values.iter().map(|a| (a - mean).powi(2)).sum();
                squares * (folds as f64 - 1.0) / folds as f64 / (std_err * std_err).max(1e-18)
            })
            .collect();
        (median(&ratios) / MEDIAN_OF_CHI_SQUARE).sqrt().clamp(1.0, MOST_INFLATION)
    }

    /// Standard errors of A(V, U) at points (V, U) of a gear [m/s²].
    pub(crate) fn std_errs_mps2(&self, estimate: &Estimate, gear: Gear, points: &[(f64, f64)]) -> Vec<f64> {
        let q = estimate.model.design.coefficients();
        let rows: Vec<Vec<f64>> = points.iter().map(|(v, u)| contrast(estimate, gear, *v, *u)).collect();
        let contrasts = Mat::from_fn(q, points.len(), |a, k| rows[k][a]);
        let products = [&self.posterior, &self.sandwich, &estimate.model.plausible].map(|m| m.submatrix(0, 0, q, q) * &contrasts);
        (0..points.len())
            .map(|k| {
                let [posterior, sandwich, plausible] =
                    products.each_ref().map(|product| (0..q).map(|a| rows[k][a] * product[(a, k)]).sum::<f64>().max(0.0));
                let doubt: f64 = rows[k].iter().zip(&estimate.model.stacked.doubt).map(|(c, d)| c * d).sum();
                let (mut bias, mut extra) = (0.0, doubt * doubt);
                for pull in &estimate.model.stacked.pulls {
                    let pulled: f64 = rows[k].iter().zip(&pull.of).map(|(c, p)| c * p).sum();
                    bias += pulled;
                    extra += pull.relative_variance * pulled * pulled;
                }
                self.inflation[gear] * (posterior.max(sandwich).max(plausible) + bias * bias + extra).sqrt()
            })
            .collect()
    }
}

/// Some of the speeds and torques that the runs of a gear have been at.
fn visited(estimate: &Estimate, gear: Gear) -> Vec<(f64, f64)> {
    let lagged = estimate.torques();
    let mut points = Vec::new();
    for (segment, lookups) in estimate.paths.merged.iter().zip(&estimate.paths.lookups).filter(|(s, _)| s.gear == gear) {
        let course = Course::new(segment, &lagged[segment.log], estimate.calibration.dead_time_s[segment.log]);
        points.extend((0..course.rows()).step_by(EVERY).filter_map(|row| {
            let (v, step) = course.along(lookups, row).last()?;
            Some((v, step.torque.torque_nm))
        }));
    }
    let stride = points.len().div_ceil(MOST_POINTS).max(1);
    points.into_iter().step_by(stride).collect()
}

/// The row c with A(V, U) = cᵀβ.
fn contrast(estimate: &Estimate, gear: Gear, speed_mps: f64, torque_nm: f64) -> Vec<f64> {
    let lattice = &estimate.model.surfaces.forward.lattice;
    let spot = lattice.spot(speed_mps, torque_nm);
    let t = estimate.model.design.transform(gear);
    (0..t.ncols()).map(|c| spot.columns(lattice).map(|(r, w)| w * t[(r, c)]).sum()).collect()
}

/// Σ s_r·s_rᵀ over the runs' scores s_r = Xᵀe; those of the encoder's columns are zero.
fn meat(estimate: &Estimate) -> Mat<f64> {
    let lagged = estimate.torques();
    let (segments, speeds) = (&estimate.paths.merged, &estimate.paths.lookups);
    let courses = courses(segments, &lagged, &estimate.calibration);
    let base = estimate.model.surfaces.forward.lattice.columns();
    let (q, nuisances) = (estimate.model.design.coefficients(), estimate.free.nuisances(estimate.data.logs.len()));
    let mut meat: Mat<f64> = Mat::zeros(q + nuisances, q + nuisances);
    for gear in &estimate.data.gears {
        let mut runs: BTreeMap<(usize, usize), Vec<usize>> = BTreeMap::new();
        for (k, course) in courses.iter().enumerate().filter(|(_, c)| c.segment.gear == *gear) {
            runs.entry((course.segment.log, course.segment.run)).or_default().push(k);
        }
        let runs: Vec<Vec<usize>> = runs.into_values().collect();
        let scores: Vec<Vec<f64>> = runs
            .par_iter()
            .map(|run| {
                let mut score = vec![0.0; base + nuisances];
                for &k in run {
                    add_score(&courses[k], &speeds[k], estimate.model.surface(*gear), &estimate.noise, estimate.free, &mut score);
                }
                score
            })
            .collect();
        let runs = scores.len();
        if runs < 2 {
            continue;
        }
        let lattice = Mat::from_fn(runs, base, |r, c| scores[r][c]) * estimate.model.design.transform(*gear);
        let all = Mat::from_fn(runs, q + nuisances, |r, c| if c < q { lattice[(r, c)] } else { scores[r][base + c - q] });
        // scores of a fitted model are shrunk: the usual small-sample factor
        meat += faer::Scale(runs as f64 / (runs as f64 - 1.0)) * (all.transpose() * &all);
    }
    meat
}
