//! A map that was exported, changed in another tool, and comes back: every format is read, what was changed is found, and it is judged.
#![allow(clippy::unwrap_used)]

#[path = "common/map_copy.rs"]
mod map_copy;

use map_copy::{copied, run, text};
use pivot_cal::map::{Table2File, TorqueMap};
use serde_json::Value;
use std::path::{Path, PathBuf};

/// The cells that `diff --edited` finds in a file; 44 N·m are 100 % where the file does not say it.
#[track_caller]
fn edited(folder: &Path, file: &Path) -> Value {
    let (status, out, errors) = run(folder, &["diff", "--edited", "maps", file.to_str().unwrap(), "--torque-full-scale", "44", "--json"]);
    assert!(errors.is_empty(), "{errors}");
    let found: Value = serde_json::from_str(&out).unwrap();
    let of_table1 = found["accel_cells"].as_array().map_or(0, Vec::len);
    let cells = found["cells"].as_array().unwrap().len() + of_table1;
    assert_eq!(status, if cells == 0 { 0 } else { 3 });
    found
}

fn forward(maps: &Path) -> TorqueMap {
    Table2File::from_json(&text(maps, "table2.json")).unwrap().maps.remove(0)
}

/// A spreadsheet's form of the map: semicolons, decimal commas, a byte-order mark, and only six decimals.
fn spreadsheet(map: &TorqueMap) -> String {
    let comma = |v: &f64| v.to_string().replace('.', ",");
    let mut text = format!("\u{feff}speed_mps\\accel_mps2;{}\r\n", map.accel_mps2.iter().map(comma).collect::<Vec<_>>().join(";"));
    for (speed, row) in map.speed_mps.iter().zip(&map.torque_nm) {
        let row: Vec<String> = row.iter().map(|t| format!("{t:.6}").replace('.', ",")).collect();
        text.push_str(&[comma(speed), row.join(";")].join(";"));
        text.push_str("\r\n");
    }
    text
}

/// Long form in km/h and per cent of 44 N·m, with three decimals.
fn long_form(map: &TorqueMap) -> String {
    let mut text = "torque [%],speed [km/h],acceleration [m/s²]\n".to_owned();
    for (speed, row) in map.speed_mps.iter().zip(&map.torque_nm) {
        for (accel, torque) in map.accel_mps2.iter().zip(row) {
            text.push_str(&[format!("{:.3}", torque / 0.44), format!("{:.6}", 3.6 * speed), format!("{accel}\n")].join(","));
        }
    }
    text
}

#[test]
fn every_format_comes_back_as_it_went_to_the_last_digit() {
    let (folder, maps) = copied();
    let out = |name: &str| maps.join("export").join(name);
    let exports: [&[&str]; 4] = [
        &["--format", "dcm,cdfx,c,rust,autoware,apollo,json"],
        &["--format", "dcm,cdfx,c,rust", "--speed-unit", "km/h", "--torque-unit", "%", "--torque-full-scale", "44", "-o", "percent"],
        &[
            "--format",
            "dcm,c,rust",
            "--speed-unit",
            "raw",
            "--speed-scale",
            "0.0078125",
            "--torque-unit",
            "A",
            "--torque-scale",
            "2.2",
            "-o",
            "raw",
        ],
        &["--format", "c,rust", "--float", "-o", "float"],
    ];
    for arguments in exports {
        let (status, _, errors) = run(folder.path(), &[&["export"], arguments].concat());
        assert_eq!(status, 0, "{errors}");
    }
    let map = forward(&maps);
    let csv = [("sheet.csv", spreadsheet(&map)), ("long.csv", long_form(&map))];
    for (name, text) in &csv {
        std::fs::write(folder.path().join(name), text).unwrap();
    }
    let at = |name: &str| folder.path().join(name);
    let files: Vec<(PathBuf, bool)> = vec![
        (out("pivot_map.dcm"), true),
        (out("pivot_map.cdfx"), true),
        (out("pivot_map.c"), true),
        (out("pivot_map.rs"), true),
        (out("accel_map.csv"), false),
        (out("brake_map.csv"), false),
        (out("accel_map.reverse.csv"), false),
        (out("pivot_map.json"), true),
        (out("calibration_table.pb.txt"), false),
        (out("calibration_table.reverse.pb.txt"), false),
        (at("percent/pivot_map.dcm"), true),
        (at("percent/pivot_map.cdfx"), true),
        (at("percent/pivot_map.c"), true),
        (at("percent/pivot_map.rs"), true),
        (at("raw/pivot_map.dcm"), true),
        (at("raw/pivot_map.c"), true),
        (at("raw/pivot_map.rs"), true),
        (maps.join("table2.csv"), false),
        (maps.join("table2.reverse.csv"), false),
        (at("sheet.csv"), false),
        (at("long.csv"), false),
    ];
    for (file, whole) in files {
        let found = edited(folder.path(), &file);
        assert_eq!(found["cells"], serde_json::json!([]), "{}", file.display());
        assert_eq!(found.get("accel_cells"), None, "{}", file.display());
        assert_eq!(found["outside"], 0, "{}", file.display());
        let compared = found["compared"].as_u64().unwrap() as usize;
        assert!(compared > if whole { map.torque_nm.concat().len() } else { 300 }, "{}: {compared}", file.display());
    }
    // single precision has its own digits
    for name in ["float/pivot_map.c", "float/pivot_map.rs"] {
        let found = edited(folder.path(), &at(name));
        let number = |cell: &Value, key: &str| cell[key].as_f64().unwrap();
        let changes = found["cells"].as_array().unwrap().iter().map(|c| (number(c, "edited_nm") - number(c, "measured_nm")).abs());
        assert!(changes.fold(0.0, f64::max) < 3e-6, "{name}");
    }
}

