//! `export`: every form is read back by something that is not ours, and a map that does not fit together is refused.
#![allow(clippy::unwrap_used)]

#[path = "common/map_copy.rs"]
mod map_copy;
#[path = "common/readers.rs"]
mod readers;

use map_copy::{change_table1, change_table2, copied, run, text, with_last_decimal_changed};
use pivot_cal::map::{CellStatus, Gear, Table1File, Table2File, TorqueTable};
use serde_json::Value;
use std::path::Path;

#[track_caller]
fn export(folder: &Path, args: &[&str]) -> String {
    let (status, out, errors) = run(folder, &[&["export"], args].concat());
    assert_eq!(status, 0, "{errors}");
    out
}

/// What a test does to a document.
type Change = fn(&mut Value);

fn tables(maps: &Path) -> Vec<(Gear, TorqueTable)> {
    let file = Table2File::from_json(&text(maps, "table2.json")).unwrap();
    file.maps.iter().map(|map| (map.gear, map.table().unwrap())).collect()
}

/// What a calibration tool read against Table 2: axes, values and units, to the last bit.
fn expect_maps(read: &Value, maps: &Path) {
    for (gear, table) in tables(maps) {
        let found = &read["maps"][format!("PIVOT_MAP_TORQUE_{}", gear.to_string().to_uppercase())];
        let numbers = |v: &Value| v.as_array().unwrap().iter().map(|n| n.as_f64().unwrap()).collect::<Vec<_>>();
        assert_eq!(numbers(&found["rows"]), table.speed_mps().breaks());
        assert_eq!(numbers(&found["columns"]), table.accel_mps2().breaks());
        let values: Vec<f64> = found["values"].as_array().unwrap().iter().flat_map(numbers).collect();
        assert_eq!(values, table.values());
        assert_eq!(found["units"], serde_json::json!(["m/s", "m/s^2", "Nm"]));
    }
    let file = Table2File::from_json(&text(maps, "table2.json")).unwrap();
    assert_eq!(read["constants"]["PIVOT_MAP_DEAD_TIME"], serde_json::json!([file.dead_time_s, "s"]));
    assert_eq!(read["constants"]["PIVOT_MAP_DEAD_BAND_HIGH_FORWARD"], serde_json::json!([file.maps[0].dead_band.high_nm, "Nm"]));
}

/// The lateral compensation as a calibration tool read it: its curve to the last bit, and the settings of its law.
fn expect_lateral(read: &Value, maps: &Path) {
    let file: Value = serde_json::from_str(&text(maps, "lateral_table.json")).unwrap();
    let curve = &read["curves"]["LATERAL_COMPENSATION_ANGLE"];
    assert_eq!((&curve["x"], &curve["values"]), (&file["curve"]["error_m"], &file["curve"]["angle_rad"]));
    assert_eq!(curve["units"], serde_json::json!(["m", "rad"]));
    assert_eq!(read["constants"]["LATERAL_COMPENSATION_THRESHOLD"], serde_json::json!([5.0, "m"]));
    assert_eq!(read["constants"]["LATERAL_COMPENSATION_PERIOD"], serde_json::json!([0.02, "s"]));
}

#[test]
fn dcm_is_read_by_dcmreader() {
    let Some(python) = readers::python(&["dcmReader"], "DCM export") else { return };
    let (folder, maps) = copied();
    export(folder.path(), &["--format", "dcm"]);
    let read = readers::read_with(&python, "dcm.py", &[&maps.join("export/pivot_map.dcm")], "");
    assert_eq!(read["complaints"], serde_json::json!([]));
    expect_maps(&read, &maps);
    expect_lateral(&read, &maps);
}

#[test]
fn cdfx_is_valid_and_read_by_asamint() {
    let Some(python) = readers::python(&["asamint", "lxml"], "CDFX export") else { return };
    let (folder, maps) = copied();
    export(folder.path(), &["--format", "cdfx"]);
    let read = readers::read_with(&python, "cdfx.py", &[&maps.join("export/pivot_map.cdfx")], "");
    assert_eq!(read["valid"], true, "{}", read["errors"]);
    expect_maps(&read, &maps);
    expect_lateral(&read, &maps);
}

