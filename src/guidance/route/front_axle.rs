//! Front-axle feedback (Stanley): the wheel points along the path, plus an angle toward it that depends on the front axle's offset.
//!
//! `δ = −ψ − atan(k e_f/(k_s + v))`, ψ the heading error and e_f the front axle's offset to the left. Source: Hoffmann, Tomlin, Montemerlo &
//! Thrun (2007), *Autonomous Automobile Trajectory Tracking for Off-Road Driving*, American Control Conference, eq. (5) and (9). In reverse the
//! front axle trails and feedback of its offset is unstable: there the rear axle's offset is used, with a separate gain, and damping
//! ½·√(v/(k L)) in the linear case.

use crate::control::numeric::atan;
use crate::guidance::route::track::{Law, TrackState};
use serde::Serialize;

/// Its settings.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub(crate) struct FrontAxle {
    /// Gain k [1/s]. Default 1.0.
    pub gain_per_s: f64,
    /// Gain in reverse. Default 0.3.
    pub reverse_gain_per_s: f64,
    /// Softening speed k_s [m/s]. Default 0.3.
    pub softening_mps: f64,
}

impl Default for FrontAxle {
    fn default() -> Self {
        Self { gain_per_s: 1.0, reverse_gain_per_s: 0.3, softening_mps: 0.3 }
    }
}

impl Law for FrontAxle {
    fn wheel_angle_rad(&mut self, track: &TrackState<'_>) -> f64 {
        let (offset, gain, ahead_rad) = if track.is_reverse() {
            // the steered wheel is not at the rear axle: the path's curvature must be fed forward
            (track.offset, self.reverse_gain_per_s, atan(track.wheelbase_m * track.matched.curvature_per_m))
        } else {
            (track.front_offset(), self.gain_per_s, 0.0)
        };
        ahead_rad - offset.heading_rad - atan(gain * offset.lateral_m / (self.softening_mps + track.speed_mps))
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::guidance::route::clothoid_path::{ClothoidPiece, course};
    use crate::guidance::route::track::example::{WHEELBASE_M, state};

    #[test]
    fn forward_the_front_axles_offset_and_the_heading_error_are_fed_back() {
        let path = course(&[ClothoidPiece::straight(10.0)], WHEELBASE_M);
        // e_f = 0.3 + 0.9·sin 0.2 = 0.478802 m: δ = −0.2 − atan(1.0·0.478802/(0.3 + 0.5)) = −0.739318
        let angle = FrontAxle::default().wheel_angle_rad(&state(&path, 2.0, 0.3, 0.2, 0.5));
        assert!((angle + 0.739_318_035_9).abs() < 1e-9, "{angle}");
        // on the line, only the heading: the front axle is 0.9·sin 0.1 off
        let turned = FrontAxle::default().wheel_angle_rad(&state(&path, 2.0, 0.0, 0.1, 0.5));
        assert!((turned + 0.1 + (0.9 * 0.1_f64.sin() / 0.8).atan()).abs() < 1e-12, "{turned}");
        // the gain and the softening speed are where the equation has them
        let mut law = FrontAxle { gain_per_s: 2.0, softening_mps: 0.5, ..FrontAxle::default() };
        let angle = law.wheel_angle_rad(&state(&path, 2.0, 0.3, 0.2, 0.5));
        assert!((angle + 0.2 + (2.0 * (0.3 + 0.9 * 0.2_f64.sin())).atan()).abs() < 1e-12, "{angle}");
    }

    #[test]
    fn in_reverse_it_is_the_rear_axles_offset_with_its_own_gain_and_the_curvature_fed_forward() {
        let path = course(&[ClothoidPiece::straight(10.0).reversed()], WHEELBASE_M);
        // at (−2, −0.2) with heading 0.1: in the travel frame 0.2 m to the left, turned by 0.1: δ = −0.1 − atan(0.3·0.2/0.8) = −0.174860
        let angle = FrontAxle::default().wheel_angle_rad(&state(&path, -2.0, -0.2, 0.1, -0.5));
        assert!((angle + 0.174_859_847_7).abs() < 1e-9, "{angle}");
        let circle = course(&[ClothoidPiece::bend(8.0, 0.25, 0.25).reversed()], WHEELBASE_M);
        let track = state(&circle, 0.0, 0.0, 0.0, -0.5);
        let on_it = FrontAxle::default().wheel_angle_rad(&track);
        // in the travel frame the curvature is −0.25; 1e-2 for the first piece, a chord of 0.05 m
        assert!((on_it + (0.9_f64 * 0.25).atan()).abs() < 1e-2, "{on_it}");
    }
}
