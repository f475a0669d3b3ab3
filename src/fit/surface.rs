//! The acceleration surface a(v, τ): B-splines, the lattice of their coefficients, and the physics form with what is left beyond it.

pub(crate) mod design;
pub(crate) mod lattice;
pub(crate) mod spline;
