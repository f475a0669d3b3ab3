//! `verify` on maps of known quality: good ones pass, each kind of bad one fails, and files that do not belong together are refused.
#![allow(clippy::unwrap_used)]

#[path = "common/known_map.rs"]
mod known_map;

use assert_cmd::Command;
use known_map::{good, save, vehicle, world};
use pivot_cal::internals::{PhysicalSettings, WorldSettings as World, known_maps};
use pivot_cal::map::{Axis, CellStatus, Gear, TorqueTable, WheelAngle};
use pivot_cal::verify::{MapVerdict, Maps, Metric, Scenario, Statistic, Status, VerifySettings, verify};
use std::path::Path;

/// Few scenarios and draws: enough for what a test asks.
fn settings(scenarios: &[&str], draws: usize) -> VerifySettings {
    let all = Scenario::all().into_iter();
    let scenarios = all.filter(|s| scenarios.contains(&s.name.as_str())).collect();
    VerifySettings { scenarios, draws, comparison_draws: 0, ..VerifySettings::new().unwrap() }
}

/// The verdict on a map whose forward table was changed.
fn judged(change: impl Fn(&TorqueTable) -> TorqueTable) -> MapVerdict {
    let (table1, table2) = good();
    let mut maps = Maps::new(table1, table2).unwrap();
    maps.forward = change(&maps.forward);
    verify(&maps, &settings(&["left-90"], 8)).unwrap()
}

/// A table of the same axes with other values.
fn with_values(table: &TorqueTable, value: impl Fn(usize, usize) -> f64) -> TorqueTable {
    let (rows, columns) = (table.speed_mps().len(), table.accel_mps2().len());
    let values = (0..rows).flat_map(|i| (0..columns).map(move |j| (i, j))).map(|(i, j)| value(i, j)).collect();
    TorqueTable::new(table.speed_mps().clone(), table.accel_mps2().clone(), values).unwrap()
}

#[track_caller]
fn fails(verdict: &MapVerdict) {
    assert_eq!(verdict.status, Status::Fail, "{:?}", verdict.notes);
    assert!(!verdict.round_trip[0].pass, "the round trip alone must see it");
}

#[test]
fn the_exact_map_passes() {
    let verdict = judged(Clone::clone);
    assert!(verdict.passes(), "{:?}", verdict.notes);
    // 0.1 m/s² and 0.05 m/s between the nodes of the exact map: the Stribeck curve's bend is all that the grid loses
    assert!(verdict.round_trip[0].rms_mps2 < 0.01);
}

#[test]
fn one_wrong_cell_fails_wherever_it_is() {
    let (_, table2) = good();
    let map = table2.map(Gear::Forward, WheelAngle::from_deg(90.0)).unwrap();
    let mut tried = 0;
    for i in (0..map.speed_mps.len()).step_by(5) {
        for j in (0..map.accel_mps2.len()).step_by(7) {
            // +50 % of less than 6 N·m is less than the gate's 0.15 m/s² with this inertia of 13.2 N·m per m/s²
            if map.status[i][j] != CellStatus::Measured || map.torque_nm[i][j].abs() < 6.0 {
                continue;
            }
            tried += 1;
            let (table1, table2) = good();
            let mut maps = Maps::new(table1, table2).unwrap();
            maps.forward = with_values(&maps.forward, |r, c| maps.forward.at(r, c) * if (r, c) == (i, j) { 1.5 } else { 1.0 });
            fails(&verify(&maps, &settings(&[], 0)).unwrap());
        }
    }
    assert!(tried > 20, "{tried}");
}

#[test]
fn a_shifted_speed_axis_fails() {
    for shift_mps in [0.05, 0.2, -0.1] {
        fails(&judged(|table| {
            let speed = Axis::new("speed_mps", table.speed_mps().breaks().iter().map(|v| v + shift_mps).collect()).unwrap();
            TorqueTable::new(speed, table.accel_mps2().clone(), table.values().to_vec()).unwrap()
        }));
    }
}

#[test]
fn two_swapped_rows_fail() {
    // 0 and 0.6 m/s, 0 and 1 m/s, 0.1 and 0.8 m/s: neighbours differ by less than the gate resolves, and swapping them does no harm
    for (one, other) in [(0, 12), (0, 20), (2, 16)] {
        let swap = |i| {
            if i == one {
                other
            } else if i == other {
                one
            } else {
                i
            }
        };
        fails(&judged(|table| with_values(table, |i, j| table.at(swap(i), j))));
    }
}

#[test]
fn a_scaled_map_fails() {
    for factor in [1.3, 1.4, 0.7] {
        fails(&judged(|table| with_values(table, |i, j| (factor * table.at(i, j)).clamp(-44.0, 44.0))));
    }
}

