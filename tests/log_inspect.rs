//! `inspect` at the process boundary: what it prints and how it ends.
#![allow(clippy::unwrap_used, missing_docs)]

use assert_cmd::Command;
use std::path::Path;

fn inspect(arguments: &[&str]) -> assert_cmd::assert::Assert {
    Command::cargo_bin("pivot-cal").unwrap().current_dir(env!("CARGO_MANIFEST_DIR")).arg("inspect").args(arguments).assert()
}

fn json(arguments: &[&str]) -> serde_json::Value {
    serde_json::from_slice(&inspect(arguments).success().get_output().stdout).unwrap()
}

#[test]
fn the_summary_names_topics_rates_and_signals() {
    let output = inspect(&["tests/data/mini_ros2.zstd.mcap"]).success();
    let text = String::from_utf8(output.get_output().stdout.clone()).unwrap();
    for part in ["13084 message(s)", "/drive/torque_command", "sensor_msgs/msg/JointState (ros2msg)", "torque_feedback", "50.0 Hz", "zstd"]
    {
        assert!(text.contains(part), "{part} is not in\n{text}");
    }
}

#[test]
fn the_json_document_shows_what_was_read_and_lost() {
    let document = json(&["--json", "--runs", "tests/data"]);
    let logs = document["logs"].as_array().unwrap();
    assert_eq!(logs.len(), 5);
    for log in logs {
        assert_eq!(log["loss"]["messages_lost"], 0);
        assert_eq!(log["loss"]["messages_read"], log["messages"]);
        assert_eq!(log["signals"].as_array().unwrap().len(), 7);
    }
}

#[test]
fn a_wrong_wheelbase_is_an_objection_before_any_fit() {
    let output = inspect(&["--runs", "data/demo.mcap", "--wheelbase-m", "1.2"]).code(3);
    let said = String::from_utf8_lossy(&output.get_output().stdout).into_owned();
    assert!(said.contains("objection encoder-scale") && said.contains("0.90"), "{said}");
    let checks = &json(&["--json", "--runs", "data/demo.mcap"])["logs"][0]["runs"]["checks"];
    assert!(checks.as_array().unwrap().iter().all(|check| check["outcome"] == "passed"), "{checks}");
}

#[test]
fn a_damaged_log_is_a_warning_or_with_strict_a_rejection() {
    let whole = std::fs::read(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/mini_ros2.zstd.mcap")).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("truncated_mid_chunk.mcap");
    std::fs::write(&path, &whole[..whole.len() / 2]).unwrap();
    let path = path.to_str().unwrap();
    let output = inspect(&[path]).success();
    assert!(String::from_utf8_lossy(&output.get_output().stderr).contains("the end of the file is missing"));
    inspect(&["--strict", path]).code(3);
}

#[test]
fn a_file_that_is_no_log_is_an_error_with_its_name() {
    let output = inspect(&["Cargo.toml"]).code(1);
    assert!(String::from_utf8_lossy(&output.get_output().stderr).contains("Cargo.toml: this is not an MCAP log"));
    inspect(&["no_such_file.mcap"]).code(1);
    inspect(&["nothing_*.mcap"]).code(1);
}

#[test]
fn a_slow_value_in_fast_messages_is_found_out() {
    use mcap::records::MessageHeader;
    let mut writer = mcap::Writer::new(std::io::Cursor::new(Vec::new())).unwrap();
    let channel = writer.add_channel(0, "/drive", "json", &std::collections::BTreeMap::new()).unwrap();
    for number in 0..1000_u64 {
        let time = 1_700_000_000_000_000_000 + number * 10_000_000;
        let speed = ((number / 5) as f64 * 0.2).sin();
        let text = format!(r#"{{"wheel_speed_mps":{speed},"torque_cmd_nm":5,"steering_angle_deg":90}}"#);
        let header = MessageHeader { channel_id: channel, sequence: 0, log_time: time, publish_time: time };
        writer.write_to_known_channel(&header, text.as_bytes()).unwrap();
    }
    writer.finish().unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("repeated.mcap");
    std::fs::write(&path, writer.into_inner().into_inner()).unwrap();
    let output = inspect(&["--runs", path.to_str().unwrap()]).success();
    assert!(String::from_utf8_lossy(&output.get_output().stdout).contains("changes at 20.0 Hz only"));
}
