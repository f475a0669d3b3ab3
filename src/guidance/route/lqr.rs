//! LQR: the state feedback that minimises Σ q_e e² + q_ψ ψ² + r u² over the linear error model; one step is one piece of distance.
//!
//! `e⁺ = e + h ψ`, `ψ⁺ = ψ + h u`, u the curvature beyond the path's own, h a step of distance; `δ = atan(L (κ_r − K·(e, ψ)))`. K comes
//! from the discrete algebraic Riccati equation by iteration to its fixed point. In distance instead of time the gains do not depend on
//! speed. Source: Anderson & Moore (1990), *Optimal Control: Linear Quadratic Methods*, ch. 3; for path tracking Snider (2009),
//! CMU-RI-TR-09-08, §4.

use crate::control::numeric::atan;
use crate::guidance::route::track::{Law, TrackState};
use serde::Serialize;

/// Its settings.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub(crate) struct Lqr {
    /// Weight of the offset [1/m²]. Default 1.
    pub offset_weight: f64,
    /// Weight of the heading error. Default 1.
    pub heading_weight: f64,
    /// Weight of the added curvature [m²]. Default 1: back onto the line within some 3 m.
    pub curvature_weight: f64,
    /// Step of distance [m]. Default 0.02.
    pub step_m: f64,
}

impl Default for Lqr {
    fn default() -> Self {
        Self { offset_weight: 1.0, heading_weight: 1.0, curvature_weight: 1.0, step_m: 0.02 }
    }
}

/// Most iterations of the Riccati equation; with the defaults 500 reach its fixed point to 1e-9.
const ITERATIONS: usize = 4000;

impl Lqr {
    /// The gains K = (k_e [1/m²], k_ψ [1/m]).
    pub(crate) fn gains(&self) -> [f64; 2] {
        let h = self.step_m;
        // P symmetric: [a b; b c]; A = [1 h; 0 1], B = [0; h]; the costs are densities over distance
        let (q1, q2, r) = (self.offset_weight * h, self.heading_weight * h, self.curvature_weight * h);
        let (mut a, mut b, mut c) = (q1, 0.0, q2);
        let mut gains = [0.0; 2];
        for _ in 0..ITERATIONS {
            let s = r + h * h * c;
            // K = (r + BᵀPB)⁻¹ BᵀPA, with BᵀP = h·[b c] and A
            let next = [h * b / s, h * (h * b + c) / s];
            // P⁺ = Q + AᵀP(A − BK)
            let (m11, m12) = (a - b * h * next[0], a * h + b * (1.0 - h * next[1]));
            let (m21, m22) = (b - c * h * next[0], b * h + c * (1.0 - h * next[1]));
            (a, b, c) = (q1 + m11, 0.5 * (m12 + h * m11 + m21), q2 + h * m12 + m22);
            let change = (next[0] - gains[0]).abs() + (next[1] - gains[1]).abs();
            gains = next;
            if change < 1e-10 {
                break;
            }
        }
        gains
    }
}

/// The law with its gains, which are computed once.
#[derive(Debug, Clone, Copy)]
pub(crate) struct LqrLaw {
    gains: [f64; 2],
}

impl LqrLaw {
    pub(crate) fn new(settings: &Lqr) -> Self {
        Self { gains: settings.gains() }
    }
}

impl Law for LqrLaw {
    fn wheel_angle_rad(&mut self, track: &TrackState<'_>) -> f64 {
        let [k_e, k_psi] = self.gains;
        let (e, psi, curvature) = (track.offset.lateral_m, track.offset.heading_rad, track.matched.curvature_per_m);
        atan(track.wheelbase_m * (curvature - k_e * e - k_psi * psi))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_gains_are_those_of_the_continuous_solution_for_a_small_step() {
        // e'' = u with weights (q, p, r): K = (√(q/r), √(p/r + 2 √(q/r)))
        let law = Lqr { offset_weight: 4.0, heading_weight: 1.0, curvature_weight: 1.0, step_m: 0.005 };
        let [k_e, k_psi] = law.gains();
        assert!((k_e - 2.0).abs() < 0.03 && (k_psi - 5.0_f64.sqrt()).abs() < 0.03, "{k_e} {k_psi}");
    }
}
