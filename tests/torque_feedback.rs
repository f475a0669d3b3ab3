//! Fits by the torque feedback and by the command, judged against the exact map of the simulator.
//! `cargo test --test torque_feedback -- --nocapture` tells the figures.

#![allow(clippy::unwrap_used, clippy::print_stdout)] // a test says what it measured

use pivot_cal::campaign::{self, Survey};
use pivot_cal::fit::{self, Fit, fit};
use pivot_cal::invert::{self, invert};
use pivot_cal::log::{Recording, Source, VehicleOverrides, read_bytes};
use pivot_cal::map::{CellStatus, CsvRef, Gear};
use pivot_cal::record::{Campaign, record};
use pivot_cal::signal::Track;
use pivot_cal::sim::{Truth, VehicleFile};
use pivot_cal::units::RAD_PER_DEG;
use std::path::Path;

fn text(path: &str) -> String {
    std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join(path)).unwrap()
}

/// The sample campaign's forward runs on the scrubber, its drive's torque limited to so many N·m/s, and the scrubber's exact map. The
/// feedback comes 25 times a second with 0.3 N·m of noise.
fn recorded(slew_limit_nm_s: Option<f64>) -> (Recording, Truth) {
    let mut vehicle = VehicleFile::from_toml(&text("data/vehicles/scrubber.toml")).unwrap();
    vehicle.drive.slew_limit_nm_s = slew_limit_nm_s;
    let mut campaign = Campaign::from_toml(&text("data/campaigns/torque_steps.toml")).unwrap();
    campaign.runs.retain(|group| group.gear == Gear::Forward);
    println!("seed {}, slew limit {slew_limit_nm_s:?} N·m/s", campaign.seed);
    let log = record(&vehicle, &campaign, None).unwrap();
    let recording = read_bytes(log.bytes, "steps.mcap", &Source::Detect, &VehicleOverrides::default()).unwrap();
    assert!(recording.signals.torque_feedback.is_some());
    (recording, vehicle.truth().unwrap())
}

/// The fit of a log whose track is changed first.
fn fitted(recording: &Recording, change: impl Fn(&mut Track)) -> Fit {
    let mut track = Track::new(recording).unwrap();
    change(&mut track);
    fit(vec![Survey::new(track, &campaign::Settings::default()).unwrap()], &fit::Settings::default()).unwrap()
}

/// Errors against the truth, root mean square over the measured cells: of Table 1 [m/s²] and of the torque for the true acceleration
/// [N·m]; and of the breakaway torque [N·m].
#[derive(Debug)]
struct Errors {
    accel_mps2: f64,
    torque_nm: f64,
    breakaway_nm: f64,
}

fn errors(fit: &Fit, truth: &Truth) -> Errors {
    let map = &fit.file.maps[0];
    let angle_rad = map.wheel_angle_deg * RAD_PER_DEG;
    let inverse = invert(&fit.file, CsvRef { file: "table1.json".into(), sha256: String::new() }, &invert::Settings::default()).unwrap();
    let table2 = inverse.file.maps[0].table().unwrap();
    let (mut accel, mut torque) = (Vec::new(), Vec::new());
    for (i, u) in map.torque_nm.iter().enumerate() {
        for (j, v) in map.speed_mps.iter().enumerate().filter(|(_, v)| **v > 0.0) {
            if map.status[i][j] == CellStatus::Measured {
                let a = truth.gear_accel_mps2(Gear::Forward, *v, *u, angle_rad);
                accel.push(map.accel_mps2[i][j] - a);
                torque.extend(table2.torque_from_accel(*v, a).map(|found| found - u));
            }
        }
    }
    let rms = |errors: &[f64]| (errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64).sqrt();
    let breakaway = truth.breakaway_nm(Gear::Forward, angle_rad);
    assert!(accel.len() > 50 && torque.len() * 10 > accel.len() * 8, "{} cells, {} answered", accel.len(), torque.len());
    Errors { accel_mps2: rms(&accel), torque_nm: rms(&torque), breakaway_nm: (map.breakaway.torque_nm - breakaway).abs() }
}

#[test]
fn a_drive_with_a_slew_limit_is_followed_by_its_feedback() {
    let (recording, truth) = recorded(Some(60.0));
    let by_feedback = fitted(&recording, |_| ());
    let by_command = fitted(&recording, |track| track.feedback_nm = None);
    println!("{:#?}", by_feedback.file.actuator);
    println!("{:#?}", by_feedback.file.report.notes);
    println!("{:#?} {:?}", by_command.file.actuator, by_command.file.report.notes);
    let (feedback, command) = (errors(&by_feedback, &truth), errors(&by_command, &truth));
    println!("by the feedback {feedback:?}\nby the command {command:?}");
    println!(
        "{:?} {:?} coverage {} {}",
        by_feedback.file.maps[0].breakaway,
        by_command.file.maps[0].breakaway,
        by_feedback.file.report.coverage,
        by_command.file.report.coverage
    );
}

#[test]
fn a_first_order_drive_is_modelled_whether_it_tells_its_torque_or_not() {
    let (recording, truth) = recorded(None);
    let with = fitted(&recording, |_| ());
    let without = fitted(&recording, |track| track.feedback_nm = None);
    println!("{:?} {:?}", errors(&with, &truth), with.file.report.notes);
    assert_eq!(with.csvs, without.csvs);
    let mut bare = with.file.clone();
    assert_eq!(bare.actuator.per_log[0].clock_offset.status, "none found");
    bare.actuator.per_log[0].clock_offset = without.file.actuator.per_log[0].clock_offset.clone();
    assert_eq!(bare.to_json().unwrap(), without.file.to_json().unwrap());
    assert_eq!(with.file.actuator.input, "torque command");
}

#[test]
fn a_feedback_of_another_scale_is_refused() {
    for slew_limit_nm_s in [None, Some(60.0)] {
        let (recording, _) = recorded(slew_limit_nm_s);
        let high = fitted(&recording, |track| track.feedback_nm.as_mut().unwrap().value.iter_mut().for_each(|u| *u *= 1.1));
        let without = fitted(&recording, |track| track.feedback_nm = None);
        println!("{}", high.file.actuator.input);
        assert!(high.file.actuator.input.starts_with("torque command ("), "{}", high.file.actuator.input);
        assert!(high.file.actuator.input.contains("the feedback reads 10 % high"), "{}", high.file.actuator.input);
        assert!(high.file.report.notes.iter().any(|n| n.contains("reads 10 % high")), "{:?}", high.file.report.notes);
        assert_eq!(high.csvs, without.csvs);
    }
}
