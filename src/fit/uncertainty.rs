//! How sure each value of the surface is.
//!
//! The larger of two variances: the posterior cᵀ(XᵀX + Λ)⁻¹c, right when the model is, and the sandwich cᵀ·H⁻¹(Σ_r s_r·s_rᵀ)H⁻¹·c over the
//! scores s_r of whole runs, right when runs differ more than the model thinks; plus the square of the smoothing bias cᵀ·H⁻¹Λβ.

use super::estimate::Estimate;
use super::gram::LocalGram;
use super::kalman::whiten;
use super::regressors::matrix;
use crate::map::Gear;
use faer::{Col, Mat};
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Covariances and bias of the coefficients.
pub(crate) struct Uncertainty {
    posterior: Mat<f64>,
    sandwich: Mat<f64>,
    bias: Vec<f64>,
}

impl Uncertainty {
    /// From the final estimate.
    pub(crate) fn new(estimate: &Estimate) -> Self {
        let q = estimate.design.coefficients();
        let posterior = Mat::from_fn(q, q, |a, b| estimate.solution.covariance[(a, b)]);
        let mut pull = Col::zeros(q);
        for (block, penalty) in estimate.design.blocks.iter().zip(&estimate.solution.penalties) {
            for k in block.range.clone() {
                pull[k] = if block.penalised && penalty.is_finite() { penalty * estimate.solution.beta[k] } else { 0.0 };
            }
        }
        let moved = &posterior * &pull;
        let bias = (0..q).map(|k| moved[k]).collect();
        let scores = run_scores(estimate);
        let runs = scores.len();
        let mut meat: Mat<f64> = Mat::zeros(q, q);
        if runs > 1 {
            let stacked = Mat::from_fn(q, runs, |a, r| scores[r][a]);
            meat = &stacked * stacked.transpose();
            // scores of a fitted model are shrunk: the usual small-sample factor
            let factor = runs as f64 / (runs as f64 - 1.0);
            meat = Mat::from_fn(q, q, |a, b| factor * meat[(a, b)]);
        }
        let half = &posterior * &meat;
        let sandwich = &half * &posterior;
        Self { posterior, sandwich, bias }
    }

    /// Standard errors of A(V, U) at points (V, U) of a gear [m/s²].
    pub(crate) fn std_errs_mps2(&self, estimate: &Estimate, gear: Gear, points: &[(f64, f64)]) -> Vec<f64> {
        let q = self.bias.len();
        let rows: Vec<Vec<f64>> = points.iter().map(|(v, u)| contrast(estimate, gear, *v, *u)).collect();
        let contrasts = Mat::from_fn(q, points.len(), |a, k| rows[k][a]);
        let (by_posterior, by_sandwich) = (&self.posterior * &contrasts, &self.sandwich * &contrasts);
        (0..points.len())
            .map(|k| {
                let quadratic = |product: &Mat<f64>| (0..q).map(|a| rows[k][a] * product[(a, k)]).sum::<f64>();
                let variance = quadratic(&by_posterior).max(quadratic(&by_sandwich)).max(0.0);
                let bias: f64 = rows[k].iter().zip(&self.bias).map(|(c, b)| c * b).sum();
                (variance + bias * bias).sqrt()
            })
            .collect()
    }
}

/// The row c with A(V, U) = cᵀβ.
fn contrast(estimate: &Estimate, gear: Gear, speed_mps: f64, torque_nm: f64) -> Vec<f64> {
    let lattice = &estimate.surfaces[0].lattice;
    let spot = lattice.spot(speed_mps, torque_nm);
    let t = estimate.design.transform(gear);
    (0..t.ncols()).map(|c| spot.columns(lattice).map(|(r, w)| w * t[(r, c)]).sum()).collect()
}

/// Xᵀe of each run, in the coefficients of the design.
fn run_scores(estimate: &Estimate) -> Vec<Vec<f64>> {
    let lagged: Vec<_> = (0..estimate.logs.len()).map(|k| estimate.lagged(k)).collect();
    let parts: Vec<((usize, usize), Vec<f64>)> = estimate
        .segments
        .par_iter()
        .zip(&estimate.speeds)
        .map(|(s, speed)| {
            let surface = estimate.surface(s.gear);
            let mut local = matrix(s, speed, &lagged[s.log], estimate.calibration.dead_time_s[s.log], surface, false);
            let width = local.columns.len();
            whiten(&mut local.data, width, &s.readings, s.start_s, &estimate.noise, s.start_std_mps);
            let gram = LocalGram::new(local.columns, &local.data);
            let t = estimate.design.transform(s.gear);
            let mut score = vec![0.0; t.ncols()];
            for a in 0..width - 1 {
                let fitted: f64 = (0..width - 1).map(|b| gram.values[(a, b)] * surface.theta[gram.columns[b] as usize]).sum();
                let residual = gram.values[(a, width - 1)] - fitted;
                let row = gram.columns[a] as usize;
                for (c, s) in score.iter_mut().enumerate() {
                    *s += t[(row, c)] * residual;
                }
            }
            ((s.log, s.run), score)
        })
        .collect();
    let mut by_run: BTreeMap<(usize, usize), Vec<f64>> = BTreeMap::new();
    for (run, score) in parts {
        match by_run.get_mut(&run) {
            Some(sum) => sum.iter_mut().zip(&score).for_each(|(a, b)| *a += b),
            None => {
                by_run.insert(run, score);
            }
        }
    }
    by_run.into_values().collect()
}
