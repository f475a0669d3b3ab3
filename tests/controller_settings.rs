//! Controller files: what `verify` stores and shows of them, and `tune`, which finds one for a vehicle that the default does not serve.
#![allow(clippy::unwrap_used)]

#[path = "common/map_copy.rs"]
mod map_copy;

use map_copy::{copied, run, text};
use pivot_cal::internals::{PhysicalSettings, WorldSettings as World, known_maps};
use pivot_cal::map::{Vehicle, sha256_hex};
use serde_json::Value;
use std::path::Path;

const PIVOTS: [&str; 4] = ["--scenario", "left-90", "--draws", "8"];

fn verdict(maps: &Path) -> Value {
    serde_json::from_str(&text(maps, "verify.json")).unwrap()
}

/// The exact map of the scrubber with another drive, in `maps`.
fn slow_drive(folder: &Path, dead_time_s: f64, lag_s: f64) {
    let vehicle =
        Vehicle { wheelbase_m: 0.92, wheel_radius_m: 0.12, test_angle_deg: 90.0, torque_limit_nm: Some(44.0), torque_full_scale_nm: None };
    let mut world = World::physical(vehicle, PhysicalSettings::default());
    (world.drive.dead_time_s, world.drive.lag_s) = (dead_time_s, lag_s);
    let (table1, table2) = known_maps(&world).unwrap();
    let maps = folder.join("maps");
    std::fs::create_dir(&maps).unwrap();
    std::fs::write(maps.join("table1.json"), table1.to_json().unwrap()).unwrap();
    std::fs::write(maps.join("table2.json"), table2.to_json().unwrap()).unwrap();
    for map in &table2.maps {
        std::fs::write(maps.join(&map.csv.file), map.table().unwrap().to_matrix().to_csv()).unwrap();
    }
}

#[test]
fn a_controller_file_drives_is_stored_with_its_hash_and_shown_everywhere() {
    let (folder, maps) = copied();
    let file = "name = \"calm\"\n[planning]\ncruise_speed_mps = 0.4\n[preview]\nnearest = \"waypoint\"\n";
    std::fs::write(folder.path().join("calm.toml"), file).unwrap();
    let (_, _, errors) = run(folder.path(), &[&["verify"], &PIVOTS[..]].concat());
    let usual = verdict(&maps);
    assert_eq!(usual["controller_settings"]["settings"]["name"], "default", "{errors}");
    let bundled = text(Path::new(env!("CARGO_MANIFEST_DIR")), "data/controllers/default.toml");
    assert_eq!(usual["controller_settings"]["sha256"], sha256_hex(bundled.as_bytes()));

    let (status, said, errors) = run(folder.path(), &["verify", "--controller-settings", "calm.toml"]);
    assert_eq!(status, 0, "{said}{errors}");
    assert!(said.contains("controller: calm (SHA-256 "), "{said}");
    let calm = verdict(&maps);
    let stored = &calm["controller_settings"];
    assert_eq!(stored["sha256"], sha256_hex(file.as_bytes()));
    assert_eq!(stored["settings"]["planning"]["cruise_speed_mps"], 0.4);
    assert_eq!(stored["settings"]["speed_loop"]["proportional_per_s"], 3.0, "a key that is left out");
    let settling = |verdict: &Value| {
        let left = verdict["scenarios"].as_array().unwrap().iter().find(|s| s["name"] == "left-90").unwrap();
        left["metrics"].as_array().unwrap().iter().find(|m| m["metric"] == "settling_time_s").unwrap()["median"].as_f64().unwrap()
    };
    assert!(settling(&calm) > 1.1 * settling(&usual), "{} {}", settling(&calm), settling(&usual));

    assert_eq!(run(folder.path(), &["report"]).0, 0);
    let page = text(&maps, "report.html");
    assert!(
        page.contains("The verdict is about the controller calm")
            && page.contains("planning.cruise_speed_mps")
            && page.contains("default 0.6")
    );
    assert_eq!(run(folder.path(), &["export", "--format", "c,rust,dcm,cdfx,apollo"]).0, 0);
    for name in ["pivot_map.h", "pivot_map.rs", "pivot_map.dcm", "pivot_map.cdfx", "calibration_table.pb.txt"] {
        let exported = text(&maps.join("export"), name);
        assert!(exported.contains(&format!("Controller settings: calm, SHA-256 {}", sha256_hex(file.as_bytes()))), "{name}");
        assert!(exported.contains("cruise_speed_mps 0.4") && exported.contains("nearest waypoint"), "{name}");
    }
}

