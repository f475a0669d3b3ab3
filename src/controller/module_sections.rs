//! The sections of a controller file about failures, the steering, and the speed loops of manoeuvres.

use crate::controller::or_word::{Coast, OfVehicle, Or};
use crate::controller::setting::Setting;
use serde::{Deserialize, Serialize};

/// Times and limits of the longitudinal module.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(crate) struct MonitoringKeys {
    /// Standing this long after the end is rest [s].
    pub(crate) rest_s: f64,
    /// Standing this long short of the end is a failure [s].
    pub(crate) stood_short_s: f64,
    /// No speed reading for this long is a failure [s].
    pub(crate) speed_lost_s: f64,
    /// Longest wait for the gear [s].
    pub(crate) gear_s: f64,
    /// Longest drive as a multiple of the planned time ....
    pub(crate) drive_factor: f64,
    /// … plus this [s].
    pub(crate) drive_extra_s: f64,
    /// Longest wait for rest after the end [s].
    pub(crate) standstill_wait_s: f64,
    /// Braking after a failure [m/s²], by the map; "coast": no torque.
    pub(crate) failure_decel_mps2: Or<Coast>,
    /// Speed below which that torque fades out [m/s].
    pub(crate) failure_fade_mps: f64,
}

impl Default for MonitoringKeys {
    fn default() -> Self {
        Self {
            rest_s: 0.3,
            stood_short_s: 1.0,
            speed_lost_s: 0.1,
            gear_s: 2.0,
            drive_factor: 3.0,
            drive_extra_s: 5.0,
            standstill_wait_s: 3.0,
            failure_decel_mps2: Or::number(1.0),
            failure_fade_mps: 0.15,
        }
    }
}

impl MonitoringKeys {
    /// The settings in the order of the file.
    pub(crate) fn settings(&self) -> Vec<Setting> {
        vec![
            Setting::number("rest_s", self.rest_s, 0.02..=10.0, "standing this long after the end is rest [s]"),
            Setting::number("stood_short_s", self.stood_short_s, 0.05..=60.0, "standing this long short of the end is a failure [s]"),
            Setting::number("speed_lost_s", self.speed_lost_s, 0.005..=5.0, "no speed reading for this long is a failure [s]"),
            Setting::number("gear_s", self.gear_s, 0.05..=60.0, "longest wait for the gear [s]"),
            Setting::number("drive_factor", self.drive_factor, 1.0..=100.0, "longest drive as a multiple of the planned time ..."),
            Setting::number("drive_extra_s", self.drive_extra_s, 0.0..=600.0, "... plus this [s]"),
            Setting::number("standstill_wait_s", self.standstill_wait_s, 0.1..=60.0, "longest wait for rest after the end [s]"),
            Setting::number(
                "failure_decel_mps2",
                self.failure_decel_mps2,
                0.05..=10.0,
                "braking after a failure [m/s²], by the map; \"coast\": no torque",
            ),
            Setting::number("failure_fade_mps", self.failure_fade_mps, 0.01..=2.0, "speed below which that torque fades out [m/s]"),
        ]
    }
}

/// Tolerances and times of the steering.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(crate) struct SteeringKeys {
    /// The wheel is at its target within this [°] ....
    pub(crate) tolerance_deg: f64,
    /// … for this long [s].
    pub(crate) settle_s: f64,
    /// Further than this from the target while driving, it is lost [°].
    pub(crate) lost_deg: f64,
    /// Largest plausible angle [°].
    pub(crate) plausible_deg: f64,
    /// Moving less than this [°] ....
    pub(crate) stuck_deg: f64,
    /// … for this long, it is stuck [s].
    pub(crate) stuck_s: f64,
    /// Longest time to a target [s].
    pub(crate) slow_s: f64,
}

impl Default for SteeringKeys {
    fn default() -> Self {
        Self { tolerance_deg: 1.5, settle_s: 0.1, lost_deg: 5.0, plausible_deg: 110.0, stuck_deg: 0.8, stuck_s: 1.0, slow_s: 10.0 }
    }
}

impl SteeringKeys {
    /// The settings in the order of the file.
    pub(crate) fn settings(&self) -> Vec<Setting> {
        vec![
            Setting::number("tolerance_deg", self.tolerance_deg, 0.05..=20.0, "the wheel is at its target within this [deg] ..."),
            Setting::number("settle_s", self.settle_s, 0.0..=10.0, "... for this long [s]"),
            Setting::number("lost_deg", self.lost_deg, 0.1..=45.0, "further than this from the target while driving, it is lost [deg]"),
            Setting::number("plausible_deg", self.plausible_deg, 10.0..=180.0, "largest plausible angle [deg]"),
            Setting::number("stuck_deg", self.stuck_deg, 0.01..=20.0, "moving less than this [deg] ..."),
            Setting::number("stuck_s", self.stuck_s, 0.05..=60.0, "... for this long, it is stuck [s]"),
            Setting::number("slow_s", self.slow_s, 0.5..=120.0, "longest time to a target [s]"),
        ]
    }
}

