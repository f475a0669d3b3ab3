//! How sure each value of the surface is.
//!
//! The larger of two variances: the posterior cᵀ(XᵀX + Λ)⁻¹c, right when the model is, and the sandwich cᵀ·H⁻¹(Σ_r s_r·s_rᵀ)H⁻¹·c over the
//! scores s_r of whole runs, right when runs differ more than the model thinks. On top: what delays that are not exactly known make of the
//! surface, the square of the smoothing bias cᵀ·H⁻¹Λβ, and what penalties that are not exactly known make of that (Kass & Steffey 1989;
//! Wood, Pya & Säfken 2016, *Smoothing parameter and model selection for general smooth models*).

use super::course::courses;
use super::estimate::Estimate;
use super::regressors::{Free, nuisance, whitened};
use crate::map::Gear;
use faer::Mat;
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Covariances and bias of the coefficients.
pub(crate) struct Uncertainty {
    posterior: Mat<f64>,
    sandwich: Mat<f64>,
    /// What the delays' own uncertainty makes of the coefficients: H⁻¹·C·Σ·Cᵀ·H⁻¹, with C the coupling and Σ the delays' covariance.
    by_delays: Mat<f64>,
    /// H⁻¹·λ_j·β_j of each block: where its penalty pulls, and by how much of itself that is unsure.
    pulls: Vec<(Vec<f64>, f64)>,
}

impl Uncertainty {
    /// From the final estimate.
    pub(crate) fn new(estimate: &Estimate) -> Self {
        let q = estimate.design.coefficients();
        let posterior = Mat::from_fn(q, q, |a, b| estimate.solution.covariance[(a, b)]);
        let pulls = pulls(estimate, &posterior);
        let (meat, coupling) = meat_and_coupling(estimate);
        let answer = &posterior * &coupling;
        let by_delays = &answer * &estimate.calibration_errors.covariance * answer.transpose();
        let half = &posterior * &meat;
        let sandwich = &half * &posterior;
        Self { posterior, sandwich, by_delays, pulls }
    }

    /// Standard errors of A(V, U) at points (V, U) of a gear [m/s²].
    pub(crate) fn std_errs_mps2(&self, estimate: &Estimate, gear: Gear, points: &[(f64, f64)]) -> Vec<f64> {
        let q = self.posterior.nrows();
        let rows: Vec<Vec<f64>> = points.iter().map(|(v, u)| contrast(estimate, gear, *v, *u)).collect();
        let contrasts = Mat::from_fn(q, points.len(), |a, k| rows[k][a]);
        let products = [&self.posterior, &self.sandwich, &self.by_delays].map(|m| m * &contrasts);
        (0..points.len())
            .map(|k| {
                let [posterior, sandwich, by_delays] =
                    products.each_ref().map(|product| (0..q).map(|a| rows[k][a] * product[(a, k)]).sum::<f64>().max(0.0));
                let (mut bias, mut unsure) = (0.0, 0.0);
                for (pull, relative_variance) in &self.pulls {
                    let pulled: f64 = rows[k].iter().zip(pull).map(|(c, p)| c * p).sum();
                    bias += pulled;
                    unsure += relative_variance * pulled * pulled;
                }
                (posterior.max(sandwich) + by_delays + bias * bias + unsure).sqrt()
            })
            .collect()
    }
}

/// The pull of each block's penalty. λ_j is known to a relative variance of about 2/edf_j: it is a ratio of edf_j squares to their number.
fn pulls(estimate: &Estimate, posterior: &Mat<f64>) -> Vec<(Vec<f64>, f64)> {
    let solution = &estimate.solution;
    let q = posterior.nrows();
    let mut pulls = Vec::new();
    for (j, block) in estimate.design.blocks.iter().enumerate().filter(|(j, b)| b.penalised && solution.penalties[*j].is_finite()) {
        let pull = (0..q).map(|a| block.range.clone().map(|k| posterior[(a, k)] * solution.penalties[j] * solution.beta[k]).sum());
        pulls.push((pull.collect(), 2.0 / solution.degrees[j].max(1.0)));
    }
    pulls
}

