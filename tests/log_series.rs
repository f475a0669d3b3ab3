//! Signal maps with series names as PlotJuggler shows them: they mean what the message path beside them means.
#![allow(clippy::unwrap_used, missing_docs)]

use mcap::records::MessageHeader;
use pivot_cal::log::{Recording, SignalMap, Source, VehicleOverrides, read, read_bytes};
use std::fmt::Write as _;
use std::io::Cursor;
use std::path::Path;

/// Signal, message path, series names for the same, and whatever else the map's line holds.
type Line = (&'static str, &'static str, &'static [&'static str], &'static str);

const ROS2: [Line; 6] = [
    (
        "speed",
        r#"/joint_states.velocity{name=="front_drive_joint"}"#,
        &["/joint_states/front_drive_joint/velocity", "/joint_states/velocity[1]", "/joint_states/velocity.1", "/joint_states.velocity/1"],
        "unit = 'rad/s'",
    ),
    (
        "torque",
        "/drive/torque_command.data",
        &["/drive/torque_command/data", "/drive/torque_command", "/drive/torque_command", "/drive/torque_command"],
        "unit = 'N.m'",
    ),
    (
        "angle",
        r#"/eps/joint_states.position{name=="front_steer_joint"}"#,
        &[
            "/eps/joint_states/front_steer_joint/position",
            "/eps/joint_states/position[0]",
            "/eps/joint_states/position.0",
            "/eps/joint_states.position/0",
        ],
        "unit = 'rad'",
    ),
    (
        "yaw_rate",
        "/imu/twist.twist.angular.z",
        &["/imu/twist/twist/angular/z", "/imu/twist.twist/angular/z", "/imu/twist/twist.angular.z", "/imu/twist/twist/angular.z"],
        "unit = 'rad/s'",
    ),
    (
        "gear",
        "/drive/gear.data",
        &["/drive/gear/data", "/drive/gear", "/drive/gear", "/drive/gear"],
        "neutral = 0, forward = 1, reverse = 2",
    ),
    ("estop", "/safety/estop.data", &["/safety/estop/data", "/safety/estop", "/safety/estop", "/safety/estop"], "scale = 1"),
];
const PROTOBUF: [Line; 5] = [
    ("speed", "/drive/state.wheel_speed_mmps", &["/drive/state/wheel_speed_mmps"], "unit = 'mm/s'"),
    ("torque", "/drive/command.torque_nm", &["/drive/command/torque_nm"], "unit = 'N.m'"),
    ("angle", "/eps/state.angle_cdeg", &["/eps/state/angle_cdeg"], "unit = 'cdeg'"),
    ("yaw_rate", "/imu.gyro_dps.z", &["/imu/gyro_dps/z"], "unit = 'deg/s'"),
    ("estop", "/drive/state.safety.estop", &["/drive/state/safety/estop"], "scale = 1"),
];
const JSON: [Line; 5] = [
    ("speed", "/traction.wheel.speed_kmh", &["/traction/wheel/speed_kmh"], "unit = 'km/h'"),
    ("torque", "/command.torque", &["/command/torque"], "unit = 'N.m'"),
    ("angle", "/steering.angle_deg", &["/steering/angle_deg"], "unit = 'deg'"),
    ("yaw_rate", "/imu.gyro[2]", &["/imu/gyro[2]"], "unit = 'deg/s'"),
    ("gear", "/traction.gear", &["/traction/gear"], "neutral = 'N', forward = 'D', reverse = 'R'"),
];

/// Reads `log` with the map that `lines` make; `series`: with which of the names, or with the message path.
fn drive(log: &str, lines: &[Line], series: Option<usize>) -> Result<Recording, pivot_cal::log::Error> {
    let mut map = "[vehicle]\nwheelbase_m = 0.92\nwheel_radius_m = 0.12\n[signals]\n".to_owned();
    for (signal, path, names, rest) in lines {
        let path = series.map_or(*path, |series| names[series]);
        writeln!(map, "{signal} = {{ path = '{path}', {rest} }}").unwrap();
    }
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(log);
    read(&path, &Source::Map(SignalMap::from_toml(&map)?), &VehicleOverrides::default(), &|_| {})
}

#[track_caller]
fn same(log: &str, lines: &[Line]) {
    let paths = drive(log, lines, None).unwrap();
    assert_eq!(paths.origins.len(), lines.len());
    for series in 0..lines[0].2.len() {
        let names = drive(log, lines, Some(series)).unwrap();
        assert_eq!(names.signals, paths.signals, "name {series}");
        assert_eq!(names.notes, paths.notes);
    }
}