#[test]
fn a_map_without_the_breakaway_torque_fails() {
    let breakaway_nm = good().1.maps[0].dead_band.high_nm;
    fails(&judged(|table| with_values(table, |i, j| table.at(i, j) - if i == 0 { breakaway_nm } else { 0.0 })));
    fails(&judged(|table| with_values(table, |i, j| table.at(i, j) - breakaway_nm)));
}

#[test]
fn another_vehicles_map_fails() {
    let heavier = PhysicalSettings { yaw_inertia_kgm2: 140.0, coulomb_nm: 6.0, static_nm: 8.0, ..PhysicalSettings::default() };
    let (_, other) = known_maps(&World::physical(vehicle(), heavier)).unwrap();
    let maps = Maps::new(good().0, other).unwrap();
    fails(&verify(&maps, &settings(&["left-90"], 8)).unwrap());
}

#[test]
fn every_failure_is_found_and_ends_safely() {
    let (table1, table2) = good();
    let maps = Maps::new(table1, table2).unwrap();
    let mut settings = settings(&[], 4);
    settings.scenarios = Scenario::all().into_iter().filter(|s| s.class == pivot_cal::verify::Class::Failure).collect();
    assert_eq!(settings.scenarios.len(), 10);
    let verdict = verify(&maps, &settings).unwrap();
    for scenario in &verdict.scenarios {
        assert_eq!(scenario.status, Status::Pass, "{}: {:?}", scenario.name, scenario.checks);
    }
}

#[test]
fn without_a_reverse_table_reverse_turns_are_not_tested_and_that_is_no_failure() {
    let (mut table1, mut table2) = good();
    table1.maps.retain(|m| m.gear == Gear::Forward);
    table2.maps.retain(|m| m.gear == Gear::Forward);
    let maps = Maps::new(table1, table2).unwrap();
    let verdict = verify(&maps, &settings(&["left-30", "right-30", "right-30-mirror"], 4)).unwrap();
    let status: Vec<_> = verdict.scenarios.iter().map(|s| s.status).collect();
    assert_eq!(status, [Status::Pass, Status::NotTested, Status::Pass], "{:?}", verdict.notes);
    assert!(verdict.passes());
    assert!(verdict.scenarios[2].notes.iter().any(|n| n.contains("symmetry assumed")));
}

#[test]
fn the_verdict_is_the_same_for_every_number_of_threads() {
    let (table1, table2) = good();
    let maps = Maps::new(table1, table2).unwrap();
    let text = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| verify(&maps, &settings(&["left-90", "speed-lost"], 6)).unwrap().to_json().unwrap())
    };
    assert_eq!(text(1), text(3));
}

#[test]
fn the_exact_map_reaches_the_figures_on_its_own_vehicle() {
    let (table1, table2) = good();
    let maps = Maps::new(table1, table2).unwrap();
    let settings = VerifySettings { draws: 100, comparison_draws: 10, ..settings(&["left-90", "right-90"], 100) };
    let verdict = verify(&maps, &settings).unwrap();
    let figure = |scenario: usize, metric: Metric, statistic: Statistic| {
        verdict.scenarios[scenario].metrics.iter().find(|m| m.metric == metric).and_then(|m| m.figure(statistic)).unwrap()
    };
    for scenario in 0..2 {
        // the goals for ±90°
        assert!(figure(scenario, Metric::HeadingErrorDeg, Statistic::Median) <= 0.3);
        assert!(figure(scenario, Metric::HeadingErrorDeg, Statistic::P99) <= 1.0);
    }
    let comparison = verdict.comparison.as_ref().unwrap();
    assert!(comparison.speed_rms_ratio.unwrap() <= 1.15);
    assert!(comparison.start_jerk_ratio.unwrap() <= 1.0 / 3.0);
}

#[test]
fn a_physical_plant_can_be_driven_too() {
    let (table1, table2) = good();
    let maps = Maps::new(table1, table2).unwrap();
    let settings = VerifySettings { plant: Some(world()), ..settings(&["left-90", "right-90"], 8) };
    let verdict = verify(&maps, &settings).unwrap();
    assert!(verdict.passes(), "{:?}", verdict.notes);
    assert_eq!(verdict.plant.kind, "physical");
}

fn command(folder: &Path, arguments: &[&str]) -> assert_cmd::assert::Assert {
    let mut command = Command::cargo_bin("pivot-cal-verify").unwrap();
    command.arg("--maps").arg(folder).args(["--draws", "4", "--scenario", "left-90"]).args(arguments).assert()
}

