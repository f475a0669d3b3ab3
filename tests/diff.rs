//! `diff`: what changed is reported with its place and its size; chance is not.
#![allow(clippy::unwrap_used)]

#[path = "common/map_copy.rs"]
mod map_copy;

use map_copy::{change_table1, change_table2, copied, run, text};
use pivot_cal::map::{CellStatus, Gear, Table2File};
use serde_json::Value;
use std::path::{Path, PathBuf};

/// The committed map, and a copy of it to change.
fn pair() -> (tempfile::TempDir, PathBuf, PathBuf) {
    let (folder, a) = copied();
    let b = folder.path().join("other");
    std::fs::create_dir(&b).unwrap();
    for entry in std::fs::read_dir(&a).unwrap() {
        let path = entry.unwrap().path();
        std::fs::copy(&path, b.join(path.file_name().unwrap())).unwrap();
    }
    (folder, a, b)
}

fn differ(folder: &Path, args: &[&str]) -> (i32, Value) {
    let (status, out, errors) = run(folder, &[&["diff", "--json"], args].concat());
    assert_eq!(errors, "");
    (status, serde_json::from_str(&out).unwrap())
}

const TABLES_1: [&str; 2] = ["maps/table1.json", "other/table1.json"];

/// Adds to a map's torques; the rest of the file stays.
fn add_torque(maps: &Path, gear: usize, add: impl Fn(usize, usize) -> f64) {
    change_table2(maps, |file| {
        let map = &mut file.maps[gear];
        for (i, row) in map.torque_nm.iter_mut().enumerate() {
            row.iter_mut().enumerate().for_each(|(j, value)| *value += add(i, j));
        }
    });
}

#[test]
fn a_map_is_the_same_as_itself() {
    let (folder, ..) = pair();
    for args in [["maps", "other"], TABLES_1] {
        let (status, found) = differ(folder.path(), &args);
        assert_eq!((status, found["verdict"].as_str().unwrap()), (0, "same"));
        assert_eq!(found["maps"].as_array().unwrap().len(), 2);
        for map in found["maps"].as_array().unwrap() {
            assert!(map["compared"].as_u64().unwrap() > 200 && map["significant"] == 0 && map["rms_change"] == 0.0);
        }
    }
}

#[test]
fn noise_as_large_as_its_standard_error_is_no_change() {
    let (folder, _, b) = pair();
    // rough but deterministic noise of both signs, of the size of the change's standard error by both files
    change_table2(&b, |file| {
        for map in &mut file.maps {
            for (i, row) in map.torque_nm.iter_mut().enumerate() {
                for (j, value) in row.iter_mut().enumerate() {
                    let error = map.std_err_nm[i][j].unwrap_or(0.0) * 2f64.sqrt();
                    *value += error * 1.4 * ((7 * i + 13 * j) as f64).sin();
                }
            }
        }
    });
    let (status, found) = differ(folder.path(), &["maps", "other"]);
    assert_eq!((status, found["verdict"].as_str().unwrap()), (0, "same"), "{}", found["threshold_p"]);
    let z = found["maps"][0]["rms_z"].as_f64().unwrap();
    assert!((0.9..1.1).contains(&z), "{z}");
}

#[test]
fn one_changed_cell_is_found_among_all() {
    let (folder, a, b) = pair();
    add_torque(&b, 0, |i, j| if (i, j) == (10, 40) { 6.0 } else { 0.0 });
    let (status, found) = differ(folder.path(), &["maps", "other"]);
    assert_eq!((status, found["verdict"].as_str().unwrap()), (3, "changed"));
    let map = &found["maps"][0];
    assert_eq!((map["significant"].as_u64(), map["matters"].as_u64()), (Some(1), Some(1)));
    let cell = &map["largest"][0];
    let file = Table2File::from_json(&text(&a, "table2.json")).unwrap();
    let (speeds, accels, torques) = (&file.maps[0].speed_mps, &file.maps[0].accel_mps2, &file.maps[0].torque_nm[10]);
    assert_eq!((cell["row"].as_f64(), cell["column"].as_f64()), (Some(speeds[10]), Some(accels[40])));
    assert!((cell["change"].as_f64().unwrap() - 6.0).abs() < 1e-9);
    let (z, error) = (cell["z"].as_f64().unwrap(), cell["std_err"].as_f64().unwrap());
    assert!((z - 6.0 / error).abs() < 1e-9);
    let slope = (torques[41] - torques[39]) / (accels[41] - accels[39]);
    assert!((cell["accel_mps2"].as_f64().unwrap() - 6.0 / slope).abs() < 1e-9, "{cell}");
    assert_eq!(found["maps"][1]["significant"], 0);
}

