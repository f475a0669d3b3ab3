//! `check`: one broken rule per test, each reported with its place; sound maps have no finding.
#![allow(clippy::unwrap_used)]

#[path = "common/map_copy.rs"]
mod map_copy;

use map_copy::{change_table1, change_table2, copied, run, text, with_last_decimal_changed};
use pivot_cal::map::Table2File;
use serde_json::Value;
use std::path::Path;

/// Status, and the report on every map.
fn judged(folder: &Path, names: &[&str]) -> (i32, Vec<Value>) {
    let (status, out, errors) = run(folder, &[&["check", "--json"], names].concat());
    assert_eq!(errors, "");
    let document: Value = serde_json::from_str(&out).unwrap();
    let maps = document["maps"].as_array().unwrap().clone();
    assert_eq!(document["sound"], status == 0);
    (status, maps)
}

/// The report on a text.
fn report(name: &str, text: &str) -> Value {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join(name), text).unwrap();
    let (status, maps) = judged(folder.path(), &[name]);
    assert_eq!(status, if maps[0]["sound"] == true { 0 } else { 3 });
    maps[0].clone()
}

/// Rule and place (line, cell) of every finding above a note.
fn findings(report: &Value) -> Vec<(String, Option<u64>, Option<u64>)> {
    let found = report["findings"].as_array().unwrap().iter().filter(|f| f["severity"] != "note");
    found.map(|f| (f["rule"].as_str().unwrap().to_owned(), f["line"].as_u64(), f["column"].as_u64())).collect()
}

fn rules(report: &Value, severity: &str) -> Vec<String> {
    let found = report["findings"].as_array().unwrap().iter().filter(|f| f["severity"] == severity);
    let mut rules: Vec<_> = found.map(|f| f["rule"].as_str().unwrap().to_owned()).collect();
    rules.dedup();
    rules
}

#[track_caller]
fn expect(report: &Value, wanted: &[(&str, Option<u64>, Option<u64>)]) {
    let wanted: Vec<_> = wanted.iter().map(|(rule, line, column)| ((*rule).to_owned(), *line, *column)).collect();
    assert_eq!(findings(report), wanted, "{report:#}");
}

/// The only finding's place on the axes.
fn at(report: &Value) -> &str {
    report["findings"][0]["at"].as_str().unwrap()
}

const TABLES: [&str; 6] = ["table1.csv", "table1.json", "table1.reverse.csv", "table2.csv", "table2.json", "table2.reverse.csv"];

#[test]
fn the_committed_maps_are_sound() {
    let (_folder, maps) = copied();
    let (status, reports) = judged(&maps, &TABLES);
    assert_eq!((status, reports.len()), (0, 6));
    for report in &reports {
        assert_eq!(report["findings"], serde_json::json!([]), "{report:#}");
    }
}

#[test]
fn a_row_of_a_lesser_array_that_is_too_short_is_a_finding_and_an_error_of_every_reader() {
    let (folder, maps) = copied();
    change_table1(&maps, |file| {
        file.maps[0].status[2].pop();
    });
    let (status, reports) = judged(&maps, &["table1.json"]);
    assert_eq!(status, 3);
    expect(&reports[0], &[("readable", None, None)]);
    let what = reports[0]["findings"][0]["what"].as_str().unwrap();
    assert!(what.starts_with("maps[0].status[2] has "), "{what}");
    for args in [&["report"][..], &["invert"], &["plan"], &["verify"], &["export", "--format", "c", "-o", "out"]] {
        let (status, _, errors) = run(folder.path(), args);
        assert!(status == 1 && errors.contains(what), "{args:?}: {errors}");
    }
    change_table2(&maps, |file| {
        file.maps[0].reachable_accel_mps2.pop();
    });
    let (_, reports) = judged(&maps, &["table2.json"]);
    let what = reports[0]["findings"][0]["what"].as_str().unwrap();
    assert!(what.starts_with("maps[0].reachable_accel_mps2 has "), "{what}");
}

#[test]
fn an_edited_csv_is_a_hash_mismatch_wherever_it_shows() {
    let (_folder, maps) = copied();
    let value = Table2File::from_json(&text(&maps, "table2.json")).unwrap().maps[0].torque_nm[0][1];
    let edited = with_last_decimal_changed(&text(&maps, "table2.csv"), value);
    std::fs::write(maps.join("table2.csv"), edited).unwrap();
    let (status, reports) = judged(&maps, &["table2.csv", "table2.json", "table2.reverse.csv"]);
    assert_eq!(status, 3);
    expect(&reports[0], &[("hash_mismatch", None, None)]);
    expect(&reports[1], &[("hash_mismatch", None, None)]);
    assert_eq!(at(&reports[1]), "forward gear");
    expect(&reports[2], &[]);
}

