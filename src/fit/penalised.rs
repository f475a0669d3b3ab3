//! Penalised least squares with the penalties chosen by the data.
//!
//! Minimises ‖y − Xβ‖² + Σ_j λ_j‖β_j‖². The penalties follow Fellner and Schall: λ_j ← edf_j / ‖β_j‖², with
//! edf_j = p_j − λ_j·tr[(XᵀX + Λ)⁻¹]_jj, which climbs the restricted likelihood (Wood & Fasiolo 2017, *A generalized Fellner-Schall
//! method*; Wood 2016).

use super::anova::{Block, Design};
use super::gram::Gram;
use super::regressors::nuisance;
use crate::map::Gear;
use faer::linalg::solvers::{DenseSolveCore, Solve};
use faer::{Col, Mat};

/// The normal equations in the coefficients of the design and the nuisance columns.
#[derive(Debug, Clone)]
pub(crate) struct System {
    /// XᵀX.
    pub(crate) matrix: Mat<f64>,
    /// Xᵀy.
    pub(crate) right: Col<f64>,
    /// yᵀy.
    pub(crate) square: f64,
    /// Readings.
    pub(crate) rows: usize,
    /// Coefficients of the design; the nuisance columns follow.
    pub(crate) design: usize,
}

/// The solution.
#[derive(Debug, Clone)]
pub(crate) struct Solution {
    /// Coefficients, the nuisance columns last.
    pub(crate) beta: Vec<f64>,
    /// (XᵀX + Λ)⁻¹: the posterior covariance.
    pub(crate) covariance: Mat<f64>,
    /// λ of each block.
    pub(crate) penalties: Vec<f64>,
    /// Effective degrees of freedom of each block.
    pub(crate) degrees: Vec<f64>,
    /// ‖y − Xβ‖².
    pub(crate) residual_square: f64,
    /// Whether the penalties settled.
    pub(crate) settled: bool,
}

/// What the penalties may be, relative to the mean diagonal of their block.
const PENALTY_RANGE: (f64, f64) = (1e-7, 1e9);
/// Largest change of a penalty's logarithm in one step.
const LARGEST_STEP: f64 = 3.0;

impl System {
    /// From the sums of each gear, over lattice columns, `nuisances` columns and the speed.
    pub(crate) fn new(design: &Design, grams: &[(Gear, &Gram)], nuisances: usize) -> Self {
        let q = design.coefficients();
        let size = q + nuisances;
        let mut system = Self { matrix: Mat::zeros(size, size), right: Col::zeros(size), square: 0.0, rows: 0, design: q };
        for (gear, gram) in grams {
            let t = design.transform(*gear);
            let base = t.nrows();
            let whole = faer::MatRef::from_row_major_slice(&gram.values, gram.size, gram.size);
            let lattice = whole.submatrix(0, 0, base, base);
            let half = t.transpose() * lattice;
            let full = &half * t;
            let cross = t.transpose() * whole.submatrix(0, base, base, gram.size - base);
            for a in 0..q {
                for b in 0..q {
                    system.matrix[(a, b)] += full[(a, b)];
                }
                for n in 0..nuisances {
                    system.matrix[(a, q + n)] += cross[(a, n)];
                    system.matrix[(q + n, a)] += cross[(a, n)];
                }
                system.right[a] += cross[(a, gram.size - 1 - base)];
            }
            for n in 0..nuisances {
                for m in 0..nuisances {
                    system.matrix[(q + n, q + m)] += whole[(base + n, base + m)];
                }
                system.right[q + n] += whole[(base + n, gram.size - 1)];
            }
            system.square += whole[(gram.size - 1, gram.size - 1)];
            system.rows += gram.rows;
        }
        system
    }

    /// Solves with the given start for the penalties (empty: from the data's scale), updating them at most `updates` times.
    ///
    /// `nuisance_prior_std` holds the prior standard deviation of each nuisance column. `None` when the equations are singular beyond
    /// repair (data that hold no information at all).
    pub(crate) fn solve(&self, blocks: &[Block], penalties: &[f64], updates: usize, nuisance_prior_std: &[f64]) -> Option<Solution> {
        let size = self.matrix.nrows();
        let scale: Vec<f64> =
            blocks.iter().map(|b| (b.range.clone().map(|k| self.matrix[(k, k)]).sum::<f64>() / b.range.len() as f64).max(1e-12)).collect();
        let mut penalties: Vec<f64> =
            if penalties.len() == blocks.len() { penalties.to_vec() } else { scale.iter().map(|s| 1e-2 * s).collect() };
        let mut solution = None;
        for round in 0..=updates {
            let mut h = self.matrix.clone();
            for (block, (penalty, scale)) in blocks.iter().zip(penalties.iter().zip(&scale)) {
                for k in block.range.clone() {
                    // a ridge relative to the data keeps columns without data from blowing up
                    h[(k, k)] += if block.penalised { *penalty } else { 1e-9 * (h[(k, k)] + scale) };
                }
            }
            for (n, std) in nuisance_prior_std.iter().enumerate() {
                h[(self.design + n, self.design + n)] += 1.0 / (std * std);
            }
            let factor = h.llt(faer::Side::Lower).ok()?;
            let beta_col = factor.solve(&self.right);
            let covariance = factor.inverse();
            let beta: Vec<f64> = (0..size).map(|k| beta_col[k]).collect();
            let mut degrees = Vec::with_capacity(blocks.len());
            let mut largest_change = 0.0f64;
            let mut next = penalties.clone();
            for (j, block) in blocks.iter().enumerate() {
                let p = block.range.len() as f64;
                if !block.penalised {
                    degrees.push(p);
                    continue;
                }
                let trace: f64 = block.range.clone().map(|k| covariance[(k, k)]).sum();
                let edf = (p - penalties[j] * trace).clamp(1e-6, p);
                degrees.push(edf);
                let norm: f64 = block.range.clone().map(|k| beta[k] * beta[k]).sum();
                let wanted = (edf / norm.max(1e-300)).clamp(PENALTY_RANGE.0 * scale[j], PENALTY_RANGE.1 * scale[j]);
                let change = (wanted / penalties[j]).ln().clamp(-LARGEST_STEP, LARGEST_STEP);
                // a block that has all but vanished may go on shrinking without moving the surface
                if edf > 0.01 {
                    largest_change = largest_change.max(change.abs());
                }
                next[j] = penalties[j] * change.exp();
            }
            let settled = largest_change < 0.05;
            let fitted: f64 = (0..size).map(|k| beta[k] * self.right[k]).sum();
            let hb = &self.matrix * &beta_col;
            let quadratic: f64 = (0..size).map(|k| beta[k] * hb[k]).sum();
            let residual_square = (self.square - 2.0 * fitted + quadratic).max(0.0);
            solution = Some(Solution { beta, covariance, penalties: penalties.clone(), degrees, residual_square, settled });
            if settled || round == updates {
                break;
            }
            penalties = next;
        }
        solution
    }
}

/// Prior standard deviations of the nuisance columns: lag and delays 20 ms (a step no larger is taken at once), scale 5 %.
pub(crate) fn nuisance_prior_std(logs: usize) -> Vec<f64> {
    let mut prior = vec![0.02; nuisance::DEAD_TIME + logs];
    prior[nuisance::ENCODER_SCALE] = 0.05;
    prior
}
