//! The rounds of the estimator: a first guess, then speeds, noise, cuts, surface and delays, each from the others, until nothing moves.

pub(crate) mod convergence;
pub(crate) mod cross_validation;
pub(crate) mod delay_grid;
pub(crate) mod estimate;
pub(crate) mod initial_guess;
pub(crate) mod outliers;
pub(crate) mod sampling;
pub(crate) mod search;