#[test]
fn heavier_friction_changes_table_1_everywhere() {
    let (folder, _, b) = pair();
    change_table1(&b, |file| {
        file.maps.retain(|m| m.gear == Gear::Forward);
        file.maps[0].accel_mps2.iter_mut().flatten().for_each(|a| *a -= 0.2);
    });
    let (status, found) = differ(folder.path(), &TABLES_1);
    assert_eq!((status, found["verdict"].as_str().unwrap()), (3, "changed"));
    let map = &found["maps"][0];
    assert_eq!(map["significant"], map["compared"]);
    assert_eq!(map["matters"], map["compared"]);
    assert_eq!(found["maps"].as_array().unwrap().len(), 1);
    assert!(found["notes"].to_string().contains("reverse gear at 90° is in maps/table1.json only"), "{}", found["notes"]);
}

#[test]
fn a_significant_change_that_is_worth_little_does_not_matter() {
    let (folder, _, b) = pair();
    change_table1(&b, |file| {
        for map in &mut file.maps {
            map.accel_mps2.iter_mut().flatten().for_each(|a| *a -= 0.05);
        }
    });
    let (_, found) = differ(folder.path(), &TABLES_1);
    assert_eq!((found["verdict"].as_str().unwrap(), found["matters"].as_u64()), ("changed", Some(0)));
    let (_, found) = differ(folder.path(), &[TABLES_1[0], TABLES_1[1], "--matters-mps2", "0.04"]);
    assert!(found["matters"].as_u64().unwrap() > 0);
}

#[test]
fn other_axes_are_compared_by_interpolation_on_the_common_range() {
    let (folder, _, b) = pair();
    // every second speed, and accelerations up to 1 only
    change_table2(&b, |file| {
        for map in &mut file.maps {
            let keep: Vec<_> = (0..map.accel_mps2.len()).filter(|j| map.accel_mps2[*j] <= 1.0).collect();
            map.accel_mps2 = keep.iter().map(|j| map.accel_mps2[*j]).collect();
            let rows: Vec<_> = (0..map.speed_mps.len()).step_by(2).collect();
            map.speed_mps = rows.iter().map(|i| map.speed_mps[*i]).collect();
            map.torque_nm = rows.iter().map(|i| keep.iter().map(|j| map.torque_nm[*i][*j]).collect()).collect();
            map.std_err_nm = rows.iter().map(|i| keep.iter().map(|j| map.std_err_nm[*i][*j]).collect()).collect();
            map.reachable_accel_mps2 = rows.iter().map(|i| map.reachable_accel_mps2[*i]).collect();
            map.status = rows.iter().map(|i| keep.iter().map(|j| map.status[*i][*j]).collect()).collect();
        }
    });
    let (_, found) = differ(folder.path(), &["maps", "other"]);
    let map = &found["maps"][0];
    assert_eq!(map["interpolated"], true);
    assert!(map["compared"].as_u64().unwrap() > 200 && map["left_out"].as_u64().unwrap() > 400, "{}", map["compared"]);
    let (columns, row) = (map["columns"].as_array().unwrap(), map["change"][4].as_array().unwrap());
    for (column, change) in columns.iter().zip(row) {
        assert!(column.as_f64().unwrap() <= 1.0 || change.is_null());
    }
    // bilinear interpolation over 0.1 m/s instead of 0.05 m/s at a place of low curvature
    assert!(map["rms_change"].as_f64().unwrap() < 0.05);
}

