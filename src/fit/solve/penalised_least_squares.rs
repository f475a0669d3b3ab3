//! Penalised least squares with the penalties chosen by the data.
//!
//! Minimises ‖y − Xβ‖² + Σ_j λ_j‖β_j‖². The penalties follow Fellner and Schall: λ_j ← edf_j / ‖β_j‖², with
//! edf_j = p_j − λ_j·tr[(XᵀX + Λ)⁻¹]_jj, which climbs the restricted likelihood (Wood & Fasiolo 2017, *A generalized Fellner-Schall
//! method*; Wood 2016).

use crate::fit::nuisance;
use crate::fit::solve::normal_equations::Gram;
use crate::fit::surface::design::{CoefficientBlock, Design};
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
    /// Whether the penalties settled.
    pub(crate) settled: bool,
}

/// Most rounds in which penalties settle.
pub(crate) const SETTLING_ROUNDS: usize = 50;
/// First penalty, relative to the mean diagonal of its block: smooth, yet far from vanishing.
const FIRST_PENALTY: f64 = 1.0;
/// Least penalty, relative to the mean diagonal of its block.
const LEAST_PENALTY: f64 = 1e-7;
/// Effective degrees of freedom below which a block has vanished.
const VANISHED: f64 = 2e-3;
/// Largest change of a penalty's logarithm in one step.
const LARGEST_STEP: f64 = 3.0;

impl System {
    /// From the sums of each gear, over lattice columns, `nuisances` columns and the speed.
    pub(crate) fn new(design: &Design, grams: &[(Gear, &Gram)], nuisances: usize) -> Self {
        let q = design.coefficients();
        let size = q + nuisances;
        let mut system = Self { matrix: Mat::zeros(size, size), right: Col::zeros(size), design: q };
        for (gear, gram) in grams {
            let t = design.transform(*gear);
            let base = t.nrows();
            let whole = gram.whole();
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
        }
        system
    }

    /// Adds an observation of one nuisance column by itself: its value, with a standard error.
    pub(crate) fn observe(&mut self, nuisance: usize, value: f64, std_err: f64) {
        let (k, weight) = (self.design + nuisance, std_err.powi(-2));
        self.matrix[(k, k)] += weight;
        self.right[k] += weight * value;
    }

    /// These equations less those of some of the data.
    pub(crate) fn without(&self, part: &Self) -> Self {
        Self { matrix: &self.matrix - &part.matrix, right: &self.right - &part.right, design: self.design }
    }

    /// Solves with the given start for the penalties (0 or absent: from the data's scale; infinite: the block is left out), and updates
    /// them at most `updates` times.
    ///
    /// `nuisance_prior_std` holds the prior standard deviation of each nuisance column. `None` when the equations stay singular
    /// (data without any information).
    pub(crate) fn solve(
        &self,
        blocks: &[CoefficientBlock],
        penalties: &[f64],
        updates: usize,
        nuisance_prior_std: &[f64],
    ) -> Option<Solution> {
        let size = self.matrix.nrows();
        let scale: Vec<f64> =
            blocks.iter().map(|b| (b.range.clone().map(|k| self.matrix[(k, k)]).sum::<f64>() / b.range.len() as f64).max(1e-12)).collect();
        let start = |(j, scale): (usize, &f64)| penalties.get(j).copied().filter(|p| *p > 0.0).unwrap_or(FIRST_PENALTY * scale);
        let mut penalties: Vec<f64> = scale.iter().enumerate().map(start).collect();
        // Fellner-Schall converges slowly if a block vanishes: steps that keep their direction grow
        let mut pace = vec![(1.0f64, 0.0f64); blocks.len()];
        let mut solution = None;
        for round in 0..=updates {
            // a block that the data do not support has an infinite penalty: its coefficients are zero and leave the equations
            let active: Vec<usize> = blocks
                .iter()
                .zip(&penalties)
                .filter(|(_, penalty)| penalty.is_finite())
                .flat_map(|(b, _)| b.range.clone())
                .chain(self.design..size)
                .collect();
            let mut ridge = vec![0.0; size];
            for (block, (penalty, scale)) in blocks.iter().zip(penalties.iter().zip(&scale)) {
                for k in block.range.clone() {
                    // a ridge relative to the data keeps columns without data bounded
                    ridge[k] = if block.penalised { *penalty } else { 1e-9 * (self.matrix[(k, k)] + scale) };
                }
            }
            for (n, std) in nuisance_prior_std.iter().enumerate() {
                ridge[self.design + n] = 1.0 / (std * std);
            }
            let small = Mat::from_fn(active.len(), active.len(), |a, b| {
                self.matrix[(active[a], active[b])] + if a == b { ridge[active[a]] } else { 0.0 }
            });
            let factor = small.llt(faer::Side::Lower).ok()?;
            let right = Col::from_fn(active.len(), |a| self.right[active[a]]);
            let answer = factor.solve(&right);
            let inverse = factor.inverse();
            let mut beta = vec![0.0; size];
            let mut variance = vec![0.0; size];
            for (a, k) in active.iter().enumerate() {
                beta[*k] = answer[a];
                variance[*k] = inverse[(a, a)];
            }
            let mut degrees = Vec::with_capacity(blocks.len());
            let mut largest_change = 0.0f64;
            let mut next = penalties.clone();
            for (j, block) in blocks.iter().enumerate() {
                let p = block.range.len() as f64;
                if !block.penalised || !penalties[j].is_finite() {
                    degrees.push(if block.penalised { 0.0 } else { p });
                    continue;
                }
                let trace: f64 = block.range.clone().map(|k| variance[k]).sum();
                let edf = (p - penalties[j] * trace).clamp(1e-9, p);
                degrees.push(edf);
                let norm: f64 = block.range.clone().map(|k| beta[k] * beta[k]).sum();
                let wanted = (edf / norm.max(1e-300)).max(LEAST_PENALTY * scale[j]);
                let plain = (wanted / penalties[j]).ln();
                let (speed, before) = pace[j];
                pace[j] = (if plain * before > 0.0 { (1.6 * speed).min(10.0) } else { 1.0 }, plain);
                let change = (pace[j].0 * plain).clamp(-LARGEST_STEP, LARGEST_STEP);
                next[j] = penalties[j] * change.exp();
                let change = plain;
                if edf < VANISHED {
                    next[j] = f64::INFINITY;
                } else {
                    largest_change = largest_change.max(change.abs());
                }
            }
            let settled = largest_change < 0.05;
            if settled || round == updates {
                let mut covariance = Mat::zeros(size, size);
                for (a, k) in active.iter().enumerate() {
                    for (b, l) in active.iter().enumerate() {
                        covariance[(*k, *l)] = inverse[(a, b)];
                    }
                }
                solution = Some(Solution { beta, covariance, penalties: penalties.clone(), degrees, settled });
                break;
            }
            penalties = next;
        }
        solution
    }
}