#[test]
fn a_cell_that_a_person_changed_is_found_in_every_format_with_its_reported_errors() {
    let (folder, maps) = copied();
    assert_eq!(run(folder.path(), &["export", "--format", "dcm,cdfx,c"]).0, 0);
    let map = forward(&maps);
    let (i, j) = (4, map.accel_mps2.iter().position(|a| *a > 0.25).unwrap());
    let (value, error) = (map.torque_nm[i][j], map.std_err_nm[i][j].unwrap());
    for name in ["export/pivot_map.dcm", "export/pivot_map.cdfx", "export/pivot_map.c", "table2.csv"] {
        let original = text(&maps, name);
        let number = value.to_string();
        assert!(original.contains(&number), "{name}: {number}");
        let path = folder.path().join(Path::new(name).file_name().unwrap());
        std::fs::write(&path, original.replacen(&number, &(value + 2.0).to_string(), 1)).unwrap();
        let found = edited(folder.path(), &path);
        let cells = found["cells"].as_array().unwrap();
        assert_eq!(cells.len(), 1, "{name}: {cells:?}");
        let number = |key: &str| cells[0][key].as_f64().unwrap();
        assert_eq!(
            (number("speed_mps"), number("accel_mps2"), &cells[0]["gear"]),
            (map.speed_mps[i], map.accel_mps2[j], &"forward".into())
        );
        assert!(
            (number("edited_nm") - number("measured_nm") - 2.0).abs() < 1e-9 && (number("errors") - 2.0 / error).abs() < 1e-6 * 2.0 / error
        );
    }
}

#[test]
fn a_pedal_map_is_compared_with_table_1_and_judged_as_its_inverse() {
    let (folder, maps) = copied();
    assert_eq!(run(folder.path(), &["export", "--format", "autoware"]).0, 0);
    // without the other pedal's map beside it
    let original = text(&maps, "export/accel_map.csv");
    let mut lines: Vec<String> = original.lines().map(str::to_owned).collect();
    let mut cells: Vec<String> = lines[4].split(',').map(str::to_owned).collect();
    let before: f64 = cells[3].parse().unwrap();
    cells[3] = (before + 0.02).to_string();
    lines[4] = cells.join(",");
    std::fs::write(folder.path().join("accel_map.csv"), lines.join("\n")).unwrap();
    let found = edited(folder.path(), &folder.path().join("accel_map.csv"));
    let changed = found["accel_cells"].as_array().unwrap();
    assert_eq!((changed.len(), found["cells"].as_array().unwrap().len()), (1, 0));
    let number = |key: &str| changed[0][key].as_f64().unwrap();
    assert!((number("edited_mps2") - number("measured_mps2") - 0.02).abs() < 1e-8 && number("errors") > 0.0, "{changed:?}");
    let header: Vec<&str> = lines[0].split(',').collect();
    assert_eq!(number("speed_mps"), header[3].parse::<f64>().unwrap());
    let (status, said, errors) = run(folder.path(), &["diff", "--edited", "maps/table1.json", "accel_map.csv"]);
    assert!(status == 3 && said.contains("map [m/s²]") && said.contains("1 of"), "{said}{errors}");
    let draws = ["--scenario", "left-90", "--scenario", "right-90", "--draws", "2"];
    let (status, said, errors) = run(folder.path(), &[&["verify", "--table", "maps/export/accel_map.csv"][..], &draws].concat());
    assert!(status == 0 && said.contains("Autoware, 1 table(s)"), "{said}{errors}");
}

#[test]
fn check_judges_what_was_exported_and_finds_what_a_person_broke_in_it() {
    let (folder, maps) = copied();
    assert_eq!(run(folder.path(), &["export", "--format", "dcm,cdfx,c,rust"]).0, 0);
    let map = forward(&maps);
    let (i, j) = (4, map.accel_mps2.iter().position(|a| *a > 0.25).unwrap());
    let value = map.torque_nm[i][j].to_string();
    for name in ["pivot_map.dcm", "pivot_map.cdfx", "pivot_map.c", "pivot_map.rs"] {
        let (status, said, errors) = run(folder.path(), &["check", &format!("maps/export/{name}")]);
        assert!(status == 0 && said.contains("sound") && said.contains("reverse"), "{name}: {said}{errors}");
        let broken = text(&maps, &format!("export/{name}")).replacen(&value, "-30.0", 1);
        std::fs::write(folder.path().join(name), broken).unwrap();
        let (status, said, _) = run(folder.path(), &["check", name]);
        let place = format!("forward gear, speed {}, acceleration {}", map.speed_mps[i], map.accel_mps2[j]);
        assert!(status == 3 && said.contains(&place) && said.contains("not monotone"), "{name}: {said}");
    }
    std::fs::write(folder.path().join("cut.dcm"), "KONSERVIERUNG_FORMAT 2.0\nKENNFELD M 2 2\n ST/X 0 x\nEND\n").unwrap();
    let (status, said, _) = run(folder.path(), &["check", "cut.dcm"]);
    assert!(status == 3 && said.contains("line 3") && said.contains("\"x\" is not a finite number"), "{said}");
}

