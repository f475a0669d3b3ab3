//! From sums to coefficients: the normal equations, their penalties, the share of the lattice, and the slope along torque.

pub(crate) mod monotone;
pub(crate) mod normal_equations;
pub(crate) mod penalised_least_squares;
pub(crate) mod plausible_penalties;
pub(crate) mod shrinkage;
pub(crate) mod stribeck_speed;