/// The row c with A(V, U) = cᵀβ.
fn contrast(estimate: &Estimate, gear: Gear, speed_mps: f64, torque_nm: f64) -> Vec<f64> {
    let lattice = &estimate.surfaces[0].lattice;
    let spot = lattice.spot(speed_mps, torque_nm);
    let t = estimate.design.transform(gear);
    (0..t.ncols()).map(|c| spot.columns(lattice).map(|(r, w)| w * t[(r, c)]).sum()).collect()
}

/// Σ s_r·s_rᵀ over the runs' scores s_r = Xᵀe, and XᵀX between the coefficients of the design and the nuisance columns, the encoder's left
/// at zero.
fn meat_and_coupling(estimate: &Estimate) -> (Mat<f64>, Mat<f64>) {
    let lagged = estimate.lagged_commands();
    let courses = courses(&estimate.segments, &lagged, &estimate.calibration);
    let base = estimate.surfaces[0].lattice.columns();
    let (q, nuisances) = (estimate.design.coefficients(), Free::Delays.nuisances(estimate.logs.len()));
    // per segment, over the columns it touches: Xᵀ times residual, lag and dead time
    let parts: Vec<(Vec<u32>, [Vec<f64>; 3])> = courses
        .par_iter()
        .zip(&estimate.speeds)
        .map(|(course, speed)| {
            let s = course.segment;
            let surface = estimate.surface(s.gear);
            let mut local = whitened(course, speed, surface, &estimate.noise, Free::Delays);
            let width = local.columns.len();
            let touched = local.columns.iter().take_while(|c| (**c as usize) < base).count();
            let [lag, dead_time] = [nuisance::LAG, nuisance::DEAD_TIME + s.log]
                .map(|n| local.columns.iter().position(|c| *c as usize == base + n).unwrap_or(width - 1));
            let mut sums = [(); 3].map(|()| vec![0.0; touched]);
            for row in local.data.chunks_exact(width) {
                let fitted: f64 = row.iter().zip(&local.columns[..touched]).map(|(x, c)| x * surface.theta[*c as usize]).sum();
                for (sum, value) in sums.iter_mut().zip([row[width - 1] - fitted, row[lag], row[dead_time]]) {
                    sum.iter_mut().zip(row).for_each(|(s, x)| *s += x * value);
                }
            }
            local.columns.truncate(touched);
            (local.columns, sums)
        })
        .collect();
    let mut meat: Mat<f64> = Mat::zeros(q, q);
    let mut coupling: Mat<f64> = Mat::zeros(q, nuisances);
    for gear in &estimate.gears {
        let mut scores: BTreeMap<(usize, usize), BTreeMap<u32, f64>> = BTreeMap::new();
        let mut crossed: Mat<f64> = Mat::zeros(base, nuisances);
        for (course, (columns, [score, lag, dead_time])) in courses.iter().zip(&parts).filter(|(c, _)| c.segment.gear == *gear) {
            let run = scores.entry((course.segment.log, course.segment.run)).or_default();
            for (((c, s), l), d) in columns.iter().zip(score).zip(lag).zip(dead_time) {
                *run.entry(*c).or_insert(0.0) += s;
                crossed[(*c as usize, nuisance::LAG)] += l;
                crossed[(*c as usize, nuisance::DEAD_TIME + course.segment.log)] += d;
            }
        }
        let runs = scores.len() as f64;
        let mut squares: Mat<f64> = Mat::zeros(base, base);
        for run in scores.values() {
            for (a, x) in run {
                for (b, y) in run {
                    squares[(*b as usize, *a as usize)] += x * y;
                }
            }
        }
        let t = estimate.design.transform(*gear);
        coupling += t.transpose() * &crossed;
        if runs > 1.0 {
            // scores of a fitted model are shrunk: the usual small-sample factor
            meat += faer::Scale(runs / (runs - 1.0)) * (t.transpose() * &squares * t);
        }
    }
    (meat, coupling)
}