#[test]
fn the_command_passes_a_good_map_writes_the_same_bytes_twice_and_a_log() {
    let folder = tempfile::tempdir().unwrap();
    save(folder.path());
    let logs = folder.path().join("logs");
    let out = command(folder.path(), &["--log", logs.to_str().unwrap()]).code(0);
    let text = String::from_utf8(out.get_output().stdout.clone()).unwrap();
    assert!(text.contains("round trip") && text.contains("left-90") && text.contains("verdict: pass"), "{text}");
    let first = std::fs::read(folder.path().join("verify.json")).unwrap();
    command(folder.path(), &["-q"]).code(0).stdout("");
    assert_eq!(first, std::fs::read(folder.path().join("verify.json")).unwrap());
    let log = std::fs::read(logs.join("left-90.mcap")).unwrap();
    let topics: std::collections::BTreeSet<_> = mcap::MessageStream::new(&log).unwrap().map(|m| m.unwrap().channel.topic.clone()).collect();
    for topic in ["/joint_states", "/odom", "/pivot/accel_desired", "/pivot/accel_actual", "/pivot/direction_flag", "/pivot/waypoints"] {
        assert!(topics.contains(topic), "{topic} of {topics:?}");
    }
    let verdict: MapVerdict = serde_json::from_slice(&first).unwrap();
    assert!(verdict.passes());
}

#[test]
fn small_turns_are_added_to_what_was_judged_and_fresh_starts_over() {
    let folder = tempfile::tempdir().unwrap();
    save(folder.path());
    let turn = |arguments: &[&str]| {
        let mut command = Command::cargo_bin("pivot-cal-verify").unwrap();
        let said = command.arg("--maps").arg(folder.path()).args(["--draws", "2", "--turn-deg", "5"]).args(arguments).assert();
        let verdict: MapVerdict = serde_json::from_slice(&std::fs::read(folder.path().join("verify.json")).unwrap()).unwrap();
        (said, verdict.scenarios.iter().map(|s| s.name.clone()).collect::<Vec<_>>())
    };
    command(folder.path(), &["-q"]).code(0);
    let (said, names) = turn(&[]);
    said.code(0);
    assert_eq!(names, ["left-90", "left-5", "right-5", "right-5-mirror"]);
    let (said, names) = turn(&["--fresh"]);
    let said = String::from_utf8(said.code(0).get_output().stdout.clone()).unwrap();
    assert_eq!(names, ["left-5", "right-5", "right-5-mirror"]);
    assert!(said.starts_with("verdict: pass: 90° only, left-5, right-5, right-5-mirror only"), "{said}");
    let (said, _) = turn(&["--turn-deg", "1"]);
    assert!(String::from_utf8_lossy(&said.code(2).get_output().stderr).contains("allowed: 2 to 360"));
}

#[test]
fn a_vehicle_file_gives_the_pivots_what_torque_steps_hardly_show() {
    let folder = tempfile::tempdir().unwrap();
    save(folder.path());
    let file = folder.path().join("vehicle.toml");
    let text = include_str!("../data/vehicles/scrubber.toml");
    // a dead band of half the cruise torque: the wheel stops short
    std::fs::write(&file, text.replace("[drive]\n", "[drive]\ntorque_dead_band_nm = 12.0\n")).unwrap();
    command(folder.path(), &["--vehicle", file.to_str().unwrap()]).code(3);
    let verdict: MapVerdict = serde_json::from_slice(&std::fs::read(folder.path().join("verify.json")).unwrap()).unwrap();
    assert_eq!((verdict.plant.torque_dead_band_nm, verdict.status), (Some(12.0), Status::Fail));
    std::fs::write(&file, text).unwrap();
    command(folder.path(), &["--vehicle", file.to_str().unwrap()]).code(0);
}

#[test]
fn a_circumstance_that_the_map_does_not_know_of_is_felt() {
    let (table1, table2) = good();
    let maps = Maps::new(table1, table2).unwrap();
    let verdict = verify(&maps, &settings(&["left-90", "wet-floor", "low-battery"], 4)).unwrap();
    let tracking = |k: usize| verdict.scenarios[k].metrics.iter().find(|m| m.metric == Metric::SpeedRmsMps).unwrap().nominal.unwrap();
    for hard in [1, 2] {
        assert!(tracking(hard) > 1.5 * tracking(0), "{}: {} against {}", verdict.scenarios[hard].name, tracking(hard), tracking(0));
    }
    assert!(verdict.passes(), "{:?}", verdict.notes);
}