#[test]
fn a_table_2_beside_another_table_1_is_a_hash_mismatch() {
    let (_folder, maps) = copied();
    std::fs::write(maps.join("table1.json"), text(&maps, "table1.json") + "\n").unwrap();
    let (_, reports) = judged(&maps, &["table1.json", "table2.json"]);
    expect(&reports[0], &[]);
    expect(&reports[1], &[("hash_mismatch", None, None)]);
}

/// A small sound Table 1 and Table 2 without JSON.
const TABLE1: &str = "torque_nm\\speed_mps,0,0.5,1\n-8,-1,-1.1,-1.2\n0,-0.4,-0.5,-0.6\n8,0.2,0.1,0\n16,0.8,0.7,0.6\n";
const TABLE2: &str = "speed_mps\\accel_mps2,-1,0,1\n0,-8,5,18\n0.5,-7,6,19\n1,-6,7,20\n";

#[test]
fn a_csv_alone_is_judged_but_for_what_only_the_json_tells() {
    for (name, text) in [("table1.csv", TABLE1), ("mine.csv", TABLE1), ("table2.csv", TABLE2)] {
        let report = report(name, text);
        expect(&report, &[]);
        assert_eq!(rules(&report, "note"), ["hash_mismatch"], "{report:#}");
    }
}

#[test]
fn every_broken_rule_of_a_csv_is_reported_with_its_line_and_cell() {
    let broken = |table: &str, from: &str, to: &str| {
        assert!(table.contains(from));
        report("mine.csv", &table.replacen(from, to, 1))
    };
    let place = |rule, line, column| (rule, Some(line), Some(column));
    expect(&broken(TABLE1, "speed_mps,0,0.5,1", "speed_mps,0,0.5,0.5"), &[place("axis_order", 1, 4)]);
    expect(&broken(TABLE1, "\n8,", "\n20,"), &[place("axis_order", 5, 1)]);
    expect(&broken(TABLE1, "-0.5,-0.6", "-0.5"), &[("ragged_row", Some(3), None)]);
    expect(&broken(TABLE1, "-1.1", "-1,1x"), &[("ragged_row", Some(2), None), place("not_a_number", 2, 4)]);
    expect(&broken(TABLE1, "0.1", "inf"), &[place("not_a_number", 4, 3)]);
    let report = broken(TABLE1, "0.2,", "-0.45,");
    expect(&report, &[place("not_monotone", 4, 2)]);
    assert_eq!(at(&report), "torque 8, speed 0");
    expect(&broken(TABLE1, "0.2,", "-0.4,"), &[place("plateau", 4, 2)]);
    expect(&broken(TABLE1, "\n0,-0.4", "\n0,0.1"), &[place("coast_positive", 3, 2)]);
    expect(&broken(TABLE1, "-1.2", "0.1"), &[place("not_monotone", 3, 4), place("sign", 2, 4)]);
}

#[test]
fn table_2_has_its_own_directions() {
    let broken = |from: &str, to: &str| report("table2.csv", &TABLE2.replacen(from, to, 1));
    let place = |rule, line, column| (rule, Some(line), Some(column));
    let found = broken("19", "5.5");
    expect(&found, &[place("not_monotone", 3, 4)]);
    assert_eq!(at(&found), "speed 0.5, acceleration 1");
    // a plateau inside the limits; at the largest torque it is the limit
    expect(&broken("-7,6,19", "-7,6,6"), &[place("plateau", 3, 4)]);
    expect(&broken("-6,7,20", "-6,20,20"), &[]);
    // a torque below 0 to hold a speed, or to speed up
    expect(&broken("-8,5,18", "-8,-1,18"), &[place("coast_positive", 2, 3)]);
    expect(&broken("-8,5,18", "-8,-2,-1"), &[place("sign", 2, 4), place("coast_positive", 2, 3)]);
    // a row that holds the wheel is no plateau
    expect(&broken("-8,5,18", "0,0,18"), &[]);
    expect(&broken("speed_mps\\accel", "accel\\accel"), &[place("readable", 1, 1)]);
}

