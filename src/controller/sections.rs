//! The sections of a controller file: every key with its meaning, default and range.

use crate::control::{Nearest, OutsidePolicy, WheelPolicy};
use crate::controller::or_word::{Coast, Mirrored, OfMap, OfVehicle, Off, Or};
use crate::controller::setting::{Setting, Settable, Shown};
use serde::{Deserialize, Serialize};

/// A section: a struct whose fields are the keys, with their defaults and ranges.
macro_rules! section {
    ($(#[doc = $what:literal])* $name:ident { $(#[doc = $about:literal] $key:ident: $type:ty = $default:expr $(, $range:expr)?;)* }) => {
        $(#[doc = $what])*
        #[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
        #[serde(default, deny_unknown_fields)]
        pub(crate) struct $name {
            $(#[doc = $about] pub(crate) $key: $type,)*
        }

        impl Default for $name {
            fn default() -> Self {
                Self { $($key: $default,)* }
            }
        }

        impl $name {
            /// The settings in the order of the file.
            pub(crate) fn settings(&self) -> Vec<Setting> {
                vec![$(Setting {
                    key: stringify!($key),
                    about: $about.trim_ascii(),
                    value: Settable::shown(self.$key),
                    words: <$type as Settable>::WORDS,
                    range: [$($range)?].into_iter().next(),
                },)*]
            }
        }
    };
}

/// Words of a file for the values of an enumeration.
macro_rules! words {
    ($(#[doc = $what:literal])* $name:ident { $($(#[doc = $about:literal])* $value:ident = $word:literal,)* }) => {
        $(#[doc = $what])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
        pub(crate) enum $name {
            $($(#[doc = $about])* #[serde(rename = $word)] $value,)*
        }

        impl Settable for $name {
            const WORDS: &'static [&'static str] = &[$($word),*];

            fn shown(self) -> Shown {
                match self {
                    $(Self::$value => Shown::Word($word),)*
                }
            }
        }
    };
}

words! {
    /// Wheel policy of the vehicle.
    Policy {
        /// Both are judged, each by its own pivots.
        Both = "both",
        /// The wheel always at its test angle; right turns in reverse gear.
        HoldLeft = "hold-left",
        /// The wheel to the right for right turns; always forward gear.
        Mirror = "mirror",
    }
}

words! {
    /// Method of locating the wheel on the path.
    Locate {
        /// The nearest waypoint.
        Waypoint = "waypoint",
        /// The foot of the perpendicular.
        Projection = "projection",
    }
}

words! {
    /// Policy outside the table's axes.
    Outside {
        /// The edge value.
        Clamp = "clamp",
        /// No torque; the pivot fails.
        Refuse = "refuse",
    }
}

words! {
    /// Finish on the last piece.
    Ending {
        /// The torque ends at the threshold.
        Threshold = "threshold",
        /// The torque ends where the wheel rolls out to the end.
        RollOut = "roll-out",
    }
}

impl Policy {
    /// The word of a file.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Both => "both",
            Self::HoldLeft => "hold-left",
            Self::Mirror => "mirror",
        }
    }

    /// Whether pivots of `policy` are driven.
    pub(crate) fn has(self, policy: WheelPolicy) -> bool {
        matches!((self, policy), (Self::Both, _) | (Self::HoldLeft, WheelPolicy::HoldLeft) | (Self::Mirror, WheelPolicy::Mirror))
    }
}

impl From<Locate> for Nearest {
    fn from(locate: Locate) -> Self {
        match locate {
            Locate::Waypoint => Self::Waypoint,
            Locate::Projection => Self::Projection,
        }
    }
}

impl From<Outside> for OutsidePolicy {
    fn from(outside: Outside) -> Self {
        match outside {
            Outside::Clamp => Self::Clamp,
            Outside::Refuse => Self::Refuse,
        }
    }
}

section! {
    /// Planning of a turn.
    PlanningKeys {
        /// speed of the first waypoint [m/s]
        start_speed_mps: f64 = 0.1, 0.001..=1.0;
        /// highest speed [m/s]
        cruise_speed_mps: f64 = 0.6, 0.02..=5.0;
        /// acceleration of the plan [m/s²]
        accel_mps2: f64 = 0.4, 0.01..=10.0;
        /// deceleration of the plan [m/s²]
        decel_mps2: f64 = 0.4, 0.01..=10.0;
        /// distance between waypoints along the arc [m]
        waypoint_spacing_m: f64 = 0.02, 0.001..=1.0;
        /// wheel always left, or to the side of the turn; "both": pivots of both are judged
        wheel_policy: Policy = Policy::Both;
        /// second preset: wheel angle of right turns with "mirror" [deg]; "mirror": that of the map, mirrored
        right_angle_deg: Or<Mirrored> = Or::word(), -120.0..=-10.0;
        /// third preset: wheel angle after a turn [deg], left positive
        return_angle_deg: f64 = 0.0, -100.0..=100.0;
    }
}

section! {
    /// The planned speed that the law follows: formula (1).
    PreviewKeys {
        /// the wheel's place: the nearest waypoint, or its projection on the path
        nearest: Locate = Locate::Projection;
        /// lag time [s]
        lag_s: f64 = 0.3, 0.0..=3.0;
        /// least preview distance [m]
        least_distance_m: f64 = 0.01, 0.0..=1.0;
    }
}

section! {
    /// From the speed error to the desired acceleration: formula (2).
    LoopKeys {
        /// Kp [1/s]
        proportional_per_s: f64 = 3.0, 0.0..=50.0;
        /// Ki [1/s²]
        integral_per_s2: f64 = 0.5, 0.0..=50.0;
        /// lowest desired acceleration [m/s²]
        lowest_accel_mps2: f64 = -2.5, -10.0..=-0.05;
        /// highest desired acceleration [m/s²]
        highest_accel_mps2: f64 = 1.5, 0.05..=10.0;
    }
}

section! {
    /// The look-up and the end of a turn.
    FinishKeys {
        /// outside the axes of Table 2: the edge value, or no torque and the pivot fails
        outside_axes: Outside = Outside::Clamp;
        /// the end is reached with less than this left [m]
        end_threshold_m: f64 = 0.02, 0.0005..=0.5;
        /// below this speed the wheel rests [m/s]
        standstill_speed_mps: f64 = 0.02, 0.001..=0.2;
        /// the torque ends at the threshold, or where the wheel rolls out to the end (an addition)
        finish: Ending = Ending::RollOut;
        /// lowest desired speed of "roll-out" [m/s]
        creep_speed_mps: f64 = 0.06, 0.0..=0.5;
    }
}

section! {
    /// Additions to formulas (1) and (2), docs/controller.md; "off" removes one.
    AdditionKeys {
        /// fastest rise of a driving acceleration [m/s³]
        accel_rise_mps3: Or<Off> = Or::number(2.5), 0.1..=100.0;
        /// braking for the end from this deceleration [m/s²]
        guard_from_mps2: Or<Off> = Or::number(0.5), 0.02..=10.0;
        /// prediction over this time [s]; "map": dead time plus lag of the map, 0: none
        reaction_s: Or<OfMap> = Or::word(), 0.0..=2.0;
        /// age of the pose when it is read [s]
        pose_age_s: f64 = 0.015, 0.0..=1.0;
        /// fastest change of the torque [N.m/s]
        torque_rate_nm_s: Or<Off> = Or::word(), 1.0..=1e6;
        /// low-pass of the detection of rest [s], 0: none
        standstill_filter_s: f64 = 0.1, 0.0..=2.0;
    }
}

section! {
    /// Times and limits of the longitudinal module.
    MonitoringKeys {
        /// standing this long after the end is rest [s]
        rest_s: f64 = 0.3, 0.02..=10.0;
        /// standing this long short of the end is a failure [s]
        stood_short_s: f64 = 1.0, 0.05..=60.0;
        /// no speed reading for this long is a failure [s]
        speed_lost_s: f64 = 0.1, 0.005..=5.0;
        /// longest wait for the gear [s]
        gear_s: f64 = 2.0, 0.05..=60.0;
        /// longest drive as a multiple of the planned time ...
        drive_factor: f64 = 3.0, 1.0..=100.0;
        /// ... plus this [s]
        drive_extra_s: f64 = 5.0, 0.0..=600.0;
        /// longest wait for rest after the end [s]
        standstill_wait_s: f64 = 3.0, 0.1..=60.0;
        /// braking after a failure [m/s²], by the map; "coast": no torque
        failure_decel_mps2: Or<Coast> = Or::number(1.0), 0.05..=10.0;
        /// speed below which that torque fades out [m/s]
        failure_fade_mps: f64 = 0.15, 0.01..=2.0;
    }
}

section! {
    /// Tolerances and times of the steering.
    SteeringKeys {
        /// the wheel is at its target within this [deg] ...
        tolerance_deg: f64 = 1.5, 0.05..=20.0;
        /// ... for this long [s]
        settle_s: f64 = 0.1, 0.0..=10.0;
        /// further than this from the target while driving, it is lost [deg]
        lost_deg: f64 = 5.0, 0.1..=45.0;
        /// largest plausible angle [deg]
        plausible_deg: f64 = 110.0, 10.0..=180.0;
        /// moving less than this [deg] ...
        stuck_deg: f64 = 0.8, 0.01..=20.0;
        /// ... for this long, it is stuck [s]
        stuck_s: f64 = 1.0, 0.05..=60.0;
        /// longest time to a target [s]
        slow_s: f64 = 10.0, 0.5..=120.0;
    }
}

section! {
    /// The speed loop of path tracking, in polylines, parking and U-turns.
    TrackingKeys {
        /// Kp [1/s]
        proportional_per_s: f64 = 3.0, 0.0..=50.0;
        /// Ki [1/s²]
        integral_per_s2: f64 = 0.5, 0.0..=50.0;
        /// lowest desired acceleration [m/s²]
        lowest_accel_mps2: f64 = -1.5, -10.0..=-0.05;
        /// highest desired acceleration [m/s²]
        highest_accel_mps2: f64 = 1.0, 0.05..=10.0;
        /// lag time of the preview [s]
        lag_s: f64 = 0.3, 0.0..=3.0;
        /// least preview distance [m]
        least_distance_m: f64 = 0.01, 0.0..=1.0;
        /// deceleration of the stop [m/s²]
        stop_decel_mps2: f64 = 0.3, 0.02..=10.0;
        /// below this speed the vehicle rests [m/s]
        standstill_speed_mps: f64 = 0.02, 0.001..=0.2;
    }
}

section! {
    /// The speed loop of the turns on the spot between the segments of a polyline.
    SpotTurnKeys {
        /// Kp [1/s]
        proportional_per_s: f64 = 3.0, 0.0..=50.0;
        /// Ki [1/s²]
        integral_per_s2: f64 = 0.5, 0.0..=50.0;
        /// lowest desired acceleration [m/s²]
        lowest_accel_mps2: f64 = -2.5, -10.0..=-0.05;
        /// highest desired acceleration [m/s²]
        highest_accel_mps2: f64 = 1.5, 0.05..=10.0;
        /// fastest change of the desired speed [m/s²]
        accel_mps2: f64 = 0.4, 0.01..=10.0;
        /// preview time of the rate [s]; "vehicle": 0.3, longer for a slower drive
        preview_s: Or<OfVehicle> = Or::word(), 0.0..=3.0;
        /// deceleration of the stop [m/s²]
        stop_decel_mps2: f64 = 0.3, 0.02..=10.0;
        /// below this speed the wheel rests [m/s]
        standstill_speed_mps: f64 = 0.02, 0.001..=0.2;
    }
}
