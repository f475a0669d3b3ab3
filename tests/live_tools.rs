//! What `record` writes, read by packages that are not ours; and message paths as users of Foxglove and `PlotJuggler` write them.
#![allow(clippy::unwrap_used)]

#[path = "common/program.rs"]
mod program;
#[path = "common/readers.rs"]
mod readers;

use assert_cmd::Command;
use pivot_cal::log::{Recording, Signal, SignalMap, Source, VehicleOverrides, read};
use program::repo;
use std::path::{Path, PathBuf};

/// A log as `record` writes it, with everything that goes wrong in it.
fn recorded(folder: &Path) -> PathBuf {
    let log = folder.join("messy.mcap");
    let (vehicle, campaign) = (repo("data/vehicles/scrubber.toml"), repo("data/campaigns/messy.toml"));
    let mut command = Command::cargo_bin("pivot-cal").unwrap();
    command.arg("record").arg("--vehicle").arg(vehicle).arg("--campaign").arg(campaign).arg("-o").arg(&log);
    command.assert().success();
    log
}

fn detected(log: &Path) -> Recording {
    read(log, &Source::Detect, &VehicleOverrides::default(), &|_| {}).unwrap()
}

/// What two packages found in a log: of every topic the schema, and the same messages with the same numbers.
#[track_caller]
fn expect_same(found: &serde_json::Value, schemas: &[(&str, &str)]) {
    let (mcap, rosbags) = (found["mcap"].as_object().unwrap(), found["rosbags"].as_object().unwrap());
    assert_eq!((mcap.len(), rosbags.len()), (schemas.len(), schemas.len()), "{found}");
    for (topic, schema) in schemas {
        let (a, b) = (&mcap[*topic], &rosbags[*topic]);
        assert_eq!(a["schema"], *schema, "{topic}");
        for key in ["schema", "messages", "numbers", "first_ns", "last_ns"] {
            assert_eq!(a[key], b[key], "{topic}: {key}");
        }
        let (a, b) = (a["sum"].as_f64().unwrap(), b["sum"].as_f64().unwrap());
        assert!((a - b).abs() <= 1e-9 * a.abs().max(1.0), "{topic}: {a} and {b}");
    }
}

#[test]
fn the_log_of_a_manoeuvre_with_its_reference_path_is_the_same_to_both() {
    let what = "a log of the lateral calibration read by mcap, mcap-ros2-support and rosbags";
    let Some(python) = readers::python(&["mcap", "mcap_ros2", "rosbags"], what) else { return };
    let folder = tempfile::tempdir().unwrap();
    let mut command = Command::cargo_bin("pivot-cal").unwrap();
    command
        .args(["lateral", "record", "--angles-deg", "0", "--vehicle"])
        .arg(repo("data/vehicles/scrubber.toml"))
        .arg("-o")
        .arg(folder.path());
    command.assert().success();
    let found = readers::read_with(&python, "ros2_log.py", &[&folder.path().join("base.mcap")], "");
    let float = |topic| (topic, "std_msgs/msg/Float64");
    expect_same(
        &found,
        &[
            ("/joint_states", "sensor_msgs/msg/JointState"),
            ("/odom", "nav_msgs/msg/Odometry"),
            ("/ground_truth/odom", "nav_msgs/msg/Odometry"),
            ("/reference/path", "nav_msgs/msg/Path"),
            ("/reference/matched_point", "geometry_msgs/msg/PointStamped"),
            ("/safety/estop", "std_msgs/msg/Bool"),
            ("/drive/gear", "std_msgs/msg/Int8"),
            ("/manoeuvre/stage", "std_msgs/msg/String"),
            float("/drive/torque_command"),
            float("/navigation/yaw"),
            float("/steering/compensation"),
            float("/manoeuvre/speed_actual"),
            float("/manoeuvre/speed_desired"),
            float("/manoeuvre/accel_desired"),
            float("/manoeuvre/wheel_angle_desired"),
            float("/manoeuvre/lateral_error"),
        ],
    );
    assert_eq!(found["mcap"]["/reference/path"]["messages"], 1);
    // x, y, z and the quaternion's four of every pose
    assert!(found["mcap"]["/reference/path"]["numbers"].as_u64().unwrap() > 7 * 100, "{}", found["mcap"]["/reference/path"]);
}

