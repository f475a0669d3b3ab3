//! The sections of a controller file about a turn and its law: every key with its meaning, default and range.

use crate::controller::or_word::{Mirrored, OfMap, Off, Or};
use crate::controller::setting::Setting;
use crate::controller::words::{Ending, Locate, Outside, Policy};
use serde::{Deserialize, Serialize};

/// Planning of a turn.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(crate) struct PlanningKeys {
    /// Speed of the first waypoint [m/s].
    pub(crate) start_speed_mps: f64,
    /// Highest speed [m/s].
    pub(crate) cruise_speed_mps: f64,
    /// Acceleration of the plan [m/s²].
    pub(crate) accel_mps2: f64,
    /// Deceleration of the plan [m/s²].
    pub(crate) decel_mps2: f64,
    /// Distance between waypoints along the arc [m].
    pub(crate) waypoint_spacing_m: f64,
    /// Wheel always left, or to the side of the turn; "both": pivots of both are judged.
    pub(crate) wheel_policy: Policy,
    /// Second preset: wheel angle of right turns with "mirror" [°]; "mirror": that of the map, mirrored.
    pub(crate) right_angle_deg: Or<Mirrored>,
    /// Third preset: wheel angle after a turn [°], left positive.
    pub(crate) return_angle_deg: f64,
}

impl Default for PlanningKeys {
    fn default() -> Self {
        Self {
            start_speed_mps: 0.1,
            cruise_speed_mps: 0.6,
            accel_mps2: 0.4,
            decel_mps2: 0.4,
            waypoint_spacing_m: 0.02,
            wheel_policy: Policy::Both,
            right_angle_deg: Or::word(),
            return_angle_deg: 0.0,
        }
    }
}

impl PlanningKeys {
    /// The settings in the order of the file.
    pub(crate) fn settings(&self) -> Vec<Setting> {
        vec![
            Setting::number("start_speed_mps", self.start_speed_mps, 0.001..=1.0, "speed of the first waypoint [m/s]"),
            Setting::number("cruise_speed_mps", self.cruise_speed_mps, 0.02..=5.0, "highest speed [m/s]"),
            Setting::number("accel_mps2", self.accel_mps2, 0.01..=10.0, "acceleration of the plan [m/s²]"),
            Setting::number("decel_mps2", self.decel_mps2, 0.01..=10.0, "deceleration of the plan [m/s²]"),
            Setting::number("waypoint_spacing_m", self.waypoint_spacing_m, 0.001..=1.0, "distance between waypoints along the arc [m]"),
            Setting::word(
                "wheel_policy",
                self.wheel_policy,
                "wheel always left, or to the side of the turn; \"both\": pivots of both are judged",
            ),
            Setting::number(
                "right_angle_deg",
                self.right_angle_deg,
                -120.0..=-10.0,
                "second preset: wheel angle of right turns with \"mirror\" [deg]; \"mirror\": that of the map, mirrored",
            ),
            Setting::number(
                "return_angle_deg",
                self.return_angle_deg,
                -100.0..=100.0,
                "third preset: wheel angle after a turn [deg], left positive",
            ),
        ]
    }
}

/// The planned speed that the law follows: formula (1).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(crate) struct PreviewKeys {
    /// The wheel's place: the nearest waypoint, or its projection on the path.
    pub(crate) nearest: Locate,
    /// Lag time [s].
    pub(crate) lag_s: f64,
    /// Least preview distance [m].
    pub(crate) least_distance_m: f64,
}

impl Default for PreviewKeys {
    fn default() -> Self {
        Self { nearest: Locate::Projection, lag_s: 0.3, least_distance_m: 0.01 }
    }
}

impl PreviewKeys {
    /// The settings in the order of the file.
    pub(crate) fn settings(&self) -> Vec<Setting> {
        vec![
            Setting::word("nearest", self.nearest, "the wheel's place: the nearest waypoint, or its projection on the path"),
            Setting::number("lag_s", self.lag_s, 0.0..=3.0, "lag time [s]"),
            Setting::number("least_distance_m", self.least_distance_m, 0.0..=1.0, "least preview distance [m]"),
        ]
    }
}

/// From the speed error to the desired acceleration: formula (2).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(crate) struct LoopKeys {
    /// Kp [1/s].
    pub(crate) proportional_per_s: f64,
    /// Ki [1/s²].
    pub(crate) integral_per_s2: f64,
    /// Lowest desired acceleration [m/s²].
    pub(crate) lowest_accel_mps2: f64,
    /// Highest desired acceleration [m/s²].
    pub(crate) highest_accel_mps2: f64,
}

impl Default for LoopKeys {
    fn default() -> Self {
        Self { proportional_per_s: 3.0, integral_per_s2: 0.5, lowest_accel_mps2: -2.5, highest_accel_mps2: 1.5 }
    }
}