#[test]
fn a2l_is_read_by_pya2l_and_names_the_symbols_of_the_c_source() {
    let Some(python) = readers::python(&["asamint", "pya2l"], "A2L export") else { return };
    let (folder, maps) = copied();
    assert_eq!(run(folder.path(), &["invert", "--int16"]).0, 0);
    let arguments = ["--format", "c,a2l", "--int16", "--unverified", "--speed-unit", "km/h"];
    export(folder.path(), &arguments);
    let source = text(&maps.join("export"), "pivot_map.c");
    let read = readers::read_with(&python, "a2l.py", &[&maps.join("export/pivot_map.a2l")], "");
    let file = Table2File::from_json(&text(&maps, "table2.json")).unwrap();
    let raw = file.raw.unwrap();
    for map in &file.maps {
        let found = &read[format!("PIVOT_MAP_TORQUE_{}", map.gear.to_string().to_uppercase())];
        assert_eq!(
            (&found["kind"], &found["order"], &found["type"], &found["unit"]),
            (&"MAP".into(), &"ROW_DIR".into(), &"SWORD".into(), &"Nm".into())
        );
        assert_eq!(found["scale"], serde_json::json!([raw.torque_nm.unwrap().scale, 0.0]));
        let (x, y) = (&found["x"], &found["y"]);
        assert_eq!((&x["unit"], &y["unit"]), (&"m/s^2".into(), &"km/h".into()));
        assert_eq!((&x["count"], &y["count"]), (&map.accel_mps2.len().into(), &map.speed_mps.len().into()));
        assert!((y["scale"][0].as_f64().unwrap() - 3.6 * raw.speed_mps.unwrap().scale).abs() < 1e-12);
        assert!((y["limits"][1].as_f64().unwrap() - 3.6 * map.speed_mps.last().unwrap()).abs() < 1e-9);
        for symbol in [&found["symbol"], &x["symbol"], &y["symbol"]] {
            assert!(source.contains(&format!("static const pivot_map_stored {}[", symbol.as_str().unwrap())), "{symbol}");
        }
    }
}

#[test]
fn units_of_the_user_are_in_dcm_and_cdfx_and_refused_where_a_form_has_its_own() {
    let (folder, maps) = copied();
    let units = ["--speed-unit", "rpm", "--torque-unit", "A", "--torque-scale", "2.2"];
    export(folder.path(), &[&["--format", "dcm,cdfx"][..], &units].concat());
    let exported = maps.join("export");
    assert!(text(&exported, "pivot_map.dcm").contains("EINHEIT_Y \"rpm\"\n   EINHEIT_W \"A\""));
    assert!(text(&exported, "pivot_map.cdfx").contains("<UNIT-DISPLAY-NAME>rpm</UNIT-DISPLAY-NAME>"));
    for (arguments, why) in [
        (&["--format", "json", "--speed-unit", "km/h"][..], "json has units of its own"),
        (&["--format", "c", "--speed-unit", "N.m"], "allowed: m/s, km/h"),
        (&["--format", "c", "--torque-unit", "A"], "--torque-scale"),
        (&["--format", "c", "--torque-unit", "%", "--torque-full-scale", "-1"], "--torque-full-scale"),
    ] {
        let (status, _, errors) = run(folder.path(), &[&["export"], arguments].concat());
        assert!(status == 1 && errors.contains(why), "{arguments:?}: {errors}");
    }
}