/// The speed loop of path tracking, in polylines, parking and U-turns.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(crate) struct TrackingKeys {
    /// Kp [1/s].
    pub(crate) proportional_per_s: f64,
    /// Ki [1/s²].
    pub(crate) integral_per_s2: f64,
    /// Lowest desired acceleration [m/s²].
    pub(crate) lowest_accel_mps2: f64,
    /// Highest desired acceleration [m/s²].
    pub(crate) highest_accel_mps2: f64,
    /// Lag time of the preview [s].
    pub(crate) lag_s: f64,
    /// Least preview distance [m].
    pub(crate) least_distance_m: f64,
    /// Deceleration of the stop [m/s²].
    pub(crate) stop_decel_mps2: f64,
    /// Below this speed the vehicle rests [m/s].
    pub(crate) standstill_speed_mps: f64,
}

impl Default for TrackingKeys {
    fn default() -> Self {
        Self {
            proportional_per_s: 3.0,
            integral_per_s2: 0.5,
            lowest_accel_mps2: -1.5,
            highest_accel_mps2: 1.0,
            lag_s: 0.3,
            least_distance_m: 0.01,
            stop_decel_mps2: 0.3,
            standstill_speed_mps: 0.02,
        }
    }
}

impl TrackingKeys {
    /// The settings in the order of the file.
    pub(crate) fn settings(&self) -> Vec<Setting> {
        vec![
            Setting::number("proportional_per_s", self.proportional_per_s, 0.0..=50.0, "Kp [1/s]"),
            Setting::number("integral_per_s2", self.integral_per_s2, 0.0..=50.0, "Ki [1/s²]"),
            Setting::number("lowest_accel_mps2", self.lowest_accel_mps2, -10.0..=-0.05, "lowest desired acceleration [m/s²]"),
            Setting::number("highest_accel_mps2", self.highest_accel_mps2, 0.05..=10.0, "highest desired acceleration [m/s²]"),
            Setting::number("lag_s", self.lag_s, 0.0..=3.0, "lag time of the preview [s]"),
            Setting::number("least_distance_m", self.least_distance_m, 0.0..=1.0, "least preview distance [m]"),
            Setting::number("stop_decel_mps2", self.stop_decel_mps2, 0.02..=10.0, "deceleration of the stop [m/s²]"),
            Setting::number("standstill_speed_mps", self.standstill_speed_mps, 0.001..=0.2, "below this speed the vehicle rests [m/s]"),
        ]
    }
}

/// The speed loop of the turns on the spot between the segments of a polyline.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(crate) struct SpotTurnKeys {
    /// Kp [1/s].
    pub(crate) proportional_per_s: f64,
    /// Ki [1/s²].
    pub(crate) integral_per_s2: f64,
    /// Lowest desired acceleration [m/s²].
    pub(crate) lowest_accel_mps2: f64,
    /// Highest desired acceleration [m/s²].
    pub(crate) highest_accel_mps2: f64,
    /// Fastest change of the desired speed [m/s²].
    pub(crate) accel_mps2: f64,
    /// Preview time of the rate [s]; "vehicle": 0.3, longer for a slower drive.
    pub(crate) preview_s: Or<OfVehicle>,
    /// Deceleration of the stop [m/s²].
    pub(crate) stop_decel_mps2: f64,
    /// Below this speed the wheel rests [m/s].
    pub(crate) standstill_speed_mps: f64,
}

impl Default for SpotTurnKeys {
    fn default() -> Self {
        Self {
            proportional_per_s: 3.0,
            integral_per_s2: 0.5,
            lowest_accel_mps2: -2.5,
            highest_accel_mps2: 1.5,
            accel_mps2: 0.4,
            preview_s: Or::word(),
            stop_decel_mps2: 0.3,
            standstill_speed_mps: 0.02,
        }
    }
}

impl SpotTurnKeys {
    /// The settings in the order of the file.
    pub(crate) fn settings(&self) -> Vec<Setting> {
        vec![
            Setting::number("proportional_per_s", self.proportional_per_s, 0.0..=50.0, "Kp [1/s]"),
            Setting::number("integral_per_s2", self.integral_per_s2, 0.0..=50.0, "Ki [1/s²]"),
            Setting::number("lowest_accel_mps2", self.lowest_accel_mps2, -10.0..=-0.05, "lowest desired acceleration [m/s²]"),
            Setting::number("highest_accel_mps2", self.highest_accel_mps2, 0.05..=10.0, "highest desired acceleration [m/s²]"),
            Setting::number("accel_mps2", self.accel_mps2, 0.01..=10.0, "fastest change of the desired speed [m/s²]"),
            Setting::number(
                "preview_s",
                self.preview_s,
                0.0..=3.0,
                "preview time of the rate [s]; \"vehicle\": 0.3, longer for a slower drive",
            ),
            Setting::number("stop_decel_mps2", self.stop_decel_mps2, 0.02..=10.0, "deceleration of the stop [m/s²]"),
            Setting::number("standstill_speed_mps", self.standstill_speed_mps, 0.001..=0.2, "below this speed the wheel rests [m/s]"),
        ]
    }
}
