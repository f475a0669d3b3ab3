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
