//! The standard error of each value of the surface.
//!
//! The larger of two variances: the posterior cᵀ(XᵀX + Λ)⁻¹c, right when the model is, and the sandwich cᵀ·H⁻¹(Σ_r s_r·s_rᵀ)H⁻¹·c over the
//! scores s_r of whole runs, right when runs differ more than in the model. X also holds the columns of the delays, so both include the
//! uncertainty of the delays. Added to it: the square of the smoothing bias cᵀ·H⁻¹Λβ, and the uncertainty of that bias by penalties that
//! are not exactly known (Kass & Steffey 1989; Wood, Pya & Säfken 2016, *Smoothing parameter and model selection for general smooth
//! models*). If only a share w of the surface's deviations is used, 1 − w of their square stands for the doubt between form and surface.

use crate::fit::motion::integration::courses;
use crate::fit::motion::regressors::add_score;
use crate::fit::rounds::estimate::Estimate;
use crate::map::Gear;
use faer::Mat;
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Covariances of the coefficients, those of the design and of the nuisance columns.
pub(crate) struct Uncertainty {
    posterior: Mat<f64>,
    sandwich: Mat<f64>,
}

impl Uncertainty {
    /// From the final estimate.
    pub(crate) fn new(estimate: &Estimate) -> Self {
        let posterior = estimate.model.stacked.solution.covariance.clone();
        let half = &posterior * &meat(estimate);
        let sandwich = &half * &posterior;
        Self { posterior, sandwich }
    }

    /// Standard errors of A(V, U) at points (V, U) of a gear [m/s²].
    pub(crate) fn std_errs_mps2(&self, estimate: &Estimate, gear: Gear, points: &[(f64, f64)]) -> Vec<f64> {
        let q = estimate.model.design.coefficients();
        let rows: Vec<Vec<f64>> = points.iter().map(|(v, u)| contrast(estimate, gear, *v, *u)).collect();
        let contrasts = Mat::from_fn(q, points.len(), |a, k| rows[k][a]);
        let products = [&self.posterior, &self.sandwich].map(|m| m.submatrix(0, 0, q, q) * &contrasts);
        (0..points.len())
            .map(|k| {
                let [posterior, sandwich] =
                    products.each_ref().map(|product| (0..q).map(|a| rows[k][a] * product[(a, k)]).sum::<f64>().max(0.0));
                let doubt: f64 = rows[k].iter().zip(&estimate.model.stacked.doubt).map(|(c, d)| c * d).sum();
                let (mut bias, mut extra) = (0.0, doubt * doubt);
                for pull in &estimate.model.stacked.pulls {
                    let pulled: f64 = rows[k].iter().zip(&pull.of).map(|(c, p)| c * p).sum();
                    bias += pulled;
                    extra += pull.relative_variance * pulled * pulled;
                }
                (posterior.max(sandwich) + bias * bias + extra).sqrt()
            })
            .collect()
    }
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
