//! Rear-axle feedback: curvature from the rear axle's offset and heading error.
//!
//! `κ = κ_r cos ψ/(1 − κ_r e) − k_e e sin ψ/ψ − k_ψ ψ`, `δ = atan(L κ)`; per metre, so that the path back onto the line does not depend on speed.
//! Source: Samson (1992), *Path following and time-varying feedback stabilization of a wheeled mobile robot*, ICARCV; as in Paden et al. (2016),
//! *A Survey of Motion Planning and Control Techniques for Self-Driving Urban Vehicles*, IEEE T-IV 1(1), eq. (13), whose gains are k_θ|v| and k_e v.

use crate::control::numeric::{atan, sin_cos};
use crate::guidance::route::track::{Law, TrackState};
use serde::Serialize;

/// Its settings.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub(crate) struct RearAxle {
    /// Gain k_e of the offset [1/m²]. Default 1.0: back onto the line within some 3 m.
    pub offset_gain_per_m2: f64,
    /// Gain k_ψ of the heading error [1/m]. Default 2.0, critical damping.
    pub heading_gain_per_m: f64,
}

impl Default for RearAxle {
    fn default() -> Self {
        Self { offset_gain_per_m2: 1.0, heading_gain_per_m: 2.0 }
    }
}

impl Law for RearAxle {
    fn wheel_angle_rad(&mut self, track: &TrackState<'_>) -> f64 {
        let (e, psi, curvature) = (track.offset.lateral_m, track.offset.heading_rad, track.matched.curvature_per_m);
        let (sin, cos) = sin_cos(psi);
        let sinc = if psi.abs() < 1e-6 { 1.0 } else { sin / psi };
        let along = (1.0 - curvature * e).max(0.1);
        let wanted = curvature * cos / along - self.offset_gain_per_m2 * e * sinc - self.heading_gain_per_m * psi;
        atan(track.wheelbase_m * wanted)
    }
}
