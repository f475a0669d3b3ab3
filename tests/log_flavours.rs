//! The same drive, logged in four flavours by third-party writers: the signals must agree within their quantisation.
#![allow(clippy::unwrap_used, missing_docs)]

use pivot_cal::log::{Depth, Preset, Recording, Signal, SignalMap, SignalName, Source, VehicleOverrides, read, survey};
use std::path::{Path, PathBuf};

const ROS2: (&str, &str) = ("mini_ros2.zstd.mcap", "reference.toml");
const AUTOWARE: (&str, &str) = ("mini_autoware.zstd.mcap", "reference_autoware.toml");
const PROTOBUF: (&str, &str) = ("mini_protobuf.lz4.mcap", "reference_protobuf.toml");
const JSON: (&str, &str) = ("mini_json.zstd.mcap", "reference_json.toml");
const RAD_PER_DEG: f64 = std::f64::consts::PI / 180.0;

fn file(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(name)
}

fn drive((log, map): (&str, &str)) -> Recording {
    let map = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("data/signals").join(map)).unwrap();
    let source = Source::Map(SignalMap::from_toml(&map).unwrap());
    read(&file(log), &source, &VehicleOverrides::default(), &|_| {}).unwrap()
}

/// Expects equal times, and values that are at most `tolerance` apart.
#[track_caller]
fn same(a: &Signal, b: &Signal, tolerance: f64) {
    assert_eq!(a.time_ns, b.time_ns);
    for (a, b) in a.value.iter().zip(&b.value) {
        assert!((a - b).abs() <= tolerance, "{a} and {b} differ by more than {tolerance}");
    }
}

/// The value that held at `time_ns`, in the signal that is logged on another message.
fn held(signal: &Signal, time_ns: i64) -> Option<f64> {
    let next = signal.time_ns.partition_point(|time| *time <= time_ns);
    next.checked_sub(1).map(|index| signal.value[index])
}

#[test]
fn protobuf_gives_the_signals_of_ros2() {
    let (ros, proto) = (drive(ROS2), drive(PROTOBUF));
    same(&ros.signals.speed, &proto.signals.speed, 0.5e-3 + 1e-9); // whole mm/s
    same(&ros.signals.torque, &proto.signals.torque, 1e-9);
    same(&ros.signals.angle, &proto.signals.angle, 0.005 * RAD_PER_DEG + 1e-9); // hundredths of a degree
    same(ros.signals.yaw_rate.as_ref().unwrap(), proto.signals.yaw_rate.as_ref().unwrap(), 1e-5);
}

#[test]
fn json_gives_the_signals_of_ros2() {
    let (ros, json) = (drive(ROS2), drive(JSON));
    same(&ros.signals.speed, &json.signals.speed, 0.5e-5 / 3.6 + 1e-9); // five decimals of a km/h
    same(&ros.signals.torque, &json.signals.torque, 0.05 + 1e-9);
    same(&ros.signals.angle, &json.signals.angle, 0.05 * RAD_PER_DEG); // tenths of a degree
    same(ros.signals.yaw_rate.as_ref().unwrap(), json.signals.yaw_rate.as_ref().unwrap(), 0.5e-4 * RAD_PER_DEG + 1e-9);
}

#[test]
fn autoware_gives_the_signals_of_ros2() {
    let (ros, autoware) = (drive(ROS2), drive(AUTOWARE));
    same(&ros.signals.torque, &autoware.signals.torque, 1e-5); // 32-bit floats, forward gear
    same(&ros.signals.angle, &autoware.signals.angle, 1e-6);
    same(ros.signals.yaw_rate.as_ref().unwrap(), autoware.signals.yaw_rate.as_ref().unwrap(), 1e-6);
    let speed = &autoware.signals.speed;
    assert!(speed.unsigned && autoware.signals.torque.relative_to_gear);
    // logged on the traction message: a magnitude, between the encoder's values around it
    let apart =
        speed.time_ns.iter().zip(&speed.value).filter_map(|(time, value)| Some((held(&ros.signals.speed, *time)?.abs() - value).abs()));
    let mut apart: Vec<f64> = apart.collect();
    apart.sort_by(f64::total_cmp);
    assert!(apart[apart.len() / 2] < 0.02, "median {}", apart[apart.len() / 2]);
}

