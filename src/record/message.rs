//! ROS 2 messages and their encoding.

use crate::record::cdr::Cdr;
use crate::record::schema::TypeName;

/// Time of a message [ns since 1970].
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct MessageStamp {
    /// Nanoseconds since 1970-01-01 UTC.
    pub ns: u64,
}

/// `sensor_msgs/msg/JointState`: each array has the length of `names` or is empty.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct JointState<'a> {
    /// `header.stamp`.
    pub stamp: MessageStamp,
    /// `header.frame_id`.
    pub frame_id: &'a str,
    /// Names of the joints.
    pub names: &'a [&'a str],
    /// Positions [rad].
    pub positions: &'a [f64],
    /// Velocities [rad/s].
    pub velocities: &'a [f64],
    /// Torques [N·m].
    pub efforts: &'a [f64],
}

/// `geometry_msgs/msg/TwistStamped`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct TwistStamped<'a> {
    /// `header.stamp`.
    pub stamp: MessageStamp,
    /// `header.frame_id`.
    pub frame_id: &'a str,
    /// `twist.linear` [m/s].
    pub linear: [f64; 3],
    /// `twist.angular` [rad/s].
    pub angular: [f64; 3],
}

/// `nav_msgs/msg/Odometry` of a vehicle on a plane, with zero covariances.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Odometry<'a> {
    /// `header.stamp`.
    pub stamp: MessageStamp,
    /// `header.frame_id`, the world.
    pub frame_id: &'a str,
    /// `child_frame_id`, the vehicle.
    pub child_frame_id: &'a str,
    /// Position [m].
    pub x_m: f64,
    /// Position [m].
    pub y_m: f64,
    /// Heading [rad].
    pub heading_rad: f64,
    /// Forward speed of the reference point [m/s].
    pub speed_mps: f64,
    /// Yaw rate [rad/s].
    pub yaw_rate_rad_s: f64,
}

/// `geometry_msgs/msg/PointStamped` on the ground.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct PointStamped<'a> {
    /// `header.stamp`.
    pub stamp: MessageStamp,
    /// `header.frame_id`.
    pub frame_id: &'a str,
    /// Position [m].
    pub x_m: f64,
    /// Position [m].
    pub y_m: f64,
}

/// `nav_msgs/msg/Path` on the ground.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct PathMessage<'a> {
    /// `header.stamp`, also used for every pose.
    pub stamp: MessageStamp,
    /// `header.frame_id`, also used for every pose.
    pub frame_id: &'a str,
    /// x [m], y [m] and heading [rad] of every pose.
    pub poses: &'a [[f64; 3]],
}