#[test]
fn a_recorded_log_is_the_same_to_mcap_ros2_support_and_to_rosbags() {
    let what = "a recorded log read by mcap, mcap-ros2-support and rosbags";
    let Some(python) = readers::python(&["mcap", "mcap_ros2", "rosbags"], what) else { return };
    let folder = tempfile::tempdir().unwrap();
    let log = recorded(folder.path());
    let found = readers::read_with(&python, "ros2_log.py", &[&log], "");
    let schemas = [
        ("/drive/gear", "std_msgs/msg/Int8"),
        ("/drive/torque_command", "std_msgs/msg/Float64"),
        ("/drive/torque_feedback", "std_msgs/msg/Float64"),
        ("/eps/joint_states", "sensor_msgs/msg/JointState"),
        ("/imu/twist", "geometry_msgs/msg/TwistStamped"),
        ("/joint_states", "sensor_msgs/msg/JointState"),
        ("/odom", "nav_msgs/msg/Odometry"),
        ("/safety/estop", "std_msgs/msg/Bool"),
    ];
    expect_same(&found, &schemas);
    // and they see what this program sees
    let own = detected(&log);
    let same = |topic: &str, signal: &Signal| {
        let sum: f64 = signal.value.iter().sum();
        let theirs = &found["rosbags"][topic];
        assert_eq!(theirs["messages"].as_u64().unwrap(), signal.value.len() as u64, "{topic}");
        // sums of the same numbers in the same order, one of them by Python
        assert!((theirs["sum"].as_f64().unwrap() - sum).abs() <= 1e-9 * sum.abs().max(1.0), "{topic}: {theirs} and {sum}");
    };
    same("/drive/torque_command", &own.signals.torque);
    same("/drive/torque_feedback", own.signals.torque_feedback.as_ref().unwrap());
    same("/eps/joint_states", &own.signals.angle);
    same("/imu/twist", own.signals.yaw_rate.as_ref().unwrap());
}

/// The demo log through a signal map with this path for the speed.
fn with_speed(path: &str) -> Recording {
    let map = format!(
        "[vehicle]\nwheelbase_m = 0.9\nwheel_radius_m = 0.12\ntest_angle_deg = 90.0\n[signals]\n\
         speed = {{ path = '{path}', unit = \"rad/s\" }}\n\
         torque = {{ path = \"/drive/torque_command.data\", unit = \"N.m\" }}\n\
         angle = {{ path = '/eps/joint_states.position[0]', unit = \"rad\" }}\n\
         yaw_rate = {{ path = \"/imu/twist.twist.angular.z\", unit = \"rad/s\" }}\n"
    );
    let source = Source::Map(SignalMap::from_toml(&map).unwrap());
    read(repo("data/demo.mcap").as_ref(), &source, &VehicleOverrides::default(), &|_| {}).unwrap()
}

#[test]
fn paths_that_foxglove_and_plotjuggler_users_write_find_the_same_speed() {
    let own = detected(repo("data/demo.mcap").as_ref());
    assert!(own.signals.speed.value.len() > 10_000);
    // an element by its place from the front and from the back, a slice of one, and by the joint's name as PlotJuggler shows it
    for path in [
        "/joint_states.velocity[0]",
        "/joint_states.velocity[-2]",
        "/joint_states.velocity[0:0]",
        r#"/joint_states.velocity{name=="front_drive_joint"}"#,
        r#"/joint_states.velocity[:]{name=="front_drive_joint"}"#,
        r#"/joint_states.velocity[:]{name!="front_steer_joint"}"#,
        r#"/joint_states{header.frame_id==""}.velocity[0]"#,
    ] {
        assert_eq!(with_speed(path).signals.speed, own.signals.speed, "{path}");
    }
    assert_eq!(with_speed("/joint_states.velocity[0]").signals.angle, own.signals.angle);
}