#[test]
fn json_files_keep_their_published_schemas() {
    let Some(python) = readers::python(&["jsonschema"], "JSON Schemas") else { return };
    let (folder, maps) = copied();
    export(folder.path(), &["--format", "json"]);
    let verdict = text(&maps, "verify.json");
    std::fs::remove_file(maps.join("verify.json")).unwrap();
    export(folder.path(), &["--format", "json", "--unverified", "-o", "unverified"]);
    std::fs::write(maps.join("verify.json"), verdict).unwrap();
    let schema = |name: &str| Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/schema").join(format!("{name}.schema.json"));
    let exported = maps.join("export");
    assert_eq!(text(&exported, "pivot_map.json"), text(&maps, "table2.json"));
    let mut files: Vec<_> = ["table1", "table2", "verify"].map(|name| (schema(name), maps.join(format!("{name}.json")))).into();
    files.push((exported.join("pivot_map.schema.json"), exported.join("pivot_map.json")));
    files.push((exported.join("pivot_map.schema.json"), folder.path().join("unverified/pivot_map.json")));
    let sound = files.len();
    // and a schema that lets anything pass would be none
    let breaks: [(&str, &str, Change); 7] = [
        ("table1", "another version", |j| j["format_version"] = 2.into()),
        ("table1", "no noise", |j| drop(j.as_object_mut().unwrap().remove("noise"))),
        ("table1", "text in the matrix", |j| j["maps"][0]["accel_mps2"][3][4] = "0.1".into()),
        ("table2", "an unknown field", |j| j["maps"][0]["extra"] = 1.into()),
        ("table2", "an unknown status", |j| j["maps"][0]["status"][0][0] = "guessed".into()),
        ("table2", "half a hash", |j| j["table1"]["sha256"] = "00f624de".into()),
        ("verify", "no verdict", |j| j["status"] = Value::Null),
    ];
    for (k, (name, _, change)) in breaks.iter().enumerate() {
        let mut json = serde_json::from_str(&text(&maps, &format!("{name}.json"))).unwrap();
        change(&mut json);
        let path = folder.path().join(format!("broken_{k}.json"));
        std::fs::write(&path, json.to_string()).unwrap();
        files.push((schema(name), path));
    }
    let args: Vec<&Path> = files.iter().flat_map(|(schema, file)| [schema.as_path(), file.as_path()]).collect();
    let found = readers::read_with(&python, "schema.py", &args, "");
    for (k, (_, file)) in files.iter().enumerate() {
        let wrong = found[k].as_array().unwrap();
        assert_eq!(wrong.is_empty(), k < sound, "{}: {wrong:?}; broken are {:?}", file.display(), breaks.map(|b| (b.0, b.1)));
    }
}

#[test]
fn autoware_maps_load_by_its_rules_and_hold_table_1() {
    let Some(python) = readers::python(&["numpy"], "Autoware export") else { return };
    let (folder, maps) = copied();
    let printed = export(folder.path(), &["--format", "autoware"]);
    let file = Table1File::from_json(&text(&maps, "table1.json")).unwrap();
    let full_nm = file.vehicle.torque_limit_nm.unwrap();
    assert!(printed.contains(&format!("torque / {full_nm} N·m")), "{printed}");
    let mut args = Vec::new();
    let mut places = Vec::new();
    for (map, infix) in file.maps.iter().zip(["", ".reverse"]) {
        args.extend(["accel_map", "brake_map"].map(|name| maps.join(format!("export/{name}{infix}.csv"))));
        // halfway between two torques of one sign: there the reader's interpolation is Table 1's
        let table = map.table().unwrap();
        let halves = map.torque_nm.windows(2).filter(|pair| pair[0] * pair[1] >= 0.0).map(|pair| 0.5 * (pair[0] + pair[1]));
        let here: Vec<_> = halves.flat_map(|t| map.speed_mps.iter().map(move |v| (*v, t))).collect();
        places.push(here.into_iter().map(|(v, t)| (v, t, table.accel_from_torque_clamped(v, t).unwrap())).collect::<Vec<_>>());
    }
    let asked: Vec<Vec<[f64; 2]>> = places.iter().map(|here| here.iter().map(|p| [p.0, p.2]).collect()).collect();
    let paths: Vec<&Path> = args.iter().map(std::path::PathBuf::as_path).collect();
    let all = readers::read_with(&python, "autoware.py", &paths, &serde_json::to_string(&asked).unwrap());
    for ((map, read), places) in file.maps.iter().zip(all.as_array().unwrap()).zip(&places) {
        let table = map.table().unwrap();
        for ((speed, torque, _), pedal) in places.iter().zip(read["pedals"].as_array().unwrap()) {
            // nine decimals: of a pedal 2e-8 N·m, of an acceleration, at 12 N·m per m/s², 6e-9 N·m
            assert!((pedal.as_f64().unwrap() * full_nm - torque).abs() < 1e-7, "{speed} m/s, {torque} N·m: {pedal}");
        }
        for (pedal, sign) in [("accel", 1.0), ("brake", -1.0)] {
            let number = |v: &Value| v.as_f64().unwrap();
            let torques: Vec<f64> = read[pedal]["rows"].as_array().unwrap().iter().map(|p| sign * number(p) * full_nm).collect();
            let wanted: Vec<f64> = map.torque_nm.iter().copied().filter(|t| sign * t > 0.0).collect();
            assert_eq!(torques.len(), wanted.len() + 1, "{pedal} has a row per torque and the shared one");
            for (i, torque) in torques.iter().enumerate() {
                for (j, speed) in map.speed_mps.iter().enumerate() {
                    assert_eq!(number(&read[pedal]["columns"][j]), *speed);
                    let accel = table.accel_from_torque_clamped(*speed, *torque).unwrap();
                    let found = number(&read[pedal]["values"][i][j]);
                    // nine decimals of acceleration, and of a pedal: 5e-10 of some 44 N·m at 0.08 m/s² per N·m are 2e-9 m/s²
                    assert!((found - accel).abs() < 3e-9, "{pedal} {i} {j}: {found} {accel}");
                }
            }
        }
    }
}