#[test]
fn what_is_extrapolated_is_no_evidence() {
    let (folder, _, b) = pair();
    add_torque(&b, 0, |i, j| if (i, j) == (10, 40) { 6.0 } else { 0.0 });
    change_table2(&b, |file| file.maps[0].status[10][40] = CellStatus::Extrapolated);
    assert_eq!(differ(folder.path(), &["maps", "other"]).0, 0);
}

#[test]
fn maps_of_another_angle_gear_vehicle_or_table_are_incompatible() {
    let incompatible = |args: [&str; 2], words: &str, change: &dyn Fn(&Path)| {
        let (folder, _, b) = pair();
        change(&b);
        let (status, found) = differ(folder.path(), &args);
        assert_eq!((status, found["verdict"].as_str().unwrap()), (3, "incompatible"), "{words}");
        assert!(found["reasons"].to_string().contains(words), "{}", found["reasons"]);
    };
    let folders = ["maps", "other"];
    incompatible(folders, "no gear and wheel angle in common", &|b| {
        change_table2(b, |file| file.maps.iter_mut().for_each(|m| m.wheel_angle_deg = -90.0));
    });
    incompatible(folders, "m and 1.1 m", &|b| change_table2(b, |file| file.vehicle.wheelbase_m = 1.1));
    incompatible(folders, "wheel radius", &|b| change_table2(b, |file| file.vehicle.wheel_radius_m = 0.1));
    incompatible(["maps/table1.json", "other"], "Table2", &|_| {});
    incompatible(folders, "no cell is known in both", &|b| {
        change_table2(b, |file| file.maps.iter_mut().for_each(|m| m.speed_mps.iter_mut().for_each(|v| *v += 10.0)));
    });
    // forward only against reverse only
    let (folder, a, b) = pair();
    change_table2(&a, |file| file.maps.truncate(1));
    change_table2(&b, |file| drop(file.maps.remove(0)));
    let (status, found) = differ(folder.path(), &folders);
    assert_eq!((status, found["verdict"].as_str().unwrap()), (3, "incompatible"));
}

#[test]
fn the_heat_map_is_one_page_without_script_or_request() {
    let (folder, a, b) = pair();
    let cells: usize = Table2File::from_json(&text(&a, "table2.json")).unwrap().maps.iter().map(|m| m.torque_nm.concat().len()).sum();
    add_torque(&b, 0, |i, j| if (i, j) == (10, 40) { 6.0 } else { 0.0 });
    let (status, out, _) = run(folder.path(), &["diff", "maps", "other", "--html", "change.html"]);
    assert_eq!(status, 3);
    assert!(out.starts_with("Changed: 1 of ") && out.contains("written: change.html"), "{out}");
    let page = text(folder.path(), "change.html");
    assert_eq!(page.matches("<rect").count(), cells, "one rectangle per cell of each gear");
    assert_eq!(page.matches("stroke=").count(), 1, "the significant cell is outlined");
    assert!(page.contains("Changed: 1 of") && page.contains("<td>+6.0000</td>"));
    for word in ["<script", "http:", "https:", "<link", "@import", "url("] {
        assert!(!page.contains(word), "{word}");
    }
}

#[test]
fn what_cannot_be_read_is_an_error_that_names_it() {
    let (folder, _, b) = pair();
    let fails = |args: &[&str], words: &str| {
        let (status, _, errors) = run(folder.path(), &[&["diff"], args].concat());
        assert_eq!(status, 1);
        assert!(errors.contains(words), "{errors}");
    };
    fails(&["maps", "none.json"], "none.json");
    fails(&["maps/table2.csv", "other"], "table2.csv");
    fails(&["maps", "other", "--false-discovery-rate", "1.5"], "--false-discovery-rate is 1.5");
    change_table2(&b, |file| drop(file.maps[0].std_err_nm.pop()));
    fails(&["maps", "other"], "maps[0].std_err_nm has ");
}
