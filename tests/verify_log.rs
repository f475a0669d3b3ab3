//! The logs of `verify --log` before readers that are not ours: the Python packages `mcap`, `mcap-ros2-support` and `rosbags`.
#![allow(clippy::unwrap_used)]

#[path = "common/known_map.rs"]
mod known_map;
#[path = "common/program.rs"]
mod program;
#[path = "common/readers.rs"]
mod readers;

use program::run;
use std::path::Path;

/// Topics of every log with their types. What PlotJuggler, Foxglove and rerun draw without a plug-in: standard ROS 2 messages.
const TOPICS: [(&str, &str); 18] = [
    ("/joint_states", "sensor_msgs/msg/JointState"),
    ("/odom", "nav_msgs/msg/Odometry"),
    ("/drive/torque_command", "std_msgs/msg/Float64"),
    ("/drive/gear", "std_msgs/msg/Int8"),
    ("/safety/estop", "std_msgs/msg/Bool"),
    ("/pivot/speed_actual", "std_msgs/msg/Float64"),
    ("/pivot/speed_desired", "std_msgs/msg/Float64"),
    ("/pivot/accel_actual", "std_msgs/msg/Float64"),
    ("/pivot/accel_desired", "std_msgs/msg/Float64"),
    ("/pivot/wheel_angle_desired", "std_msgs/msg/Float64"),
    ("/pivot/arc", "std_msgs/msg/Float64"),
    ("/pivot/task", "std_msgs/msg/String"),
    ("/pivot/restore", "std_msgs/msg/Bool"),
    ("/pivot/angle_status", "std_msgs/msg/String"),
    ("/pivot/phase", "std_msgs/msg/String"),
    ("/pivot/pivot_flag", "std_msgs/msg/Bool"),
    ("/pivot/direction_flag", "std_msgs/msg/Int8"),
    ("/pivot/waypoints", "std_msgs/msg/String"),
];

/// The log of a scenario's nominal run.
fn log(name: &str) -> Vec<u8> {
    let folder = tempfile::tempdir().unwrap();
    known_map::save(folder.path());
    let (status, _, errors) = run(folder.path(), &["verify", "--maps", ".", "--scenario", name, "--draws", "1", "--log", "logs", "-q"]);
    assert!(status == 0 || status == 3, "{errors}");
    let logs = folder.path().join("logs");
    assert_eq!(std::fs::read_dir(&logs).unwrap().count(), 1);
    std::fs::read(logs.join(format!("{name}.mcap"))).unwrap()
}

#[test]
fn three_foreign_readers_see_every_message_with_its_type_in_order_of_time() {
    let Some(python) = readers::python(&["mcap", "mcap_ros2", "rosbags"], "the logs of verify before foreign readers") else { return };
    let folder = tempfile::tempdir().unwrap();
    for (name, turned_deg) in [("left-90", 90.0), ("right-90", -90.0), ("chained", 180.0), ("stop-driving", f64::NAN)] {
        let bytes = log(name);
        let path = folder.path().join(format!("{name}.mcap"));
        std::fs::write(&path, &bytes).unwrap();
        let seen = readers::read_with(&python, "verify_log.py", &[Path::new(&path)], "");
        let ours = mcap::MessageStream::new(&bytes).unwrap().count();
        assert_eq!(seen["statistics"], ours, "{name}");
        assert_eq!((seen["profile"].as_str(), seen["ordered"].as_bool()), (Some("ros2"), Some(true)), "{name}");
        assert_eq!(seen["metadata"]["pivot-cal/scenario"]["name"], name);
        let topics = seen["topics"].as_object().unwrap();
        let mut counted = 0;
        for (topic, found) in topics {
            let expected = TOPICS.iter().find(|(t, _)| t == topic).unwrap_or_else(|| panic!("{name}: {topic} was not expected"));
            assert_eq!((found["schema"].as_str(), found["encoding"].as_str()), (Some(expected.1), Some("ros2msg")), "{name} {topic}");
            assert_eq!(found["monotone"], true, "{name} {topic}");
            let messages = found["messages"].as_u64().unwrap();
            assert_eq!(seen["ros2"][topic], messages, "{name} {topic}: mcap-ros2-support");
            assert_eq!(seen["rosbags"][topic], messages, "{name} {topic}: rosbags");
            counted += messages;
        }
        assert_eq!(counted, ours as u64, "{name}");
        assert_eq!(topics.len(), TOPICS.len(), "{name}: {:?}", topics.keys());
        assert_eq!(seen["frames"], serde_json::json!([["odom", "base_link"]]), "{name}");
        assert_eq!(seen["joints"], serde_json::json!(["front_steer_joint", "front_drive_joint"]), "{name}");
        if turned_deg.is_finite() {
            let off_deg = (seen["final_heading_deg"].as_f64().unwrap() - turned_deg + 540.0).rem_euclid(360.0) - 180.0;
            assert!(off_deg.abs() < 1.5, "{name}: {off_deg}°");
        }
    }
}

#[test]
fn the_messages_between_the_modules_are_in_the_log() {
    let bytes = log("right-90");
    let of = |topic: &str| -> Vec<Vec<u8>> {
        let all = mcap::MessageStream::new(&bytes).unwrap().map(|m| m.unwrap());
        all.filter(|m| m.channel.topic == topic).map(|m| m.data.to_vec()).collect()
    };
    // CDR: four bytes of header; a string's length with its final zero, then its text
    let text = |data: &[u8]| String::from_utf8(data[8..data.len() - 1].to_vec()).unwrap();
    let phases: Vec<String> = of("/pivot/phase").iter().map(|d| text(d)).collect();
    assert_eq!(phases, ["Idle", "WaitingForAngle", "SettingGear", "Driving", "WaitingForStandstill", "RestoringAngle", "Succeeded"]);
    let tasks: Vec<String> = of("/pivot/task").iter().map(|d| text(d)).collect();
    assert_eq!(tasks, ["rest", "hold 90.00°", "restore 0.00°"]);
    // planning to longitudinal: the pivot flag, the direction flag 3 for right, the waypoints
    assert_eq!((of("/pivot/pivot_flag")[0][4], of("/pivot/direction_flag")[0][4]), (1, 3));
    let waypoints = text(&of("/pivot/waypoints")[0]);
    // 90° of 0.92 m are 1.445 m: 74 waypoints every 0.02 m; they begin where the wheel is seen, at the plan's start speed, and end at rest
    let rows: Vec<&str> = waypoints.lines().collect();
    assert_eq!((rows[0], rows.len()), ("x_m,y_m,speed_mps", 75), "{waypoints}");
    assert!(rows[1].starts_with("0.9") && rows[1].ends_with(",0.1000") && rows[74].ends_with(",0.0000"), "{waypoints}");
}