#[test]
fn report_shows_a_table_that_came_back_and_no_verdict_that_is_not_its_own() {
    let (folder, maps) = copied();
    assert_eq!(run(folder.path(), &["export", "--format", "dcm"]).0, 0);
    std::fs::rename(maps.join("export/pivot_map.dcm"), folder.path().join("tuned.dcm")).unwrap();
    let (status, said, errors) = run(folder.path(), &["report", "--table", "tuned.dcm", "-o", "tuned.html"]);
    assert!(status == 0 && said.contains("note: Table 2 is that of tuned.dcm (DCM)"), "{said}{errors}");
    let page = std::fs::read_to_string(folder.path().join("tuned.html")).unwrap();
    assert!(page.contains("tuned.dcm") && !said.contains("verdict: pass"), "{said}");
    let (status, _, errors) = run(folder.path(), &["report", "--table", "tuned.dcm"]);
    assert!(status == 2 && errors.contains("--output"), "{errors}");
}

#[test]
fn an_edited_map_is_judged_on_the_measured_plant_and_the_verdict_of_the_folder_stays() {
    let (folder, maps) = copied();
    assert_eq!(run(folder.path(), &["export", "--format", "dcm"]).0, 0);
    let before = text(&maps, "verify.json");
    let dcm = text(&maps, "export/pivot_map.dcm");
    // a third more torque everywhere
    let wrong: Vec<String> = dcm
        .lines()
        .map(|line| match line.trim().strip_prefix("WERT") {
            Some(numbers) if line.matches('.').count() > 1 => {
                let scaled = numbers.split_whitespace().map(|n| (1.33 * n.parse::<f64>().unwrap()).to_string());
                format!("   WERT   {}", scaled.collect::<Vec<_>>().join("   "))
            }
            _ => line.to_owned(),
        })
        .collect();
    std::fs::write(folder.path().join("wrong.dcm"), wrong.join("\n")).unwrap();
    let draws = ["--scenario", "left-90", "--scenario", "right-90", "--draws", "4"];
    let judged = |file: &str| run(folder.path(), &[&["verify", "--table", file][..], &draws].concat());
    let (status, said, errors) = judged("maps/export/pivot_map.dcm");
    assert!(status == 0 && said.contains("DCM, 2 table(s)"), "{said}{errors}");
    let (status, said, _) = judged("wrong.dcm");
    assert!(status == 3 && said.contains("Table 2 is not the inverse of Table 1 there"), "{said}");
    assert_eq!(text(&maps, "verify.json"), before);
}

#[test]
fn what_cannot_be_read_is_said_with_its_place() {
    let (folder, _) = copied();
    let cases = [
        ("a.dcm", "KONSERVIERUNG_FORMAT 2.0\nKENNFELD M 2 2\n ST/X 0 x\nEND\n", "a.dcm, line 3: \"x\" is not a finite number"),
        ("b.dcm", "KENNFELD M 2 2\n EINHEIT_Y \"m/s\"\n ST/X 0 1\nEND\n", "2 × 2 has 2 ST/X, 0 ST/Y and 0 WERT"),
        ("c.cdfx", "<MSRSW><SW-INSTANCE></MSRSW>", "closes nothing"),
        ("d.csv", "speed [furlong],acceleration,torque_nm\n0,0,1\n0,1,2\n1,0,3\n1,1,4\n", "\"furlong\""),
        ("e.csv", "speed_mps,accel_mps2,torque [%]\n0,0,1\n0,1,2\n1,0,3\n1,1,4\n", "--torque-full-scale"),
        ("f.csv", "torque_nm\\speed_mps,0,1\n0,1,2\n1,2,3\n", "a Table 2 has speeds in its first column"),
        ("g.c", "static const int x = 1;\n", "no array forward_speed_"),
    ];
    for (name, content, why) in cases {
        std::fs::write(folder.path().join(name), content).unwrap();
        let (status, _, errors) = run(folder.path(), &["diff", "--edited", "maps", name]);
        assert!(status == 1 && errors.contains(why), "{name}: {errors}");
    }
    let (status, _, errors) = run(folder.path(), &["diff", "--edited", "maps", "e.csv", "--torque-full-scale", "44", "-q"]);
    assert_eq!(status, 3, "{errors}");
}
