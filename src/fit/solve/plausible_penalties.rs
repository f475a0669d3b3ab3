//! The covariance under penalties that the data do not rule out.
//!
//! A term of the physics form that the data do not ask for gets an infinite penalty and counts as exactly zero. That is the best estimate,
//! and a wrong error: the data are as well explained when the term is as large as its own standard error. With a coefficient of zero and a
//! prior variance of r times the variance s² that the data alone give it, −2·ln L rises by ln(1 + r), and for p coefficients by p times
//! that; a rise of one is one standard error of the profile likelihood. So each penalty is bounded to λ = 1/(r·s²) with r = e^(1/p) − 1
//! (Kass & Steffey 1989, *Approximate Bayesian inference in conditionally independent hierarchical models*: what is uncertain of the prior
//! belongs to the posterior).

use crate::fit::solve::penalised_least_squares::System;
use crate::fit::surface::design::CoefficientBlock;
use faer::Mat;

/// Penalty of a free block, relative to the mean diagonal of its columns.
const FREE: f64 = 1e-6;

/// (XᵀX + Λ)⁻¹ with the penalties of the physics form's terms bounded by what is plausible. `None` when the equations are singular.
pub(crate) fn plausible_covariance(
    system: &System,
    blocks: &[CoefficientBlock],
    penalties: &[f64],
    nuisance_prior_std: &[f64],
) -> Option<Mat<f64>> {
    let mut plausible = penalties.to_vec();
    for (j, block) in blocks.iter().enumerate().filter(|(_, b)| b.physics && b.penalised) {
        let count = block.range.len() as f64;
        let free = FREE * block.range.clone().map(|k| system.matrix[(k, k)]).sum::<f64>() / count;
        let mut alone = penalties.to_vec();
        alone[j] = free.max(f64::MIN_POSITIVE);
        let covariance = system.solve(blocks, &alone, 0, nuisance_prior_std)?.covariance;
        let variance = block.range.clone().map(|k| covariance[(k, k)]).sum::<f64>() / count;
        let bound = 1.0 / (((1.0 / count).exp() - 1.0) * variance);
        plausible[j] = penalties[j].min(bound);
    }
    Some(system.solve(blocks, &plausible, 0, nuisance_prior_std)?.covariance)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use faer::{Col, Mat};

    #[test]
    fn a_term_without_evidence_adds_what_the_likelihood_leaves_open() {
        // one free coefficient and one term of the form, each known to a variance of 1/4 by itself
        let system = System { matrix: Mat::from_fn(2, 2, |a, b| if a == b { 4.0 } else { 0.0 }), right: Col::zeros(2), design: 2 };
        let block = |name, range, penalised| CoefficientBlock { name, range, penalised, physics: true };
        let blocks = [block("physics form", 0..1, false), block("drive efficiency", 1..2, true)];
        let covariance = plausible_covariance(&system, &blocks, &[0.0, f64::INFINITY], &[]).unwrap();
        // r/(1 + r) of it with r = e − 1
        let share = 1.0 - (-1f64).exp();
        assert!((covariance[(1, 1)] - 0.25 * share).abs() < 1e-4, "{}", covariance[(1, 1)]);
        assert!((covariance[(0, 0)] - 0.25).abs() < 1e-4);
        // a penalty that is smaller already stays
        let known = plausible_covariance(&system, &blocks, &[0.0, 0.1], &[]).unwrap();
        assert!((known[(1, 1)] - 1.0 / 4.1).abs() < 1e-9);
    }
}