#[test]
fn apollo_looks_up_the_torques_of_table_2_and_no_sign_contradicts() {
    let Some(python) = readers::python(&["google.protobuf", "numpy"], "Apollo export") else { return };
    let (folder, maps) = copied();
    let printed = export(folder.path(), &["--format", "apollo", "--json"]);
    let files: Value = serde_json::from_str(&printed).unwrap();
    let full_nm = Table2File::from_json(&text(&maps, "table2.json")).unwrap().vehicle.torque_limit_nm.unwrap();
    let tables = tables(&maps);
    let places = |table: &TorqueTable| -> Vec<[f64; 2]> {
        let (speeds, accels) = (table.speed_mps().breaks(), table.accel_mps2().breaks());
        speeds.iter().flat_map(|v| accels.iter().map(|a| [*v, *a])).collect()
    };
    let input: Vec<_> = tables.iter().map(|(_, table)| places(table)).collect();
    let paths = ["", ".reverse"].map(|infix| maps.join(format!("export/calibration_table{infix}.pb.txt")));
    let all = readers::read_with(&python, "apollo.py", &[&paths[0], &paths[1]], &serde_json::to_string(&input).unwrap());
    for (((_, table), file), read) in tables.iter().zip(files.as_array().unwrap()).zip(all.as_array().unwrap()) {
        let places = places(table);
        let mut between = 0.0f64;
        for (k, (place, torque)) in places.iter().zip(table.values()).enumerate() {
            let error = (read[k].as_f64().unwrap() / 100.0 * full_nm - torque).abs();
            if place[1] * torque < 0.0 {
                between = between.max(error);
            } else {
                // six decimals of a per cent of 44 N·m are 2.2e-7 N·m; of an acceleration, at 14 N·m per m/s², 7e-6 N·m
                assert!(error < 1e-5, "{place:?}: {error}");
            }
        }
        let note = file["note"].as_str().unwrap();
        assert!(note.ends_with(&format!("at most {between:.3} N·m")), "{note}, found {between}");
    }
}

#[test]
fn apollo_has_one_entry_for_a_limit_and_one_for_a_held_wheel() {
    let Some(python) = readers::python(&["google.protobuf", "numpy"], "Apollo export") else { return };
    let (folder, maps) = copied();
    let mut places = Vec::new();
    change_table2(&maps, |file| {
        let map = &mut file.maps[0];
        let last = map.accel_mps2.len() - 1;
        for j in [last - 1, last] {
            map.torque_nm[5][j] = file.vehicle.torque_limit_nm.unwrap();
            map.status[5][j] = CellStatus::Unreachable;
        }
        for j in 0..map.accel_mps2.len() {
            if map.accel_mps2[j] <= 0.0 {
                map.torque_nm[0][j] = 0.0;
            }
        }
        places = vec![[map.speed_mps[5], map.accel_mps2[last]], [0.0, map.accel_mps2[0]]];
    });
    export(folder.path(), &["--format", "apollo", "--unverified"]);
    let input = serde_json::to_string(&[&places]).unwrap();
    let read = &readers::read_with(&python, "apollo.py", &[&maps.join("export/calibration_table.pb.txt")], &input)[0];
    assert!((read[0].as_f64().unwrap() - 100.0).abs() < 1e-9, "{read}");
    assert_eq!(read[1], 0.0);
}

