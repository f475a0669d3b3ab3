//! The physics form with a share of the surface: the mixture and its uncertainty.

use crate::fit::solve::penalised_least_squares::{SETTLING_ROUNDS, Solution, System};
use crate::fit::surface::design::CoefficientBlock;

/// The mixture.
#[derive(Debug, Clone)]
pub(crate) struct Stacked {
    /// Coefficients, covariance and degrees of freedom, mixed. Penalties are the surface's, if any of it is used.
    pub(crate) solution: Solution,
    /// √(1 − w) of the difference between surface and physics form, in the coefficients, where w is the share: w·(1 − w) of its square is
    /// between the two, (1 − w)² is the distance of the mixture from the surface.
    pub(crate) doubt: Vec<f64>,
    /// The pull of each penalised block's penalty.
    pub(crate) pulls: Vec<Pull>,
}

/// The pull of a block's penalty on the coefficients.
#[derive(Debug, Clone)]
pub(crate) struct Pull {
    /// H⁻¹·λβ of the block: the effect of its penalty on the coefficients.
    pub(crate) of: Vec<f64>,
    /// Relative variance of its penalty: λ is a ratio of edf squares to their number.
    pub(crate) relative_variance: f64,
}

impl Stacked {
    /// Physics form plus a `share` of the deviations of `surface`, a solution of `system`. `None` when the form is singular.
    pub(crate) fn new(
        system: &System,
        surface: Solution,
        blocks: &[CoefficientBlock],
        share: f64,
        nuisance_prior_std: &[f64],
    ) -> Option<Self> {
        let of_surface = pulls(&surface, blocks);
        if share >= 1.0 {
            return Some(Self { doubt: vec![0.0; surface.beta.len()], solution: surface, pulls: of_surface });
        }
        let physics = system.solve(blocks, &physics_alone(blocks), SETTLING_ROUNDS, nuisance_prior_std)?;
        let of_both = |(physics, surface): (Pull, Pull)| Pull { of: mixed(&physics.of, &surface.of, share), ..surface };
        let pulls = pulls(&physics, blocks).into_iter().zip(of_surface).map(of_both).collect();
        let doubt = surface.beta.iter().zip(&physics.beta).map(|(s, p)| (1.0 - share).sqrt() * (s - p)).collect();
        let solution = Solution {
            beta: mixed(&physics.beta, &surface.beta, share),
            covariance: &physics.covariance + faer::Scale(share) * (&surface.covariance - &physics.covariance),
            degrees: mixed(&physics.degrees, &surface.degrees, share),
            penalties: if share > 0.0 { surface.penalties } else { physics.penalties },
            settled: physics.settled && surface.settled,
        };
        Some(Self { solution, doubt, pulls })
    }
}

/// Start of the penalties for the physics form alone: from the data's scale, infinite elsewhere.
pub(crate) fn physics_alone(blocks: &[CoefficientBlock]) -> Vec<f64> {
    blocks.iter().map(|block| if block.physics { 0.0 } else { f64::INFINITY }).collect()
}

/// `from`, a share of the way towards `to`.
pub(crate) fn mixed(from: &[f64], to: &[f64], share: f64) -> Vec<f64> {
    from.iter().zip(to).map(|(from, to)| from + share * (to - from)).collect()
}

/// The pull of each penalised block; zero where it has vanished.
fn pulls(solution: &Solution, blocks: &[CoefficientBlock]) -> Vec<Pull> {
    let size = solution.beta.len();
    let pull = |(j, block): (usize, &CoefficientBlock)| {
        let penalty = if solution.penalties[j].is_finite() { solution.penalties[j] } else { 0.0 };
        let of = |a| block.range.clone().map(|k| solution.covariance[(a, k)] * penalty * solution.beta[k]).sum();
        Pull { of: (0..size).map(of).collect(), relative_variance: 2.0 / solution.degrees[j].max(1.0) }
    };
    blocks.iter().enumerate().filter(|(_, b)| b.penalised).map(pull).collect()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use faer::{Col, Mat};

    /// One free coefficient and two penalised ones that the data support.
    fn system() -> (System, Vec<CoefficientBlock>) {
        let matrix = Mat::from_fn(3, 3, |a, b| if a == b { 400.0 } else { 40.0 });
        let right = Col::from_fn(3, |k| [800.0, 300.0, -200.0][k]);
        let block = |name, range, physics: bool| CoefficientBlock { name, range, penalised: !physics, physics };
        (System { matrix, right, design: 3 }, vec![block("physics form", 0..1, true), block("f(V)", 1..3, false)])
    }

    #[test]
    fn a_share_lies_between_the_form_and_the_surface_and_the_doubt_fades_with_it() {
        let (system, blocks) = system();
        let surface = system.solve(&blocks, &[], SETTLING_ROUNDS, &[]).unwrap();
        let stacked = |share| Stacked::new(&system, surface.clone(), &blocks, share, &[]).unwrap();
        let (none, half, all) = (stacked(0.0), stacked(0.5), stacked(1.0));
        assert_eq!(all.solution.beta, surface.beta);
        assert!(none.solution.beta[1..].iter().all(|b| *b == 0.0) && surface.beta[1..].iter().all(|b| b.abs() > 0.1));
        for k in 0..3 {
            let (form, whole) = (none.solution.beta[k], surface.beta[k]);
            assert!((half.solution.beta[k] - 0.5 * (form + whole)).abs() < 1e-12);
            assert!((none.doubt[k] - (whole - form)).abs() < 1e-12 && all.doubt[k] == 0.0);
            assert!((half.doubt[k].powi(2) - 0.5 * (whole - form).powi(2)).abs() < 1e-12);
        }
        // a skipped block has no pull
        assert!(none.pulls[0].of.iter().all(|p| *p == 0.0) && all.pulls[0].of.iter().any(|p| *p != 0.0));
    }
}