#[test]
fn gaps_of_the_range_are_reported() {
    let found = report("mine.csv", &TABLE1.replace(",0,0.5,1\n", ",0.2,0.5,1\n"));
    expect(&found, &[("range_gap", None, None)]);
    assert_eq!(at(&found), "speed 0 to 0.2");
    let found = report("mine.csv", &TABLE1.replace("\n-8,-1,-1.1,-1.2\n0,-0.4,-0.5,-0.6", ""));
    expect(&found, &[("range_gap", None, None)]);
    // speeds 0, 0.05, 0.1 … and then nothing for a while
    let speeds: Vec<f64> = (0..10).map(|k| f64::from(k) * 0.05).chain([1.4]).collect();
    let row = |torque: f64| speeds.iter().fold(torque.to_string(), |row, v| row + &format!(",{}", 0.05 * torque - 0.4 - 0.1 * v));
    let header = speeds.iter().fold("torque_nm\\speed_mps".to_owned(), |row, v| row + &format!(",{v}"));
    let found = report("mine.csv", &[header, row(-8.0), row(0.0), row(8.0)].join("\n"));
    expect(&found, &[("range_gap", None, None)]);
    assert_eq!(at(&found), "speed 0.45 to 1.4");
}

#[test]
fn one_wrong_cell_of_a_whole_map_is_reported_by_its_jumps_and_by_monotony() {
    let (_folder, maps) = copied();
    let (mut speeds, mut accels) = (Vec::new(), Vec::new());
    change_table2(&maps, |file| {
        let map = &mut file.maps[0];
        map.torque_nm[10][30] += 15.0;
        (speeds, accels) = (map.speed_mps.clone(), map.accel_mps2.clone());
    });
    // the cell, and the ones after it in its row and its column, whose steps begin there
    let place = |i: usize, j: usize| format!("speed {}, acceleration {}", speeds[i], accels[j]);
    let near = [place(10, 30), place(10, 31), place(11, 30)];
    let (status, reports) = judged(&maps, &["table2.csv", "table2.json"]);
    assert_eq!(status, 3);
    for report in &reports {
        assert_eq!(rules(report, "error"), ["not_monotone"], "{report:#}");
        assert_eq!(rules(report, "warning"), ["jump"], "{report:#}");
        let mut places = report["findings"].as_array().unwrap().iter().map(|f| f["at"].as_str().unwrap());
        assert!(places.all(|at| near.iter().any(|n| at.ends_with(n))), "{report:#}");
    }
    let (status, _) = judged(&maps, &["table2.csv", "--slope-bound", "1000"]);
    assert_eq!(status, 3, "not monotone whatever the bound of slopes");
}

#[test]
fn a_map_without_a_dead_band_is_reported() {
    let (_folder, maps) = copied();
    change_table2(&maps, |file| file.maps[1].dead_band.high_nm = 0.0);
    change_table1(&maps, |file| file.maps[0].breakaway.torque_nm = 0.0);
    let (_, reports) = judged(&maps, &["table1.json", "table1.csv", "table1.reverse.csv", "table2.json", "table2.reverse.csv"]);
    let bands = |report: &Value| findings(report).iter().filter(|f| f.0 == "dead_band").count();
    assert_eq!(reports.iter().map(bands).collect::<Vec<_>>(), [1, 1, 0, 1, 1]);
    assert!(at(&reports[0]).starts_with("forward") && at(&reports[3]).starts_with("reverse"));
}

#[test]
fn a_damaged_json_is_judged_as_far_as_it_can_be_read() {
    let (folder, maps) = copied();
    let broken = |name: &str, change: &dyn Fn(&mut Value)| {
        let mut json: Value = serde_json::from_str(&text(&maps, name)).unwrap();
        change(&mut json);
        std::fs::write(maps.join("broken.json"), json.to_string()).unwrap();
        judged(&maps, &["broken.json"]).1.remove(0)
    };
    let found = broken("table1.json", &|j| j["maps"][0]["accel_mps2"][2][3] = Value::Null);
    assert_eq!(rules(&found, "error"), ["not_a_number"]);
    let found = broken("table1.json", &|j| drop(j["maps"][1]["accel_mps2"][2].as_array_mut().unwrap().pop()));
    assert_eq!(rules(&found, "error"), ["ragged_row"]);
    let found = broken("table2.json", &|j| j["maps"][0]["speed_mps"][3] = 0.1.into());
    assert_eq!(rules(&found, "error"), ["axis_order"]);
    let found = broken("table2.json", &|j| j["format_version"] = 9.into());
    assert_eq!(rules(&found, "error"), ["readable"]);
    let found = broken("table2.json", &|j| drop(j.as_object_mut().unwrap().remove("vehicle")));
    assert_eq!(rules(&found, "error"), ["readable"]);
    let found = broken("table2.json", &|j| j["maps"] = serde_json::json!([]));
    assert_eq!(rules(&found, "error"), ["size"]);
    expect(&report("half.json", "{\"format\": \"pivot-cal/ta"), &[("readable", None, None)]);
    expect(&report("verify.json", &text(&maps, "verify.json")), &[("readable", None, None)]);
    std::fs::write(folder.path().join("bytes.csv"), b"\xff\xfe\x00").unwrap();
    assert_eq!(findings(&judged(folder.path(), &["bytes.csv"]).1[0]), [("readable".to_owned(), None, None)]);
}

