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

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::guidance::route::clothoid_path::{ClothoidPiece, course};
    use crate::guidance::route::track::example::{WHEELBASE_M, state};

    #[test]
    fn the_curvature_is_that_of_the_equation() {
        let path = course(&[ClothoidPiece::straight(10.0)], WHEELBASE_M);
        let mut track = state(&path, 2.0, 0.1, 0.3, 0.5);
        // on a straight: κ = −1.0·0.1·sin 0.3/0.3 − 2.0·0.3 = −0.698507, δ = atan(0.9 κ) = −0.561212
        let angle = RearAxle::default().wheel_angle_rad(&track);
        assert!((angle - (0.9 * (-0.1 * 0.3_f64.sin() / 0.3 - 0.6)).atan()).abs() < 1e-12, "{angle}");
        // beside a path of curvature 0.2: κ = 0.2·cos 0.3/(1 − 0.02) − 0.1·sin 0.3/0.3 − 0.6 = −0.503540, δ = −0.425500
        track.matched.curvature_per_m = 0.2;
        let angle = RearAxle::default().wheel_angle_rad(&track);
        assert!((angle + 0.425_500_323_6).abs() < 1e-9, "{angle}");
        // other gains
        let mut law = RearAxle { offset_gain_per_m2: 4.0, heading_gain_per_m: 0.5 };
        let wanted = 0.2 * 0.3_f64.cos() / 0.98 - 0.4 * 0.3_f64.sin() / 0.3 - 0.15;
        assert!((law.wheel_angle_rad(&track) - (0.9 * wanted).atan()).abs() < 1e-12);
    }

    #[test]
    fn without_a_heading_error_sine_over_angle_is_one_and_inside_the_bends_centre_it_stays_finite() {
        let path = course(&[ClothoidPiece::straight(10.0)], WHEELBASE_M);
        let track = state(&path, 2.0, 0.1, 0.0, 0.5);
        assert!((RearAxle::default().wheel_angle_rad(&track) + 0.09_f64.atan()).abs() < 1e-12);
        let mut track = state(&path, 2.0, 5.0, 0.0, 0.5);
        track.matched.curvature_per_m = 0.2;
        // 1 − κ_r e = 0: taken as 0.1
        assert!((RearAxle::default().wheel_angle_rad(&track) - (0.9 * (2.0 - 5.0_f64)).atan()).abs() < 1e-12);
    }

    #[test]
    fn in_reverse_the_travel_frame_gives_the_same_angle() {
        let path = course(&[ClothoidPiece::straight(10.0).reversed()], WHEELBASE_M);
        let angle = RearAxle::default().wheel_angle_rad(&state(&path, -2.0, -0.1, 0.3, -0.5));
        assert!((angle - (0.9 * (-0.1 * 0.3_f64.sin() / 0.3 - 0.6)).atan()).abs() < 1e-9, "{angle}");
    }
}