/// A message of one of the standard types.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum RosMessage<'a> {
    /// `std_msgs/msg/Float64`.
    Float64(f64),
    /// `std_msgs/msg/Int8`.
    Int8(i8),
    /// `std_msgs/msg/Bool`.
    Bool(bool),
    /// `std_msgs/msg/String`.
    String(&'a str),
    /// `sensor_msgs/msg/JointState`.
    JointState(JointState<'a>),
    /// `geometry_msgs/msg/TwistStamped`.
    TwistStamped(TwistStamped<'a>),
    /// `nav_msgs/msg/Odometry`.
    Odometry(Odometry<'a>),
    /// `geometry_msgs/msg/PointStamped`.
    PointStamped(PointStamped<'a>),
    /// `nav_msgs/msg/Path`.
    Path(PathMessage<'a>),
}

impl RosMessage<'_> {
    /// The type's full name.
    pub(crate) fn type_name(&self) -> TypeName {
        match self {
            Self::Float64(_) => "std_msgs/msg/Float64",
            Self::Int8(_) => "std_msgs/msg/Int8",
            Self::Bool(_) => "std_msgs/msg/Bool",
            Self::String(_) => "std_msgs/msg/String",
            Self::JointState(_) => "sensor_msgs/msg/JointState",
            Self::TwistStamped(_) => "geometry_msgs/msg/TwistStamped",
            Self::Odometry(_) => "nav_msgs/msg/Odometry",
            Self::PointStamped(_) => "geometry_msgs/msg/PointStamped",
            Self::Path(_) => "nav_msgs/msg/Path",
        }
    }

    /// The CDR bytes.
    pub(crate) fn to_cdr(self) -> Vec<u8> {
        let mut cdr = Cdr::new();
        match &self {
            Self::Float64(value) => cdr.f64(*value),
            Self::Int8(value) => cdr.i8(*value),
            Self::Bool(value) => cdr.bool(*value),
            Self::String(text) => cdr.string(text),
            Self::JointState(joints) => {
                header(&mut cdr, joints.stamp, joints.frame_id);
                cdr.u32(joints.names.len() as u32);
                for name in joints.names {
                    cdr.string(name);
                }
                for values in [joints.positions, joints.velocities, joints.efforts] {
                    cdr.f64_sequence(values);
                }
            }
            Self::TwistStamped(twist) => {
                header(&mut cdr, twist.stamp, twist.frame_id);
                cdr.f64_array(&twist.linear);
                cdr.f64_array(&twist.angular);
            }
            Self::Odometry(odometry) => {
                header(&mut cdr, odometry.stamp, odometry.frame_id);
                cdr.string(odometry.child_frame_id);
                let (sin, cos) = (0.5 * odometry.heading_rad).sin_cos();
                cdr.f64_array(&[odometry.x_m, odometry.y_m, 0.0, 0.0, 0.0, sin, cos]);
                cdr.f64_array(&[0.0; 36]);
                cdr.f64_array(&[odometry.speed_mps, 0.0, 0.0, 0.0, 0.0, odometry.yaw_rate_rad_s]);
                cdr.f64_array(&[0.0; 36]);
            }
            Self::PointStamped(point) => {
                header(&mut cdr, point.stamp, point.frame_id);
                cdr.f64_array(&[point.x_m, point.y_m, 0.0]);
            }
            Self::Path(path) => {
                header(&mut cdr, path.stamp, path.frame_id);
                cdr.u32(path.poses.len() as u32);
                for [x_m, y_m, heading_rad] in path.poses {
                    header(&mut cdr, path.stamp, path.frame_id);
                    let (sin, cos) = (0.5 * heading_rad).sin_cos();
                    cdr.f64_array(&[*x_m, *y_m, 0.0, 0.0, 0.0, sin, cos]);
                }
            }
        }
        cdr.into_bytes()
    }
}

fn header(cdr: &mut Cdr, stamp: MessageStamp, frame_id: &str) {
    cdr.i32((stamp.ns / 1_000_000_000) as i32);
    cdr.u32((stamp.ns % 1_000_000_000) as u32);
    cdr.string(frame_id);
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use serde::Deserialize;

    #[derive(Debug, PartialEq, Deserialize)]
    struct ReadJointState {
        sec: i32,
        nanosec: u32,
        frame_id: String,
        name: Vec<String>,
        position: Vec<f64>,
        velocity: Vec<f64>,
        effort: Vec<f64>,
    }

    #[test]
    fn another_library_reads_the_joint_state_correctly() {
        let message = RosMessage::JointState(JointState {
            stamp: MessageStamp { ns: 1_700_000_000_123_456_789 },
            frame_id: "base_link",
            names: &["front_drive_joint", "front_steer_joint"],
            positions: &[0.25, 1.5],
            velocities: &[-3.0, 0.0],
            efforts: &[],
        });
        let (read, _) = re_cdr::from_bytes::<ReadJointState, re_cdr::LittleEndian>(&message.to_cdr()[4..]).unwrap();
        assert_eq!((read.sec, read.nanosec, read.frame_id.as_str()), (1_700_000_000, 123_456_789, "base_link"));
        assert_eq!(read.name, ["front_drive_joint", "front_steer_joint"]);
        assert_eq!((read.position, read.velocity, read.effort), (vec![0.25, 1.5], vec![-3.0, 0.0], vec![]));
    }

    #[test]
    fn an_odometry_message_has_the_size_of_its_fields() {
        let message = RosMessage::Odometry(Odometry {
            stamp: MessageStamp { ns: 0 },
            frame_id: "odom",
            child_frame_id: "base_link",
            x_m: 1.0,
            y_m: 2.0,
            heading_rad: 0.0,
            speed_mps: 0.0,
            yaw_rate_rad_s: 0.0,
        });
        // stamp 8, "odom" 4 + 5 and 3 to align, "base_link" 4 + 10 and 6 to align, then 7 + 36 + 6 + 36 numbers; header 4
        assert_eq!(message.to_cdr().len(), 4 + 8 + 12 + 20 + 8 * (7 + 36 + 6 + 36));
    }
}
