//! One run after the other, each the one that most reduces the cells' mean variance per second.
//!
//! With W the posterior covariance, R the rows of a run and M the sum of kᵀk over the cells' contrasts k, a run reduces the sum of the
//! variances by tr[(I + R·W·Rᵀ)⁻¹·(R·W)·M·(R·W)ᵀ] (Woodbury). The coordinates are those in which the covariance before the plan is the
//! identity, as many as needed: fewer than the design has coefficients. R·W and R·W·F of all runs, with F·Fᵀ = M, are kept, and updated at
//! low rank after each choice.

use crate::map::PlannedRun;
use crate::plan::information::{Information, Model, TorqueCell, pivoted_root};
use faer::linalg::matmul::matmul;
use faer::linalg::solvers::Solve;
use faer::{Accum, Mat, MatRef, Par};
use std::ops::Range;

/// Share of the covariance's trace, in units of the surface, that the coordinates may leave out.
const LEFT_OUT: f64 = 1e-6;
/// The same of the criterion.
const CRITERION_LEFT_OUT: f64 = 1e-5;

/// A candidate's rows in the stack.
struct CandidateRun {
    rows: Range<usize>,
    seconds: f64,
}

/// The state of the choice.
pub(crate) struct Greedy {
    runs: Vec<CandidateRun>,
    /// R of all candidates, stacked.
    rows: Mat<f64>,
    /// W.
    covariance: Mat<f64>,
    /// R·W.
    spread: Mat<f64>,
    /// R·W·F.
    reach: Mat<f64>,
    /// One column per cell.
    contrasts: Mat<f64>,
    /// M.
    criterion: Mat<f64>,
}

fn product(a: MatRef<f64>, b: MatRef<f64>) -> Mat<f64> {
    let mut c = Mat::zeros(a.nrows(), b.ncols());
    matmul(c.as_mut(), Accum::Replace, a, b, 1.0, Par::Seq);
    c
}

impl Greedy {
    pub(crate) fn new(model: &Model, covariance: &Mat<f64>, candidates: &[(PlannedRun, f64, Information)], cells: &[TorqueCell]) -> Self {
        let q = model.size();
        // coordinates: the rows of L with LᵀL = C, coefficients measured by their effect on the surface
        let unit: Vec<f64> = model.unit_mps2();
        let scaled = Mat::from_fn(q, q, |a, b| unit[a] * covariance[(a, b)] * unit[b]);
        let root = pivoted_root(&scaled, q, LEFT_OUT);
        let root = Mat::from_fn(root.nrows(), q, |r, c| root[(r, c)] / unit[c]);
        let size = root.nrows();
        let mut rows = Mat::zeros(candidates.iter().map(|c| c.2.nrows()).sum(), size);
        let mut runs = Vec::new();
        let mut at = 0;
        for (_, seconds, information) in candidates {
            let n = information.nrows();
            rows.submatrix_mut(at, 0, n, size).copy_from(product(information.as_ref(), root.transpose()));
            runs.push(CandidateRun { rows: at..at + n, seconds: *seconds });
            at += n;
        }
        let contrasts = product(root.as_ref(), Mat::from_fn(q, cells.len(), |r, c| cells[c].contrast[r]).as_ref());
        let criterion = product(contrasts.as_ref(), contrasts.transpose());
        let factor = pivoted_root(&criterion, size, CRITERION_LEFT_OUT);
        let reach = product(rows.as_ref(), factor.transpose());
        Self { runs, spread: rows.clone(), rows, covariance: Mat::identity(size, size), reach, contrasts, criterion }
    }

    /// Root mean square standard error of the cells' torques [N·m].
    pub(crate) fn std_err_nm(&self) -> f64 {
        let size = self.covariance.nrows();
        let sum: f64 = (0..size).map(|a| (0..size).map(|b| self.covariance[(a, b)] * self.criterion[(a, b)]).sum::<f64>()).sum();
        (sum / self.contrasts.ncols().max(1) as f64).max(0.0).sqrt()
    }

    /// Standard error of each cell's torque [N·m].
    pub(crate) fn std_errs_nm(&self) -> Vec<f64> {
        let moved = product(self.covariance.as_ref(), self.contrasts.as_ref());
        let variance = |c: usize| (0..moved.nrows()).map(|r| moved[(r, c)] * self.contrasts[(r, c)]).sum::<f64>();
        (0..moved.ncols()).map(|c| variance(c).max(0.0).sqrt()).collect()
    }