#[test]
fn what_a_form_cannot_hold_is_refused_and_nothing_is_written() {
    let (folder, maps) = copied();
    let mut speed = 0.0;
    change_table1(&maps, |file| {
        let map = &mut file.maps[0];
        let row = map.torque_nm.iter().position(|t| *t > 0.0).unwrap();
        map.accel_mps2[row][7] = map.accel_mps2[row - 1][7];
        speed = map.speed_mps[7];
    });
    let (status, _, errors) = run(folder.path(), &["export", "--format", "c,autoware"]);
    assert_eq!(status, 1);
    assert!(errors.contains("strictly") && errors.contains(&format!("speed {speed} m/s")), "{errors}");
    assert!(!maps.join("export").exists());

    let (folder, maps) = copied();
    change_table1(&maps, |file| {
        for map in &mut file.maps {
            let kept = map.torque_nm.iter().position(|t| *t >= 0.0).unwrap();
            map.torque_nm.drain(..kept);
            map.accel_mps2.drain(..kept);
            map.std_err_mps2.drain(..kept);
            map.count.drain(..kept);
            map.confidence.drain(..kept);
            map.status.drain(..kept);
        }
    });
    let (status, _, errors) = run(folder.path(), &["export", "--format", "autoware"]);
    assert_eq!(status, 1);
    assert!(errors.contains("braking torques"), "{errors}");
}

#[test]
fn a_damaged_or_mismatched_map_is_refused() {
    let (_folder, maps) = copied();
    let table2 = tables(&maps)[0].1.at(0, 1);
    let table1 =
        Table1File::from_json(&text(&maps, "table1.json")).unwrap().maps.into_iter().map(|m| m.accel_mps2[0][1]).collect::<Vec<_>>();
    let damage = [
        ("table2.csv", table2, "is not the file that"),
        ("table2.json", table2, "holds other numbers than"),
        ("table1.json", table1[0], "is not the file that"),
        ("table1.reverse.csv", table1[1], "is not the file that"),
    ];
    for (name, value, words) in damage {
        let (folder, maps) = copied();
        std::fs::write(maps.join(name), with_last_decimal_changed(&text(&maps, name), value)).unwrap();
        for format in ["c", "rust", "autoware", "apollo", "dcm", "cdfx", "a2l", "json"] {
            let (status, _, errors) = run(folder.path(), &["export", "--format", format]);
            assert_eq!(status, 1, "{format} with another {name}");
            assert!(errors.contains(words) && errors.contains(name), "{errors}");
            assert!(!maps.join("export").exists(), "{format} with another {name} was written");
        }
    }
    let (folder, maps) = copied();
    std::fs::remove_file(maps.join("table2.reverse.csv")).unwrap();
    let (status, _, errors) = run(folder.path(), &["export", "--format", "c"]);
    assert_eq!(status, 1);
    assert!(errors.contains("table2.reverse.csv"), "{errors}");
}

type Spoil = fn(&mut Value);

