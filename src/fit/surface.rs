//! The acceleration surface a(v, τ): B-splines, the lattice of their coefficients, and the physics form with the deviations from it.

pub(crate) mod design;
pub(crate) mod lattice;
pub(crate) mod spline;