    /// I + R·W·Rᵀ of a run, solved for the rows of `right`.
    fn solved(&self, run: &CandidateRun, right: &Mat<f64>) -> Option<Mat<f64>> {
        let n = run.rows.len();
        let mut inner = product(self.spread.subrows(run.rows.start, n), self.rows.subrows(run.rows.start, n).transpose());
        for k in 0..n {
            inner[(k, k)] += 1.0;
        }
        // symmetric but for rounding
        let inner = Mat::from_fn(n, n, |a, b| 0.5 * (inner[(a, b)] + inner[(b, a)]));
        Some(inner.llt(faer::Side::Lower).ok()?.solve(right))
    }

    /// Reduction of the sum of the variances by a run [(N·m)²].
    fn decrease(&self, run: &CandidateRun) -> f64 {
        let n = run.rows.len();
        let reach = self.reach.subrows(run.rows.start, n);
        let square = product(reach, reach.transpose());
        self.solved(run, &square).map_or(0.0, |m| (0..n).map(|k| m[(k, k)]).sum())
    }

    /// The most useful run per second of those that take at most `left_s`; of equal ones the first.
    pub(crate) fn best(&self, left_s: f64) -> Option<usize> {
        let mut best: Option<(usize, f64)> = None;
        for (k, run) in self.runs.iter().enumerate().filter(|(_, r)| !r.rows.is_empty() && r.seconds <= left_s) {
            let worth = self.decrease(run) / run.seconds;
            if worth > 0.0 && best.is_none_or(|(_, most)| worth > most) {
                best = Some((k, worth));
            }
        }
        best.map(|(k, _)| k)
    }

    /// Reduction of each cell's variance by a run [(N·m)²].
    fn decreases(&self, run: &CandidateRun) -> Vec<f64> {
        let n = run.rows.len();
        let by_cell = product(self.spread.subrows(run.rows.start, n), self.contrasts.as_ref());
        let Some(solved) = self.solved(run, &by_cell) else { return vec![0.0; by_cell.ncols()] };
        (0..by_cell.ncols()).map(|c| (0..n).map(|r| by_cell[(r, c)] * solved[(r, c)]).sum()).collect()
    }

    /// Counts a run as driven.
    pub(crate) fn take(&mut self, index: usize) {
        let run = &self.runs[index];
        let (from, n) = (run.rows.start, run.rows.len());
        let cross = product(self.spread.as_ref(), self.rows.subrows(from, n).transpose());
        let (spread, reach) = (self.spread.subrows(from, n).to_owned(), self.reach.subrows(from, n).to_owned());
        let (Some(by_spread), Some(by_reach)) = (self.solved(run, &spread), self.solved(run, &reach)) else { return };
        matmul(self.covariance.as_mut(), Accum::Add, spread.transpose(), by_spread.as_ref(), -1.0, Par::Seq);
        matmul(self.spread.as_mut(), Accum::Add, cross.as_ref(), by_spread.as_ref(), -1.0, Par::Seq);
        matmul(self.reach.as_mut(), Accum::Add, cross.as_ref(), by_reach.as_ref(), -1.0, Par::Seq);
    }

    /// The cells that gain most from a run, and their standard error now.
    pub(crate) fn reason(&self, index: usize, cells: &[TorqueCell]) -> String {
        let decreases = self.decreases(&self.runs[index]);
        let most = decreases.iter().fold(0.0f64, |m, d| m.max(*d));
        let best = decreases.iter().position(|d| *d >= most).unwrap_or(0);
        let gear = cells[best].gear;
        let own: Vec<usize> = (0..cells.len()).filter(|k| cells[*k].gear == gear && decreases[*k] >= 0.5 * most).collect();
        let range = |f: &dyn Fn(&TorqueCell) -> f64| {
            own.iter().map(|k| f(&cells[*k])).fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)))
        };
        let (v, u) = (range(&|c| c.speed_mps), range(&|c| c.torque_nm));
        let errors = self.std_errs_nm();
        let known = (own.iter().map(|k| errors[*k].powi(2)).sum::<f64>() / own.len().max(1) as f64).sqrt();
        format!("{gear} cells {:.2} to {:.2} m/s, {:.0} to {:.0} N·m have a standard error of {known:.2} N·m", v.0, v.1, u.0, u.1)
    }
}