/// Prior standard deviations of the nuisance columns: lag and delays 20 ms (a step no larger is taken at once), scale 5 %. Without a second
/// speed source the encoder counts as exact: its delay is part of the dead time, its scale part of the speed.
pub(crate) fn nuisance_prior_std(logs: usize, two_sources: bool) -> Vec<f64> {
    let mut prior = vec![0.02; nuisance::DEAD_TIME + logs];
    prior[nuisance::ENCODER_SCALE] = if two_sources { 0.05 } else { 1e-9 };
    if !two_sources {
        prior[nuisance::ENCODER_DELAY] = 1e-9;
    }
    prior
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn block(name: &'static str, range: std::ops::Range<usize>) -> CoefficientBlock {
        CoefficientBlock { name, range, penalised: true, physics: false }
    }

    /// A diagonal system of two blocks of ten coefficients and one nuisance column; `right` of each block and of the column.
    fn system(right: [f64; 3]) -> System {
        let at = |k: usize| right[(k / 10).min(2)];
        System { matrix: Mat::from_fn(21, 21, |a, b| if a == b { 4.0 } else { 0.0 }), right: Col::from_fn(21, at), design: 20 }
    }

    #[test]
    fn a_given_penalty_and_a_prior_are_ridges() {
        let blocks = [block("a", 0..10), block("b", 10..20)];
        let solution = system([8.0, 8.0, 8.0]).solve(&blocks, &[1.0, 4.0], 0, &[0.5]).unwrap();
        let expected = |ridge: f64| 8.0 / (4.0 + ridge);
        assert!((solution.beta[0] - expected(1.0)).abs() < 1e-12 && (solution.beta[10] - expected(4.0)).abs() < 1e-12);
        // 1/0.5² of the nuisance column
        assert!((solution.beta[20] - expected(4.0)).abs() < 1e-12 && (solution.covariance[(20, 20)] - 0.125).abs() < 1e-12);
        assert!((solution.degrees[0] - 8.0).abs() < 1e-9 && (solution.degrees[1] - 5.0).abs() < 1e-9, "{:?}", solution.degrees);
    }

    #[test]
    fn the_penalty_follows_the_data_and_a_block_without_a_signal_vanishes() {
        let blocks = [block("signal", 0..10), block("none", 10..20)];
        let solution = system([400.0, 0.01, 0.0]).solve(&blocks, &[], SETTLING_ROUNDS, &[1e-9]).unwrap();
        assert!(solution.settled);
        // coefficients of 100 with a standard error of a half: λ = edf / ‖β‖²
        assert!((solution.penalties[0] * 1e4 - 1.0).abs() < 0.1 && (solution.beta[0] - 100.0).abs() < 0.1, "{:?}", solution.penalties);
        assert!(solution.penalties[1] == f64::INFINITY && solution.beta[10..20].iter().all(|b| *b == 0.0), "{:?}", solution.penalties);
        assert!(solution.beta[20].abs() < 1e-9, "a column that is given stays");
    }

    #[test]
    fn equations_less_a_part_are_those_of_the_rest() {
        let whole = system([8.0, 2.0, 1.0]);
        let rest = whole.without(&system([3.0, 1.0, 1.0]));
        assert_eq!((rest.right[0], rest.right[10], rest.right[20], rest.matrix[(3, 3)]), (5.0, 1.0, 0.0, 0.0));
    }

    #[test]
    fn the_encoder_is_exact_without_a_second_source() {
        let (two, one) = (nuisance_prior_std(2, true), nuisance_prior_std(2, false));
        assert_eq!((two.len(), two[nuisance::ENCODER_SCALE]), (nuisance::DEAD_TIME + 2, 0.05));
        assert!(
            one[nuisance::ENCODER_SCALE] < 1e-6
                && one[nuisance::ENCODER_DELAY] < 1e-6
                && one[nuisance::DEAD_TIME] == two[nuisance::DEAD_TIME]
        );
    }
}
