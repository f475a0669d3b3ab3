//! Definitions of the ROS 2 message types in use, as every reader of `ros2msg` schemas wants them: the type's own fields, then each type
//! that it contains after a line of 80 `=` and its name.
//!
//! Source: the ROS 2 packages `std_msgs`, `sensor_msgs`, `geometry_msgs`, `nav_msgs`, `builtin_interfaces`.

/// A type's full name, as a schema record gives it.
pub(crate) type TypeName = &'static str;

/// Name without `msg/`, fields, and the types that the fields contain.
struct TypeDefinition {
    short: &'static str,
    fields: &'static str,
    contains: &'static [&'static str],
}

const DEFINITIONS: &[TypeDefinition] = &[
    TypeDefinition { short: "std_msgs/Float64", fields: "float64 data\n", contains: &[] },
    TypeDefinition { short: "std_msgs/Int8", fields: "int8 data\n", contains: &[] },
    TypeDefinition { short: "std_msgs/Bool", fields: "bool data\n", contains: &[] },
    TypeDefinition { short: "std_msgs/String", fields: "string data\n", contains: &[] },
    TypeDefinition {
        short: "std_msgs/Header",
        fields: "# Time of the data and the frame that it belongs to\nbuiltin_interfaces/Time stamp\nstring frame_id\n",
        contains: &["builtin_interfaces/Time"],
    },
    TypeDefinition {
        short: "builtin_interfaces/Time",
        fields: "# Seconds since 1970, valid over all int32 values\nint32 sec\n\n# Nanoseconds, 0 to 999999999\nuint32 nanosec\n",
        contains: &[],
    },
    TypeDefinition {
        short: "sensor_msgs/JointState",
        fields: "# State of joints. Each array is either as long as name or empty.\n# Position in rad, velocity in rad/s, effort in Nm.\n\
                 std_msgs/Header header\n\nstring[] name\nfloat64[] position\nfloat64[] velocity\nfloat64[] effort\n",
        contains: &["std_msgs/Header", "builtin_interfaces/Time"],
    },
    TypeDefinition {
        short: "geometry_msgs/TwistStamped",
        fields: "# A twist with its frame and time\nstd_msgs/Header header\ngeometry_msgs/Twist twist\n",
        contains: &["std_msgs/Header", "builtin_interfaces/Time", "geometry_msgs/Twist", "geometry_msgs/Vector3"],
    },
    TypeDefinition {
        short: "geometry_msgs/Twist",
        fields: "# Velocity in free space, linear in m/s and angular in rad/s\ngeometry_msgs/Vector3 linear\ngeometry_msgs/Vector3 angular\n",
        contains: &["geometry_msgs/Vector3"],
    },
    TypeDefinition { short: "geometry_msgs/Vector3", fields: "float64 x\nfloat64 y\nfloat64 z\n", contains: &[] },
    TypeDefinition {
        short: "nav_msgs/Odometry",
        fields: "# Estimate of a pose in header.frame_id and of a velocity in child_frame_id\nstd_msgs/Header header\n\nstring child_frame_id\n\n\
                 geometry_msgs/PoseWithCovariance pose\n\ngeometry_msgs/TwistWithCovariance twist\n",
        contains: &[
            "std_msgs/Header",
            "builtin_interfaces/Time",
            "geometry_msgs/PoseWithCovariance",
            "geometry_msgs/Pose",
            "geometry_msgs/Point",
            "geometry_msgs/Quaternion",
            "geometry_msgs/TwistWithCovariance",
            "geometry_msgs/Twist",
            "geometry_msgs/Vector3",
        ],
    },
    TypeDefinition {
        short: "geometry_msgs/PoseWithCovariance",
        fields: "# Row-major 6x6 covariance over x, y, z and the rotations about X, Y, Z\ngeometry_msgs/Pose pose\n\nfloat64[36] covariance\n",
        contains: &[],
    },
    TypeDefinition {
        short: "geometry_msgs/TwistWithCovariance",
        fields: "# Row-major 6x6 covariance over x, y, z and the rotations about X, Y, Z\ngeometry_msgs/Twist twist\n\nfloat64[36] covariance\n",
        contains: &[],
    },
    TypeDefinition {
        short: "geometry_msgs/PointStamped",
        fields: "# A point with its frame and time\nstd_msgs/Header header\ngeometry_msgs/Point point\n",
        contains: &["std_msgs/Header", "builtin_interfaces/Time", "geometry_msgs/Point"],
    },
    TypeDefinition {
        short: "geometry_msgs/PoseStamped",
        fields: "# A pose with its frame and time\nstd_msgs/Header header\ngeometry_msgs/Pose pose\n",
        contains: &["std_msgs/Header", "builtin_interfaces/Time", "geometry_msgs/Pose", "geometry_msgs/Point", "geometry_msgs/Quaternion"],
    },
    TypeDefinition {
        short: "nav_msgs/Path",
        fields: "# Poses to follow\nstd_msgs/Header header\ngeometry_msgs/PoseStamped[] poses\n",
        contains: &[
            "std_msgs/Header",
            "builtin_interfaces/Time",
            "geometry_msgs/PoseStamped",
            "geometry_msgs/Pose",
            "geometry_msgs/Point",
            "geometry_msgs/Quaternion",
        ],
    },
    TypeDefinition {
        short: "geometry_msgs/Pose",
        fields: "geometry_msgs/Point position\ngeometry_msgs/Quaternion orientation\n",
        contains: &[],
    },
    TypeDefinition { short: "geometry_msgs/Point", fields: "float64 x\nfloat64 y\nfloat64 z\n", contains: &[] },
    TypeDefinition { short: "geometry_msgs/Quaternion", fields: "float64 x 0\nfloat64 y 0\nfloat64 z 0\nfloat64 w 1\n", contains: &[] },
];

