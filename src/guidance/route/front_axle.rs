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