/// A sound pair of Autoware's form, of a vehicle that creeps.
const ACCEL_MAP: &str = "default, 0.0, 2.0, 5.0\n0, 0.2, -0.1, -0.3\n0.1, 0.6, 0.3, 0.1\n0.5, 2.1, 1.8, 1.4\n";
const BRAKE_MAP: &str = "default, 0.0, 2.0, 5.0\n0, 0.2, -0.1, -0.3\n0.2, -0.6, -0.8, -1.0\n0.8, -3.1, -3.3, -3.5\n";

#[test]
fn autoware_maps_keep_the_rules_of_their_loader() {
    let place = |rule, line, column| (rule, Some(line), Some(column));
    for (name, text) in [("accel_map.csv", ACCEL_MAP), ("brake_map.csv", BRAKE_MAP), ("a.csv", ACCEL_MAP), ("b.csv", BRAKE_MAP)] {
        let report = report(name, text);
        expect(&report, &[]);
        // that it creeps, and has no dead band, are rules of our own maps: notes
        assert_eq!(rules(&report, "note"), ["coast_positive", "dead_band"]);
    }
    expect(&report("accel_map.csv", &ACCEL_MAP.replace("0.6, 0.3", "0.6, -0.2")), &[place("not_monotone", 3, 3)]);
    expect(&report("brake_map.csv", &BRAKE_MAP.replace("-3.3", "-0.7")), &[place("not_monotone", 4, 3)]);
    // neighbours that are equal: this the loader refuses, too
    expect(&report("accel_map.csv", &ACCEL_MAP.replace("2.1,", "0.6,")), &[place("plateau", 4, 2)]);
    expect(&report("accel_map.csv", &ACCEL_MAP.replace(", 1.4", "")), &[("ragged_row", Some(4), None)]);
    expect(&report("accel_map.csv", ""), &[("size", Some(1), None)]);
    expect(&report("accel_map.csv", "default,\n0,\n0.5,\n1.0,\n"), &[("size", Some(1), None)]);
    expect(&report("accel_map.csv", "default,0,1\n0,0.1,0.2\n"), &[("size", Some(1), None)]);
    expect(&report("accel_map.csv", &ACCEL_MAP.replace("\n0, ", "\n0.05, ")), &[("range_gap", None, None)]);
    // the brake as a pedal below 0
    expect(&report("accel_map.csv", "default,0,5\n-1,0.1,-2\n0,0.2,-1\n1,2,1\n"), &[place("sign", 2, 2)]);
}

#[test]
fn an_accel_map_and_its_brake_map_share_their_first_row() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("accel_map.csv"), ACCEL_MAP).unwrap();
    let notes = |brake: &str| {
        std::fs::write(folder.path().join("brake_map.csv"), brake).unwrap();
        let (status, maps) = judged(folder.path(), &["accel_map.csv", "brake_map.csv"]);
        assert_eq!(status, 0);
        let gap = |f: &&Value| f["rule"] == "range_gap";
        maps[0]["findings"].as_array().unwrap().iter().filter(gap).map(|f| f["at"].as_str().unwrap().to_owned()).collect::<Vec<_>>()
    };
    assert!(notes(BRAKE_MAP).is_empty());
    assert_eq!(notes(&BRAKE_MAP.replace("-0.1", "-0.15")), ["pedal 0, speed 2"]);
}

/// A sound table of Apollo's form: 5 speeds of 7 entries, command = 30·(a + 0.3) without contradicting signs.
fn apollo(change: impl Fn(usize, usize, &mut [f64; 3])) -> String {
    let mut text = String::from("# a comment { with a brace\n");
    for i in 0..5 {
        for (j, accel) in [-2.0, -1.0, -0.3, 0.0, 0.5, 1.0, 2.0].into_iter().enumerate() {
            let mut entry = [0.2 * i as f64, accel, 30.0 * (accel + 0.3)];
            change(i, j, &mut entry);
            let [speed, accel, command] = entry;
            text.push_str(&["calibration {\n  speed: ", &speed.to_string(), "\n  acceleration: ", &accel.to_string()].concat());
            text.push_str(&["\n  command: ", &command.to_string(), "\n}\n"].concat());
        }
    }
    text
}