impl LoopKeys {
    /// The settings in the order of the file.
    pub(crate) fn settings(&self) -> Vec<Setting> {
        vec![
            Setting::number("proportional_per_s", self.proportional_per_s, 0.0..=50.0, "Kp [1/s]"),
            Setting::number("integral_per_s2", self.integral_per_s2, 0.0..=50.0, "Ki [1/s²]"),
            Setting::number("lowest_accel_mps2", self.lowest_accel_mps2, -10.0..=-0.05, "lowest desired acceleration [m/s²]"),
            Setting::number("highest_accel_mps2", self.highest_accel_mps2, 0.05..=10.0, "highest desired acceleration [m/s²]"),
        ]
    }
}

/// The look-up and the end of a turn.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(crate) struct FinishKeys {
    /// Outside the axes of Table 2: the edge value, or no torque and the pivot fails.
    pub(crate) outside_axes: Outside,
    /// The end is reached with less than this left [m].
    pub(crate) end_threshold_m: f64,
    /// Below this speed the wheel rests [m/s].
    pub(crate) standstill_speed_mps: f64,
    /// The torque ends at the threshold, or where the wheel rolls out to the end (an addition).
    pub(crate) finish: Ending,
    /// Lowest desired speed of "roll-out" [m/s].
    pub(crate) creep_speed_mps: f64,
}

impl Default for FinishKeys {
    fn default() -> Self {
        Self {
            outside_axes: Outside::Clamp,
            end_threshold_m: 0.02,
            standstill_speed_mps: 0.02,
            finish: Ending::RollOut,
            creep_speed_mps: 0.06,
        }
    }
}

impl FinishKeys {
    /// The settings in the order of the file.
    pub(crate) fn settings(&self) -> Vec<Setting> {
        vec![
            Setting::word(
                "outside_axes",
                self.outside_axes,
                "outside the axes of Table 2: the edge value, or no torque and the pivot fails",
            ),
            Setting::number("end_threshold_m", self.end_threshold_m, 0.0005..=0.5, "the end is reached with less than this left [m]"),
            Setting::number("standstill_speed_mps", self.standstill_speed_mps, 0.001..=0.2, "below this speed the wheel rests [m/s]"),
            Setting::word("finish", self.finish, "the torque ends at the threshold, or where the wheel rolls out to the end (an addition)"),
            Setting::number("creep_speed_mps", self.creep_speed_mps, 0.0..=0.5, "lowest desired speed of \"roll-out\" [m/s]"),
        ]
    }
}

/// Additions to formulas (1) and (2), docs/controller.md; "off" removes one.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(crate) struct AdditionKeys {
    /// Fastest rise of a driving acceleration [m/s³].
    pub(crate) accel_rise_mps3: Or<Off>,
    /// Braking for the end from this deceleration [m/s²].
    pub(crate) guard_from_mps2: Or<Off>,
    /// Prediction over this time [s]; "map": dead time plus lag of the map, 0: none.
    pub(crate) reaction_s: Or<OfMap>,
    /// Age of the pose when it is read [s].
    pub(crate) pose_age_s: f64,
    /// Fastest change of the torque [N.m/s].
    pub(crate) torque_rate_nm_s: Or<Off>,
    /// Low-pass of the detection of rest [s], 0: none.
    pub(crate) standstill_filter_s: f64,
}

impl Default for AdditionKeys {
    fn default() -> Self {
        Self {
            accel_rise_mps3: Or::number(2.5),
            guard_from_mps2: Or::number(0.5),
            reaction_s: Or::word(),
            pose_age_s: 0.015,
            torque_rate_nm_s: Or::word(),
            standstill_filter_s: 0.1,
        }
    }
}

impl AdditionKeys {
    /// The settings in the order of the file.
    pub(crate) fn settings(&self) -> Vec<Setting> {
        vec![
            Setting::number("accel_rise_mps3", self.accel_rise_mps3, 0.1..=100.0, "fastest rise of a driving acceleration [m/s³]"),
            Setting::number("guard_from_mps2", self.guard_from_mps2, 0.02..=10.0, "braking for the end from this deceleration [m/s²]"),
            Setting::number(
                "reaction_s",
                self.reaction_s,
                0.0..=2.0,
                "prediction over this time [s]; \"map\": dead time plus lag of the map, 0: none",
            ),
            Setting::number("pose_age_s", self.pose_age_s, 0.0..=1.0, "age of the pose when it is read [s]"),
            Setting::number("torque_rate_nm_s", self.torque_rate_nm_s, 1.0..=1e6, "fastest change of the torque [N.m/s]"),
            Setting::number("standstill_filter_s", self.standstill_filter_s, 0.0..=2.0, "low-pass of the detection of rest [s], 0: none"),
        ]
    }
}