#[test]
fn a_map_without_a_passed_verdict_is_exported_only_as_unverified_and_every_file_says_so() {
    let formats = "c,rust,autoware,apollo,dcm,cdfx,a2l,json";
    let spoils: [(&str, Spoil); 4] = [
        ("FAIL: ", |v| v["scenarios"][0]["status"] = "fail".into()),
        ("verdict on another map", |v| v["generation"] = "0123456789abcdef".into()),
        ("verdict on another map", |v| v["table2_csv_sha256"][0] = "0".repeat(64).into()),
        ("no verdict on every pivot", |v| v["scenarios"].as_array_mut().unwrap().truncate(3)),
    ];
    let refused = |folder: &Path, maps: &Path, why: &str| {
        let (status, _, errors) = run(folder, &["export", "--format", formats, "-q"]);
        assert_eq!(status, 3, "{why}: {errors}");
        assert!(errors.contains(why) && errors.contains("pivot-cal verify"), "{why}: {errors}");
        assert!(!maps.join("export").exists(), "{why}");
    };
    for (why, spoil) in spoils {
        let (folder, maps) = copied();
        let mut verdict: Value = serde_json::from_str(&text(&maps, "verify.json")).unwrap();
        spoil(&mut verdict);
        std::fs::write(maps.join("verify.json"), verdict.to_string()).unwrap();
        refused(folder.path(), &maps, why);
    }
    let (folder, maps) = copied();
    export(folder.path(), &["--format", formats, "-o", "proven"]);
    std::fs::remove_file(maps.join("verify.json")).unwrap();
    refused(folder.path(), &maps, "there is no verify.json");
    export(folder.path(), &["--format", formats, "--unverified"]);
    let mut files = 0;
    for entry in std::fs::read_dir(maps.join("export")).unwrap() {
        let name = entry.unwrap().file_name().into_string().unwrap();
        let (unverified, proven) = (text(&maps.join("export"), &name), text(&folder.path().join("proven"), &name));
        // the schema of the JSON is no map
        if name != "pivot_map.schema.json" {
            let head = |text: &str| text.chars().take(700).collect::<String>();
            assert!(head(&unverified).contains("UNVERIFIED") && !proven.contains("UNVERIFIED"), "{name}: {}", head(&unverified));
            files += 1;
        }
    }
    assert_eq!(files, 16);
    let c = |folder: &Path| text(folder, "pivot_map.h");
    assert!(c(&folder.path().join("proven")).contains("Verdict: pass: 90 deg only; assumed: scale of the torque."));
    assert!(c(&folder.path().join("proven")).contains("#define PIVOT_MAP_VERIFIED 1"));
    assert!(c(&maps.join("export")).contains("#define PIVOT_MAP_VERIFIED 0"));
    // what the JSON says, the reader of Table 2 reads
    assert!(Table2File::from_json(&text(&maps, "export/pivot_map.json")).unwrap().unverified.is_some());
}

#[test]
fn the_same_map_gives_the_same_bytes_wherever_it_is_written() {
    let (folder, maps) = copied();
    let formats = "c,rust,autoware,apollo,dcm,cdfx,a2l,json";
    export(folder.path(), &["--format", formats]);
    export(folder.path(), &["--format", formats, "-o", "elsewhere/deep"]);
    let names = |path: &Path| {
        let mut names: Vec<_> = std::fs::read_dir(path).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    };
    let (a, b) = (maps.join("export"), folder.path().join("elsewhere/deep"));
    assert_eq!(names(&a), names(&b));
    assert_eq!(
        names(&a),
        [
            "accel_map.csv",
            "accel_map.reverse.csv",
            "brake_map.csv",
            "brake_map.reverse.csv",
            "calibration_table.pb.txt",
            "calibration_table.reverse.pb.txt",
            "lateral_compensation.c",
            "lateral_compensation.h",
            "lateral_compensation.rs",
            "pivot_map.a2l",
            "pivot_map.c",
            "pivot_map.cdfx",
            "pivot_map.dcm",
            "pivot_map.h",
            "pivot_map.json",
            "pivot_map.rs",
            "pivot_map.schema.json"
        ]
    );
    for name in names(&a) {
        assert_eq!(std::fs::read(a.join(&name)).unwrap(), std::fs::read(b.join(&name)).unwrap(), "{name}");
    }
}

#[test]
fn an_unknown_format_is_a_usage_error() {
    let (folder, _) = copied();
    let (status, _, errors) = run(folder.path(), &["export", "--format", "hex"]);
    assert_eq!(status, 2);
    assert!(errors.contains("allowed: c, rust, autoware"), "{errors}");
}