fn definition(short: &str) -> Option<&'static TypeDefinition> {
    DEFINITIONS.iter().find(|d| d.short == short)
}

/// The schema text of the type `name` (`std_msgs/msg/Float64`); empty for a type that is not in the list above.
pub(crate) fn text(name: TypeName) -> String {
    let Some(root) = definition(&name.replace("/msg/", "/")) else { return String::new() };
    let mut text = root.fields.to_owned();
    for part in root.contains.iter().filter_map(|short| definition(short)) {
        text.push('\n');
        text.push_str(&"=".repeat(80));
        text.push_str("\nMSG: ");
        text.push_str(part.short);
        text.push('\n');
        text.push_str(part.fields);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_schema_holds_every_type_that_it_contains() {
        for root in DEFINITIONS.iter().filter(|d| !d.contains.is_empty()) {
            let mut fields: Vec<&str> = root.fields.lines().collect();
            fields.extend(root.contains.iter().filter_map(|c| definition(c)).flat_map(|d| d.fields.lines()));
            let types = fields.iter().filter(|l| !l.starts_with('#')).filter_map(|l| l.split_whitespace().next());
            for name in types.filter(|t| t.contains('/')).map(|t| t.trim_end_matches("[]")) {
                assert!(root.contains.contains(&name), "{} lacks {name}", root.short);
            }
        }
    }

    #[test]
    fn the_text_is_what_readers_of_ros2msg_expect() {
        insta::assert_snapshot!(text("geometry_msgs/msg/TwistStamped"), @r"
        # A twist with its frame and time
        std_msgs/Header header
        geometry_msgs/Twist twist

        ================================================================================
        MSG: std_msgs/Header
        # Time of the data and the frame that it belongs to
        builtin_interfaces/Time stamp
        string frame_id

        ================================================================================
        MSG: builtin_interfaces/Time
        # Seconds since 1970, valid over all int32 values
        int32 sec

        # Nanoseconds, 0 to 999999999
        uint32 nanosec

        ================================================================================
        MSG: geometry_msgs/Twist
        # Velocity in free space, linear in m/s and angular in rad/s
        geometry_msgs/Vector3 linear
        geometry_msgs/Vector3 angular

        ================================================================================
        MSG: geometry_msgs/Vector3
        float64 x
        float64 y
        float64 z
        ");
    }
}
