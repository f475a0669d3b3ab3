//! Which files make which recordings: split bags, folders, patterns, and topics with several channels.
#![allow(clippy::unwrap_used, missing_docs)]

use assert_cmd::Command;
use mcap::Writer;
use mcap::records::MessageHeader;
use pivot_cal::calibrate;
use pivot_cal::calibrate::{LogSource, read_logs};
use pivot_cal::log::{Error, Recording, SignalMap, Source, VehicleOverrides, read};
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::io::Cursor;
use std::ops::Range;
use std::path::{Path, PathBuf};

const START: u64 = 1_700_000_000_000_000_000;
const MAP: &str = "
[vehicle]
wheelbase_m = 0.9
wheel_radius_m = 0.1
[signals]
speed = { path = '/drive.speed_mps' }
torque = { path = '/drive.torque_cmd_nm' }
angle = { path = '/drive.steer_angle_deg', unit = 'deg' }
gear = { path = '/gear.gear' }
";

/// The messages `numbers` of a drive, 10 ms apart: two torque steps; only message 0 has the gear.
fn log(numbers: Range<u64>) -> Vec<u8> {
    let mut writer = Writer::new(Cursor::new(Vec::new())).unwrap();
    let drive = writer.add_channel(0, "/drive", "json", &BTreeMap::new()).unwrap();
    let gear = writer.add_channel(0, "/gear", "json", &BTreeMap::new()).unwrap();
    for number in numbers {
        let header = |channel_id| MessageHeader { channel_id, sequence: 0, log_time: START + number * 10_000_000, publish_time: 0 };
        if number == 0 {
            writer.write_to_known_channel(&header(gear), br#"{"gear":"D"}"#).unwrap();
        }
        let torque = if (200..900).contains(&number) { 12 } else { 0 };
        let speed = 0.001 * number.clamp(200, 900) as f64 - 0.2;
        let text = format!(r#"{{"speed_mps":{speed},"torque_cmd_nm":{torque},"steer_angle_deg":90.5}}"#);
        writer.write_to_known_channel(&header(drive), text.as_bytes()).unwrap();
    }
    writer.finish().unwrap();
    writer.into_inner().into_inner()
}

/// A rosbag2 folder: its files cut the step in the middle, and `metadata.yaml` lists them.
fn bag(folder: &Path, parts: &[Range<u64>]) {
    let mut listed = String::from("rosbag2_bagfile_information:\n  version: 9\n  storage_identifier: mcap\n  relative_file_paths:\n");
    for (number, part) in parts.iter().enumerate() {
        std::fs::write(folder.join(format!("drive_{number}.mcap")), log(part.clone())).unwrap();
        writeln!(listed, "    - drive_{number}.mcap").unwrap();
    }
    std::fs::write(folder.join("metadata.yaml"), listed + "  duration:\n    nanoseconds: 1\n").unwrap();
}

fn source() -> Source {
    Source::Map(SignalMap::from_toml(MAP).unwrap())
}

fn read_folder(folder: &Path) -> calibrate::Result<Vec<Recording>> {
    read_logs(&[folder.to_owned()], &LogSource { signals: source(), ..LogSource::default() }, &|_| {})
}

fn joined(folder: &Path) -> Recording {
    let mut found = read_folder(folder).unwrap();
    assert_eq!(found.len(), 1);
    found.remove(0)
}

#[test]
fn the_files_of_a_bag_are_one_recording_in_the_order_of_its_metadata() {
    let folder = tempfile::tempdir().unwrap();
    bag(folder.path(), &[0..500, 500..640, 640..1200]);
    let whole = folder.path().join("whole.mcap"); // not listed, so not read
    std::fs::write(&whole, log(0..1200)).unwrap();
    let (one, many) = (read(&whole, &source(), &VehicleOverrides::default(), &|_| {}).unwrap(), joined(folder.path()));
    assert_eq!(many.signals, one.signals);
    assert_eq!(many.loss.messages_read, one.loss.messages_read);
    assert_eq!(many.source.file, "drive_0.mcap … drive_2.mcap");
    assert_eq!(many.signals.gear.unwrap().len(), 1);
}

#[test]
fn a_file_of_a_bag_without_messages_is_skipped_with_a_note() {
    let folder = tempfile::tempdir().unwrap();
    bag(folder.path(), &[0..0, 0..700, 700..1200, 0..0]);
    let recording = joined(folder.path());
    assert_eq!(recording.signals.speed.len(), 1200);
    assert_eq!(recording.notes.iter().filter(|note| note.contains("is skipped")).count(), 2, "{:?}", recording.notes);
}

#[test]
fn a_bag_without_any_message_is_an_error() {
    let folder = tempfile::tempdir().unwrap();
    bag(folder.path(), &[0..0, 0..0]);
    let calibrate::Error::About { source, .. } = read_folder(folder.path()).unwrap_err() else { panic!("the folder is not named") };
    assert!(matches!(*source, calibrate::Error::Log(Error::NoMessages { .. })), "{source:?}");
}

#[test]
fn damage_in_one_file_of_a_bag_costs_nothing_of_the_others() {
    let folder = tempfile::tempdir().unwrap();
    bag(folder.path(), &[0..500, 500..1200]);
    let first = folder.path().join("drive_0.mcap");
    let bytes = std::fs::read(&first).unwrap();
    std::fs::write(&first, &bytes[..bytes.len() - 40]).unwrap();
    let recording = joined(folder.path());
    assert!(recording.loss.is_damaged());
    assert_eq!(recording.signals.speed.len(), 1200);
}

/// The document of `inspect --runs --json`.
fn inspect(folder: &Path, logs: &[&Path]) -> serde_json::Value {
    let map = folder.join("signals.toml");
    std::fs::write(&map, MAP).unwrap();
    let mut command = Command::cargo_bin("pivot-cal").unwrap();
    let output = command.args(["inspect", "--json", "--runs", "--signals"]).arg(&map).args(logs).assert().success();
    serde_json::from_slice(&output.get_output().stdout).unwrap()
}

#[test]
fn a_run_that_a_files_border_cuts_is_one_run() {
    let folder = tempfile::tempdir().unwrap();
    bag(folder.path(), &[0..500, 500..1200]);
    let document = inspect(folder.path(), &[folder.path()]);
    let logs = document["logs"].as_array().unwrap();
    assert_eq!(logs.len(), 2);
    assert!(logs[0].get("runs").is_none());
    let runs = logs[1]["runs"]["runs"].as_array().unwrap();
    let steps: Vec<f64> = runs.iter().filter(|run| run["torque_nm"] == 12.0).map(|run| run["duration_s"].as_f64().unwrap()).collect();
    assert_eq!(steps.len(), 1, "{runs:?}");
    assert!((steps[0] - 7.0).abs() < 0.02, "{steps:?}");
}

#[test]
fn a_folder_and_a_pattern_are_several_recordings() {
    let folder = tempfile::tempdir().unwrap();
    for (name, part) in [("a.mcap", 0..1000), ("b.mcap", 0..1100)] {
        std::fs::write(folder.path().join(name), log(part)).unwrap();
    }
    let pattern: PathBuf = folder.path().join("?.mcap");
    for named in [folder.path(), &pattern] {
        let document = inspect(folder.path(), &[named]);
        let counts: Vec<u64> = document["logs"].as_array().unwrap().iter().map(|log| log["messages"].as_u64().unwrap()).collect();
        assert_eq!(counts, [1001, 1101]);
        assert!(document["logs"].as_array().unwrap().iter().all(|log| log["runs"]["runs"].as_array().is_some()));
    }
}

#[test]
fn several_channels_of_one_topic_are_read_as_one() {
    let mut writer = Writer::new(Cursor::new(Vec::new())).unwrap();
    // two publishers of one topic: the same schema, other metadata
    let publisher = |name: &str| BTreeMap::from([("callerid".to_owned(), name.to_owned())]);
    let channels = ["/a", "/b"].map(|name| writer.add_channel(0, "/drive", "json", &publisher(name)).unwrap());
    assert_ne!(channels[0], channels[1]);
    for number in 0..100_u64 {
        let header = MessageHeader {
            channel_id: channels[number as usize % 2],
            sequence: 0,
            log_time: START + number,
            publish_time: START + number,
        };
        let text = format!(r#"{{"speed_mps":{number},"torque_cmd_nm":2,"steer_angle_deg":3}}"#);
        writer.write_to_known_channel(&header, text.as_bytes()).unwrap();
    }
    writer.finish().unwrap();
    let bytes = writer.into_inner().into_inner();
    let recording = pivot_cal::log::read_bytes(bytes, "log.mcap", &source(), &VehicleOverrides::default()).unwrap();
    assert_eq!(recording.signals.speed.value, (0..100).map(f64::from).collect::<Vec<_>>());
}
