//! The `record` command at the process boundary, and the demo log that it made.
#![allow(clippy::unwrap_used)]

use assert_cmd::Command;
use predicates::prelude::*;
use std::path::{Path, PathBuf};

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn record(vehicle: &Path, campaign: &Path, output: &Path) -> Command {
    let mut command = Command::cargo_bin("pivot-cal").unwrap();
    command.arg("record").arg("--vehicle").arg(vehicle).arg("--campaign").arg(campaign).arg("-o").arg(output);
    command
}

fn scrubber() -> PathBuf {
    root().join("data/vehicles/scrubber.toml")
}

fn campaign(name: &str) -> PathBuf {
    root().join("data/campaigns").join(name)
}

#[test]
fn the_demo_log_is_what_its_command_makes_byte_for_byte() {
    let folder = tempfile::tempdir().unwrap();
    let output = folder.path().join("demo.mcap");
    record(&scrubber(), &campaign("torque_steps.toml"), &output).assert().success().stdout(predicate::str::contains("64 runs"));
    let demo = std::fs::read(root().join("data/demo.mcap")).unwrap();
    assert!(std::fs::read(&output).unwrap() == demo, "make data/demo.mcap again with the command in data/README.md");
    assert!(demo.len() < 2_000_000, "{} bytes", demo.len());
}

#[test]
fn every_vehicle_drives_every_campaign() {
    let folder = tempfile::tempdir().unwrap();
    for vehicle in ["scrubber.toml", "sweeper.toml"] {
        let output = folder.path().join(vehicle);
        let vehicle = root().join("data/vehicles").join(vehicle);
        record(&vehicle, &campaign("messy.toml"), &output).arg("--json").assert().success().stdout(predicate::function(|text: &str| {
            let report: serde_json::Value = serde_json::from_str(text).unwrap();
            report["report"]["runs"].as_array().unwrap().iter().filter(|run| run["end"] == "emergency_stop").count() == 2
        }));
        assert!(mcap::Summary::read(&std::fs::read(&output).unwrap()).unwrap().is_some());
    }
}

#[test]
fn another_seed_gives_another_log() {
    let folder = tempfile::tempdir().unwrap();
    let output = |name: &str| folder.path().join(name);
    record(&scrubber(), &campaign("messy.toml"), &output("a")).assert().success();
    record(&scrubber(), &campaign("messy.toml"), &output("b")).arg("--seed=9").assert().success();
    assert!(std::fs::read(output("a")).unwrap() != std::fs::read(output("b")).unwrap());
}

#[test]
fn a_misspelt_key_fails_with_its_file_line_and_the_nearest_key_and_writes_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let vehicle = folder.path().join("vehicle.toml");
    std::fs::write(&vehicle, "[vehicle]\nwheelbase = 0.9\nwheel_radius_m = 0.12\n").unwrap();
    let output = folder.path().join("log.mcap");
    record(&vehicle, &campaign("messy.toml"), &output).assert().code(1).stderr(
        predicate::str::contains("vehicle.toml: line 2: unknown field `wheelbase`")
            .and(predicate::str::contains("did you mean `wheelbase_m`?")),
    );
    assert!(!output.exists());
}

#[test]
fn a_missing_file_is_named() {
    let folder = tempfile::tempdir().unwrap();
    record(&scrubber(), Path::new("no-such-campaign.toml"), &folder.path().join("log.mcap"))
        .assert()
        .code(1)
        .stderr(predicate::str::contains("no-such-campaign.toml"));
}
