//! Signal maps for common vehicles.

use crate::log::signal_map::{SignalMap, SignalName};
use crate::log::{Error, Result};
use std::fmt;
use std::str::FromStr;

/// A built-in signal map.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Preset {
    /// The topics that `record` writes.
    PivotCal,
    /// The logs of `verify --log`: a controller that drives.
    VerifyLog,
    /// The status topics of Autoware. It does not define torque and wheel speed; these are found by name.
    Autoware,
    /// `sensor_msgs/JointState` for speed and angle; all other signals by name.
    JointState,
}

impl Preset {
    /// Every preset.
    pub const ALL: [Self; 4] = [Self::PivotCal, Self::VerifyLog, Self::Autoware, Self::JointState];

    /// The name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::PivotCal => "pivot-cal",
            Self::VerifyLog => "verify-log",
            Self::Autoware => "autoware",
            Self::JointState => "joint-state",
        }
    }

    /// The signals that the preset fixes; those that it omits are searched for by name.
    pub(crate) fn map(self) -> Result<SignalMap> {
        SignalMap::from_toml(match self {
            Self::PivotCal => {
                r#"
                [signals]
                speed = { path = '/joint_states.velocity{name=="front_drive_joint"}', unit = "rad/s" }
                torque = { path = "/drive/torque_command.data", unit = "N.m" }
                torque_feedback = { path = "/drive/torque_feedback.data", unit = "N.m" }
                angle = { path = '/eps/joint_states.position{name=="front_steer_joint"}', unit = "rad" }
                yaw_rate = { path = "/imu/twist.twist.angular.z", unit = "rad/s" }
                gear = { path = "/drive/gear.data", neutral = 0, forward = 1, reverse = 2 }
                estop = { path = "/safety/estop.data" }
                pose_x = { path = "/odom.pose.pose.position.x", unit = "m" }
                pose_y = { path = "/odom.pose.pose.position.y", unit = "m" }
                yaw_z = { path = "/odom.pose.pose.orientation.z" }
                yaw_w = { path = "/odom.pose.pose.orientation.w" }
                reference_x = { path = "/reference/matched_point.point.x", unit = "m" }
                reference_y = { path = "/reference/matched_point.point.y", unit = "m" }
                compensation = { path = "/steering/compensation.data", unit = "rad" }
                "#
            }
            Self::VerifyLog => {
                r#"
                [signals]
                speed = { path = '/joint_states.velocity{name=="front_drive_joint"}', unit = "rad/s" }
                torque = { path = "/drive/torque_command.data", unit = "N.m" }
                angle = { path = '/joint_states.position{name=="front_steer_joint"}', unit = "rad" }
                gear = { path = "/drive/gear.data", neutral = 0, forward = 1, reverse = 2 }
                estop = { path = "/safety/estop.data" }
                desired_accel = { path = "/pivot/accel_desired.data", unit = "m/s²" }
                "#
            }
            Self::Autoware => {
                r#"
                [signals]
                angle = { path = "/vehicle/status/steering_status.steering_tire_angle", unit = "rad" }
                yaw_rate = { path = "/vehicle/status/velocity_status.heading_rate", unit = "rad/s" }
                gear = { path = "/vehicle/status/gear_status.report", neutral = 1, forward = [2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 18, 19, 23, 24], reverse = [20, 21] }
                "#
            }
            Self::JointState => "",
        })
    }

    /// Whether a signal not fixed by the preset may come from messages of this schema.
    pub(crate) fn allows(self, signal: SignalName, schema: &str) -> bool {
        match (self, signal) {
            (Self::PivotCal | Self::VerifyLog, _) => false,
            (Self::JointState, SignalName::Speed | SignalName::Angle) => schema.ends_with("JointState"),
            _ => true,
        }
    }
}

impl fmt::Display for Preset {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Preset {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        Self::ALL.into_iter().find(|preset| preset.name() == text).ok_or_else(|| Error::UnknownPreset { found: text.to_owned() })
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn every_preset_is_a_valid_signal_map_and_found_by_its_name() {
        for preset in Preset::ALL {
            preset.map().unwrap();
            assert_eq!(preset.name().parse::<Preset>().unwrap(), preset);
        }
        assert!("autowar".parse::<Preset>().is_err());
    }
}
