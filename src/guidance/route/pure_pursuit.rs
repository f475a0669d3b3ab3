//! Pure pursuit: the circle through the rear axle, tangent to the direction of travel, through a goal point ahead on the path.
//!
//! `δ = atan(2 L sin α / d)`, α the direction of the goal seen from the vehicle, d its distance. Source: Coulter (1992), *Implementation of the
//! Pure Pursuit Path Tracking Algorithm*, CMU-RI-TR-92-01; the look-ahead that grows with speed: Snider (2009), *Automatic Steering Methods for
//! Autonomous Automobile Path Tracking*, CMU-RI-TR-09-08, §2.2.

use crate::control::numeric::{atan, atan2, sin_cos};
use crate::guidance::route::path_position::hypot;
use crate::guidance::route::track::{Law, TrackState};
use serde::Serialize;

/// Its settings.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub(crate) struct PurePursuit {
    /// Look-ahead distance at standstill [m]. Default 0.6.
    pub look_ahead_m: f64,
    /// Its increase per speed [s]. Default 0.6.
    pub look_ahead_s: f64,
}

impl Default for PurePursuit {
    fn default() -> Self {
        Self { look_ahead_m: 0.6, look_ahead_s: 0.6 }
    }
}

impl Law for PurePursuit {
    fn wheel_angle_rad(&mut self, track: &TrackState<'_>) -> f64 {
        let ahead_m = self.look_ahead_m + self.look_ahead_s * track.speed_mps;
        let goal = track.leg.at(track.matched.s_m + ahead_m, track.index);
        let (dx, dy) = (goal.x_m - track.pose.x_m, goal.y_m - track.pose.y_m);
        let (sin, _) = sin_cos(atan2(dy, dx) - track.pose.heading_rad);
        atan(2.0 * track.wheelbase_m * sin / hypot(dx, dy).max(0.1))
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::guidance::route::clothoid_path::{ClothoidPiece, course};
    use crate::guidance::route::track::example::{WHEELBASE_M, state};

    #[test]
    fn the_angle_is_that_of_the_circle_through_the_goal() {
        let path = course(&[ClothoidPiece::straight(10.0)], WHEELBASE_M);
        // matched at x = 2 m, the goal 0.6 + 0.6·0.5 = 0.9 m further: (2.9, 0). From (2, 0.3): d = √(0.9² + 0.3²) = 0.948683 m,
        // α = atan2(−0.3, 0.9) − 0.2 = −0.521751, so δ = atan(2·0.9·sin α/d) = −0.757469
        let angle = PurePursuit::default().wheel_angle_rad(&state(&path, 2.0, 0.3, 0.2, 0.5));
        assert!((angle + 0.757_468_540_7).abs() < 1e-9, "{angle}");
        // at standstill the goal is 0.6 m ahead: α = −0.4636476 − 0.2, d = 0.6708204, δ = −1.027134
        let resting = PurePursuit::default().wheel_angle_rad(&state(&path, 2.0, 0.3, 0.2, 0.0));
        assert!((resting + (1.8_f64 * 0.663_647_609_f64.sin() / 0.670_820_393).atan()).abs() < 1e-8, "{resting}");
    }

    #[test]
    fn on_a_circle_it_is_the_circles_own_angle() {
        let path = course(&[ClothoidPiece::bend(12.0, 0.25, 0.25)], WHEELBASE_M);
        // the chord's angle is κ s/2 and its length 2 sin(κ s/2)/κ: δ = atan(L κ), whatever the look-ahead; 1e-4 for poses 0.05 m apart
        let (s, c) = (0.25_f64 * 4.0).sin_cos();
        let angle = PurePursuit::default().wheel_angle_rad(&state(&path, 4.0 * s, 4.0 * (1.0 - c), 1.0, 0.5));
        assert!((angle - (0.9_f64 * 0.25).atan()).abs() < 1e-3, "{angle}");
    }

    #[test]
    fn in_reverse_the_travel_frame_gives_the_same_angle() {
        let path = course(&[ClothoidPiece::straight(10.0).reversed()], WHEELBASE_M);
        // the first state turned by 180°: at (−2, −0.3), heading 0.2, rolling backwards
        let angle = PurePursuit::default().wheel_angle_rad(&state(&path, -2.0, -0.3, 0.2, -0.5));
        assert!((angle + 0.757_468_540_7).abs() < 1e-9, "{angle}");
    }
}