#[test]
fn recorded_runs_are_replayed_through_the_plant_and_reported_per_run() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let folder = tempfile::tempdir().unwrap();
    for entry in std::fs::read_dir(root.join("maps")).unwrap() {
        let path = entry.unwrap().path();
        if path.is_file() {
            std::fs::copy(&path, folder.path().join(path.file_name().unwrap())).unwrap();
        }
    }
    let log = root.join("data/demo.mcap");
    let out = command(folder.path(), &["--replay", log.to_str().unwrap()]).code(0);
    let text = String::from_utf8(out.get_output().stdout.clone()).unwrap();
    assert!(text.contains("replayed run") && text.contains("replayed open loop") && text.contains("0 of them held out"), "{text}");
    let verdict: MapVerdict = serde_json::from_slice(&std::fs::read(folder.path().join("verify.json")).unwrap()).unwrap();
    // 64 runs, of which those below breakaway do not move
    assert!(verdict.replayed.len() > 40, "{}", verdict.replayed.len());
    let mut rmse: Vec<f64> = verdict.replayed.iter().map(|r| r.rmse_mps).collect();
    rmse.sort_by(f64::total_cmp);
    // the encoder's noise is 6.6 mm/s; the disturbance of 0.016 m/s² over some seconds adds as much
    assert!(rmse[rmse.len() / 2] < 0.015, "{rmse:?}");
    assert!(
        verdict.replayed.iter().all(|r| r.fitted && r.file == "demo.mcap" && r.r_squared.is_some_and(|x| x > 0.9)),
        "{:?}",
        verdict.replayed
    );
    assert!(!text.contains("\u{1b}["), "no progress bar in a pipe");
}

#[test]
fn pivots_in_operation_are_compared_with_what_was_desired() {
    let folder = tempfile::tempdir().unwrap();
    save(folder.path());
    command(folder.path(), &["--scenario", "left-180", "--log", folder.path().join("logs").to_str().unwrap()]).code(0);
    let log = folder.path().join("logs/left-180.mcap");
    let out = command(folder.path(), &["--pivots", log.to_str().unwrap(), "-v"]).code(0);
    let text = String::from_utf8(out.get_output().stdout.clone()).unwrap();
    assert!(text.contains("pivots in operation") && text.contains("passed pivots: in "), "{text}");
    let verdict: MapVerdict = serde_json::from_slice(&std::fs::read(folder.path().join("verify.json")).unwrap()).unwrap();
    let [found] = &verdict.pivots[..] else { panic!("{:?}", verdict.pivots) };
    // the turn takes 6 s; the speed loop makes up to 15 %
    assert!(found.gear == Gear::Forward && found.seconds > 4.0 && (0.85..1.1).contains(&found.gain), "{found:?}");
    let campaign = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/demo.mcap");
    let out = command(folder.path(), &["--pivots", campaign.to_str().unwrap()]).code(1);
    let text = String::from_utf8(out.get_output().stderr.clone()).unwrap();
    assert!(text.contains("demo.mcap: the signal desired_accel is missing") && text.contains("--signals"), "{text}");
}

#[test]
fn an_edited_csv_is_refused_and_with_force_judged() {
    let folder = tempfile::tempdir().unwrap();
    save(folder.path());
    let path = folder.path().join("table2.csv");
    let text = std::fs::read_to_string(&path).unwrap();
    let table = TorqueTable::from_matrix(pivot_cal::map::Matrix::from_csv(&text).unwrap()).unwrap();
    let scaled = with_values(&table, |i, j| 1.4 * table.at(i, j));
    std::fs::write(&path, scaled.to_matrix().to_csv()).unwrap();
    let refused = command(folder.path(), &[]).code(1);
    let message = String::from_utf8(refused.get_output().stderr.clone()).unwrap();
    assert!(message.contains("table2.csv") && message.contains("--force") && message.contains("SHA-256"), "{message}");
    assert!(!folder.path().join("verify.json").exists());
    command(folder.path(), &["--force"]).code(3);
}

#[test]
fn what_is_missing_or_misspelt_is_reported() {
    let folder = tempfile::tempdir().unwrap();
    let error = |arguments: &[&str]| String::from_utf8(command(folder.path(), arguments).code(1).get_output().stderr.clone()).unwrap();
    assert!(error(&[]).contains("table1.json"));
    let misspelt = error(&["--scenario", "left-91"]);
    assert!(misspelt.contains("left-91") && misspelt.contains("left-90") && misspelt.contains("--list"), "{misspelt}");
    let gate = folder.path().join("gate.toml");
    std::fs::write(&gate, "[[limit]]\nclass = \"turn\"\nmetric = \"speed\"\nstatistic = \"max\"\nat_most = 1\n").unwrap();
    assert!(error(&["--gate", gate.to_str().unwrap()]).contains("gate.toml"));
}