#[test]
fn gears_and_emergency_stops_mean_the_same_in_every_flavour() {
    let ros = drive(ROS2);
    for other in [AUTOWARE, PROTOBUF, JSON] {
        let recording = drive(other);
        for (a, b) in [(&ros.signals.gear, &recording.signals.gear), (&ros.signals.estop, &recording.signals.estop)] {
            let (a, b) = (a.as_ref().unwrap(), b.as_ref().unwrap());
            let pairs = b.time_ns.iter().zip(&b.value).filter_map(|(time, value)| Some((held(a, *time)?, *value)));
            let (all, different) = pairs.fold((0, 0), |(all, different), (a, b)| (all + 1, different + u32::from(a != b)));
            // a change shows one message later on the slower topic
            assert!(all > 300 && different * 50 < all, "{other:?}: {different} of {all}");
        }
    }
}

#[test]
fn no_message_is_lost_and_nothing_is_remarked() {
    for flavour in [ROS2, AUTOWARE, PROTOBUF, JSON] {
        let recording = drive(flavour);
        assert!(!recording.loss.is_damaged() && recording.loss.messages_lost == Some(0), "{:?}", recording.loss);
        assert_eq!(recording.notes, Vec::<String>::new());
        assert_eq!(recording.origins.len(), 7);
        assert_eq!(recording.source.sha256.len(), 64);
    }
}

#[test]
fn signals_are_found_by_name_in_every_flavour() {
    let vehicle = VehicleOverrides { wheelbase_m: Some(0.92), wheel_radius_m: Some(0.12), ..VehicleOverrides::default() };
    for flavour in [ROS2, AUTOWARE, PROTOBUF, JSON] {
        let (driven, found) = (drive(flavour), read(&file(flavour.0), &Source::Detect, &vehicle, &|_| {}).unwrap());
        for signal in SignalName::ALL {
            let (driven, found) = (driven.signals.get(signal).unwrap(), found.signals.get(signal).unwrap());
            let largest = |signal: &Signal| signal.value.iter().fold(0.0_f64, |sum, value| sum.max(value.abs()));
            assert!((largest(driven) - largest(found)).abs() <= 0.02 * largest(driven) + 1e-9, "{flavour:?} {signal}");
        }
    }
}

#[test]
fn the_presets_read_the_logs_that_they_are_made_for() {
    let vehicle = VehicleOverrides { wheelbase_m: Some(0.92), wheel_radius_m: Some(0.12), ..VehicleOverrides::default() };
    for (flavour, preset) in [(ROS2, Preset::PivotCal), (ROS2, Preset::JointState), (AUTOWARE, Preset::Autoware)] {
        let recording = read(&file(flavour.0), &Source::Preset(preset), &vehicle, &|_| {}).unwrap();
        assert_eq!(recording.origins.len(), 7, "{preset}");
    }
}

#[test]
fn a_survey_shows_topics_rates_and_signals() {
    let survey = survey(&file(ROS2.0), &Source::Detect, Depth::Everything, &|_| {}).unwrap();
    assert_eq!(survey.messages, Some(13_084));
    assert_eq!(survey.topics.len(), 8);
    assert_eq!(survey.missing, []);
    let yaw = survey.signals.iter().find(|found| found.signal == SignalName::YawRate).unwrap();
    assert!((yaw.rate.unwrap().true_hz - 100.0).abs() < 2.0);
}

#[test]
fn without_vehicle_data_the_error_names_what_is_missing() {
    let error = read(&file(ROS2.0), &Source::Detect, &VehicleOverrides::default(), &|_| {}).unwrap_err().to_string();
    assert!(error.contains("wheelbase_m of the vehicle is not known"), "{error}");
}