#[test]
fn a_vehicle_that_mirrors_its_wheel_is_not_judged_in_reverse_gear() {
    let (folder, maps) = copied();
    std::fs::write(folder.path().join("mirror.toml"), "[planning]\nwheel_policy = \"mirror\"\n").unwrap();
    let scenarios = ["--scenario", "right-90", "--scenario", "right-90-mirror", "--scenario", "left-90", "--draws", "4"];
    let (status, said, _) = run(folder.path(), &[&["verify", "--controller-settings", "mirror.toml"], &scenarios[..]].concat());
    assert_eq!(status, 0, "{said}");
    let verdict = verdict(&maps);
    let status: Vec<&str> = verdict["scenarios"].as_array().unwrap().iter().map(|s| s["status"].as_str().unwrap()).collect();
    assert_eq!(status, ["not_tested", "pass", "pass"]);
    assert!(said.contains("the controller's wheel policy is mirror"), "{said}");
}

#[test]
fn a_wrong_controller_file_is_an_error_about_its_line() {
    let (folder, maps) = copied();
    let before = text(&maps, "verify.json");
    std::fs::write(folder.path().join("wrong.toml"), "[speed_loop]\nproportional = 3\n").unwrap();
    for command in [&["verify"][..], &["calibrate", "none.mcap"], &["tune", "--start", "wrong.toml"]] {
        let flags: &[&str] = if command[0] == "tune" { &[] } else { &["--controller-settings", "wrong.toml"] };
        let (status, _, errors) = run(folder.path(), &[command, flags].concat());
        assert_eq!(status, 1, "{errors}");
        assert!(errors.contains("wrong.toml: line 2: unknown field `proportional`") && errors.contains("did you mean"), "{errors}");
    }
    assert_eq!(text(&maps, "verify.json"), before);
    // more pending commands than the controller can keep
    std::fs::write(folder.path().join("late.toml"), "period_s = 0.005\n[additions]\nreaction_s = 0.5\n").unwrap();
    let (status, _, errors) = run(folder.path(), &["verify", "--controller-settings", "late.toml"]);
    assert!(status == 1 && errors.contains("reaction_s is 0.5; allowed: 0 to 64 control periods"), "{errors}");
}

#[test]
fn a_controller_whose_gains_fail_the_gate_even_with_the_perfect_inverse_passes_with_tuned_ones() {
    // the published law with nothing added ends 0.6° off in a chain of turns, with the map as with the perfect inverse
    let (folder, _) = copied();
    let plain = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/controllers/plain.toml");
    let plain = plain.to_str().unwrap();
    let (status, said, errors) = run(folder.path(), &["verify", "--controller-settings", plain, "--scenario", "chained"]);
    assert_eq!(status, 3, "the plain law fails: {said}{errors}");
    let (status, said, errors) = run(folder.path(), &["tune", "--start", plain, "--plan", "keep", "--draws", "20", "--reserve", "0.05"]);
    assert_eq!(status, 0, "{said}{errors}");
    assert!(said.contains("phase margin") && said.contains("speed_loop.proportional_per_s"), "{said}");
    let (status, said, errors) = run(folder.path(), &["verify", "--controller-settings", "maps/controller.toml"]);
    assert_eq!(status, 0, "{said}{errors}");
    assert!(said.contains("controller: tuned for "), "{said}");
}

#[test]
fn a_gate_that_no_gains_keep_is_reported_with_what_limits() {
    let folder = tempfile::tempdir().unwrap();
    slow_drive(folder.path(), 0.05, 0.05);
    let gate = "[[limit]]\nclass = \"turn\"\nmetric = \"heading_error_deg\"\nstatistic = \"p99\"\nat_most = 0.01\n";
    std::fs::write(folder.path().join("gate.toml"), gate).unwrap();
    let (status, said, errors) = run(folder.path(), &["tune", "--gate", "gate.toml", "--draws", "4", "--plan", "keep"]);
    assert_eq!(status, 3, "{said}{errors}");
    assert!(said.contains("NO settings keep the gate") && errors.contains("nothing is written"), "{said}{errors}");
    assert!(said.contains("the perfect inverse of the plant breaks the gate too (final heading error"), "{said}");
    assert!(!folder.path().join("maps/controller.toml").exists());
}