#[test]
fn apollo_tables_are_counted_by_speed_row_and_entry() {
    expect(&report("table.pb.txt", &apollo(|_, _, _| {})), &[]);
    // inside a control configuration
    let text = format!("lon_controller_conf {{\n  ts: 0.01\n  calibration_table {{\n{}}}\n}}\n", apollo(|_, _, _| {}));
    let found = report("control_conf.pb.txt", &text);
    expect(&found, &[]);
    assert_eq!(found["size"], "35 entries at 5 speeds");

    let found = report(
        "table.pb.txt",
        &apollo(|i, j, e| {
            if i != 2 && j == 5 {
                e[2] = 20.0; // below the 24 of the entry before
            }
        }),
    );
    assert_eq!(
        found["counts"][0],
        serde_json::json!({"rule": "not_monotone", "severity": "error", "findings": 4, "of": 5, "unit": "speed rows"})
    );
    assert_eq!(found["findings"][1]["at"], "speed 0.2");

    let found = report(
        "table.pb.txt",
        &apollo(|i, j, e| {
            if j == 2 && i < 3 {
                e[2] = -2.0;
            }
            if j == 3 && i < 3 {
                (e[1], e[2]) = (0.1, -1.0); // the brake for an acceleration: still rising with it
            }
            if j == 2 && i > 2 {
                (e[1], e[2]) = (-0.2, 3.0);
            }
        }),
    );
    assert_eq!(found["counts"][0], serde_json::json!({"rule": "sign", "severity": "error", "findings": 5, "of": 35, "unit": "entries"}));
    assert_eq!(rules(&found, "error"), ["sign"]);

    let found = report(
        "table.pb.txt",
        &apollo(|i, j, e| {
            if i == 1 && j == 6 {
                e[2] = 39.0; // as the entry before
            }
            if i == 3 && j == 6 {
                e[1] = 1.0;
            }
        }),
    );
    assert_eq!(rules(&found, "warning"), ["duplicate", "plateau"]);
    let found = report("table.pb.txt", &apollo(|_, _, _| {}).replacen("command: -51", "command: -5l", 1));
    assert_eq!(rules(&found, "error"), ["readable", "not_a_number"]);
    expect(&report("table.pb.txt", "calibration_table { }\n"), &[("size", Some(1), None)]);
}

#[test]
fn long_form_csv_is_judged_like_a_torque_map() {
    let sound = "torque_nm,speed_mps,accel_mps2\n-8,0,-1\n4,0,-0.2\n8,0,0.2\n-8,0.5,-1.1\n8,0.5,0.1\n";
    let found = report("points.csv", sound);
    expect(&found, &[]);
    assert_eq!(found["format"], "long-form CSV");
    expect(&report("points.csv", &sound.replace("4,0,-0.2", "-9,0,-0.2")), &[("not_monotone", Some(3), None)]);
    expect(&report("points.csv", &sound.replace("-8,0.5,-1.1", "-8,0.5,0.05")), &[("sign", Some(5), None)]);
    expect(&report("points.csv", &sound.replace("4,0,", "4,,")), &[("not_a_number", Some(3), Some(2))]);
    expect(&report("points.csv", &sound.replace("4,0,-0.2", "4,0")), &[("ragged_row", Some(3), None)]);
    expect(&report("points.csv", "speed,acceleration,command\n"), &[("size", Some(1), None)]);
}

#[test]
fn people_see_counts_and_the_first_places() {
    let (_folder, maps) = copied();
    std::fs::write(maps.join("mine.csv"), TABLE1.replacen("0.2,", "-0.45,", 1)).unwrap();
    let (status, out, _) = run(&maps, &["check", "mine.csv", "table1.csv"]);
    assert_eq!(status, 3);
    assert!(out.contains("mine.csv: Table 1 (CSV), 4 × 3 (torque × speed): FINDINGS"), "{out}");
    assert!(
        out.contains("error not monotone: 1 of 9 steps\n    line 4, cell 2, torque 8, speed 0: -0.45 is below the value before it (-0.4)"),
        "{out}"
    );
    assert!(out.lines().any(|l| l.starts_with("table1.csv: Table 1 (CSV), ") && l.ends_with(" (torque × speed): sound")), "{out}");
    assert_eq!(run(&maps, &["check", "-q", "mine.csv"]).1, "");
}

#[test]
fn a_file_that_is_not_there_is_an_error() {
    let (folder, _) = copied();
    let (status, _, errors) = run(folder.path(), &["check", "none.csv"]);
    assert_eq!(status, 1);
    assert!(errors.contains("none.csv"), "{errors}");
    assert_eq!(run(folder.path(), &["check"]).0, 2);
}