#[test]
fn series_names_of_ros_2_mean_their_message_paths() {
    same("mini_ros2.zstd.mcap", &ROS2);
}

#[test]
fn series_names_of_protobuf_mean_their_message_paths() {
    same("mini_protobuf.lz4.mcap", &PROTOBUF);
}

#[test]
fn series_names_of_json_mean_their_message_paths() {
    same("mini_json.zstd.mcap", &JSON);
}

#[test]
fn the_origin_shows_the_path_and_the_name_that_it_was_given_by() {
    let recording = drive("mini_ros2.zstd.mcap", &ROS2, Some(0)).unwrap();
    assert_eq!(recording.origins[0].path, ROS2[0].1);
    assert!(recording.origins[0].reason.contains("/joint_states/front_drive_joint/velocity"), "{}", recording.origins[0].reason);
}

/// The error of a map whose speed is `name`.
fn error(name: &'static str) -> String {
    let names: &'static [&'static str] = Box::leak(Box::new([name]));
    let mut lines = ROS2;
    lines[0].2 = names;
    drive("mini_ros2.zstd.mcap", &lines, Some(0)).unwrap_err().to_string()
}

#[test]
fn a_series_whose_rest_leads_nowhere_names_the_fields_that_there_are() {
    let text = error("/imu/twist/twist/angular/q");
    assert!(text.contains("/imu/twist.twist.angular.q") && text.contains("it has x, y, z"), "{text}");
    let text = error("/joint_states/front_drive_joint/speed");
    assert!(text.contains("speed: path /joint_states.front_drive_joint.speed") && text.contains("velocity"), "{text}");
}

#[test]
fn a_series_of_a_joint_that_no_message_holds_gives_no_value() {
    let text = error("/joint_states/front_drive_jiont/velocity");
    assert!(text.contains("gives no value") && text.contains(r#"{name=="front_drive_jiont"}"#), "{text}");
}

#[test]
fn a_series_of_a_topic_that_the_log_does_not_have_names_the_nearest() {
    let text = error("/joint_stetes/front_drive_joint/velocity");
    assert!(text.contains("no topic") && text.contains("the nearest is /joint_states"), "{text}");
}

#[test]
fn a_topic_alone_that_is_more_than_one_value_asks_for_a_field() {
    let text = error("/imu/twist");
    assert!(text.contains("the message has fields: name one of them") && text.contains("header, twist"), "{text}");
}

#[test]
fn an_optional_signal_whose_topic_is_missing_is_left_out_though_the_front_of_its_name_is_a_topic() {
    for name in ["/joint_states/feedback.data", "/joint_states/left/feedback"] {
        let names: &'static [&'static str] = Box::leak(Box::new([name]));
        let mut lines = ROS2;
        lines[5] = ("torque_feedback", name, names, "unit = 'N.m'");
        let recording = drive("mini_ros2.zstd.mcap", &lines, None).unwrap();
        assert!(recording.signals.torque_feedback.is_none());
        assert!(recording.notes.iter().any(|note| note.contains("torque_feedback is left out")), "{:?}", recording.notes);
    }
}

#[test]
fn json_fields_that_the_first_message_lacks_are_found_by_either_name() {
    let mut writer = mcap::Writer::new(Cursor::new(Vec::new())).unwrap();
    let channel = writer.add_channel(0, "/drive", "json", &std::collections::BTreeMap::new()).unwrap();
    for (time, text) in [(1, r#"{"torque":5,"angle":1}"#), (2, r#"{"torque":5,"angle":1,"wheel/v":0.5,"extra":{"fb":4}}"#)] {
        let header = MessageHeader { channel_id: channel, sequence: 0, log_time: time, publish_time: time };
        writer.write_to_known_channel(&header, text.as_bytes()).unwrap();
    }
    writer.finish().unwrap();
    let bytes = writer.into_inner().into_inner();
    let map = "[vehicle]\nwheelbase_m = 1\nwheel_radius_m = 0.1\n[signals]\nspeed = { path = '/drive.wheel/v' }\ntorque = { path = '/drive/torque' }\nangle = { path = '/drive.angle' }\ntorque_feedback = { path = '/drive/extra/fb' }\n";
    let recording = read_bytes(bytes, "log", &Source::Map(SignalMap::from_toml(map).unwrap()), &VehicleOverrides::default()).unwrap();
    assert_eq!(recording.signals.speed.value, [0.5]);
    assert_eq!(recording.signals.torque.value, [5.0, 5.0]);
    assert_eq!(recording.signals.torque_feedback.unwrap().value, [4.0]);
}
