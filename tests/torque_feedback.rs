//! Fits by the torque feedback and by the command, judged against the exact map of the simulator.
//! `cargo test --test torque_feedback -- --nocapture` prints the figures.

#![allow(clippy::unwrap_used, clippy::print_stdout)] // a test says what it measured

#[path = "common/program.rs"]
mod program;

use pivot_cal::campaign;
use pivot_cal::campaign::{AngleGroup, Survey, group_by_angle};
use pivot_cal::control::RAD_PER_DEG;
use pivot_cal::fit;
use pivot_cal::fit::{Fit, fit, fit_angles};
use pivot_cal::internals::{Campaign, Truth, VehicleFile, record};
use pivot_cal::invert;
use pivot_cal::invert::invert;
use pivot_cal::log::{Recording, Source, VehicleOverrides, read_bytes};
use pivot_cal::map::{
    AccelMap, ActuatorInput, CellStatus, CheckOutcome, CsvRef, DelayStatus, DriveFamily, Gear, InputSource, SampleVerdict,
};
use pivot_cal::signal::{Series, Track};
use program::text;

/// A campaign's forward runs on the scrubber, its drive's torque limited to so many N·m/s, and the scrubber's exact map. The feedback comes
/// 25 times a second with 0.3 N·m of noise.
fn driven(campaign: &str, slew_limit_nm_s: Option<f64>) -> (Recording, Truth) {
    let mut vehicle = VehicleFile::from_toml(&text("data/vehicles/scrubber.toml")).unwrap();
    vehicle.drive.slew_limit_nm_s = slew_limit_nm_s;
    let mut campaign = Campaign::from_toml(campaign).unwrap();
    campaign.runs.retain(|group| group.gear == Gear::Forward);
    println!("seed {}, slew limit {slew_limit_nm_s:?} N·m/s", campaign.seed);
    let log = record(&vehicle, &campaign, None).unwrap();
    let recording = read_bytes(log.bytes, "steps.mcap", &Source::Detect, &VehicleOverrides::default()).unwrap();
    assert!(recording.signals.torque_feedback.is_some());
    (recording, vehicle.truth().unwrap())
}

/// The sample campaign without its trials below breakaway, which would bound the breakaway torque whatever the surface says.
fn recorded(slew_limit_nm_s: Option<f64>) -> (Recording, Truth) {
    let campaign = text("data/campaigns/torque_steps.toml");
    let started = campaign.replace("start = 4, step = 4, stop = 40", "start = 12, step = 4, stop = 40");
    assert_ne!(started, campaign);
    driven(&started, slew_limit_nm_s)
}

/// A log's track, changed, and surveyed.
fn surveyed(recording: &Recording, change: impl Fn(&mut Track)) -> Survey {
    let mut track = Track::new(recording).unwrap();
    change(&mut track);
    Survey::new(track, &campaign::SurveySettings::default()).unwrap()
}

/// The fit of a log whose track is changed first.
fn fitted(recording: &Recording, change: impl Fn(&mut Track)) -> Fit {
    fit(vec![surveyed(recording, change)], &fit::FitSettings::default()).unwrap()
}

/// The feedback of a track.
fn feedback(track: &mut Track) -> &mut Series {
    track.feedback_nm.as_mut().unwrap()
}

/// Errors against the truth, root mean square over the measured cells: of Table 1 [m/s²] and of the torque for the true acceleration
/// [N·m]; and of the breakaway torque [N·m].
#[derive(Debug)]
struct Errors {
    accel_mps2: f64,
    torque_nm: f64,
    breakaway_nm: f64,
}

fn rms(errors: &[f64]) -> f64 {
    (errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64).sqrt()
}

/// Measured cells in motion: speed, torque, acceleration of the map and true acceleration.
fn measured(map: &AccelMap, truth: &Truth) -> Vec<[f64; 4]> {
    let mut cells = Vec::new();
    for (i, u) in map.torque_nm.iter().enumerate() {
        for (j, v) in map.speed_mps.iter().enumerate().filter(|(_, v)| **v > 0.0) {
            if map.status[i][j] == CellStatus::Measured {
                let a = truth.gear_accel_mps2(Gear::Forward, *v, *u, map.wheel_angle_deg * RAD_PER_DEG);
                cells.push([*v, *u, map.accel_mps2[i][j], a]);
            }
        }
    }
    assert!(cells.len() > 50, "{} cells", cells.len());
    cells
}

fn accel_rms_mps2(maps: &[AccelMap], truth: &Truth) -> f64 {
    rms(&maps.iter().flat_map(|map| measured(map, truth)).map(|[_, _, found, a]| found - a).collect::<Vec<_>>())
}

fn errors(fit: &Fit, truth: &Truth) -> Errors {
    let map = &fit.file.maps[0];
    let inverse =
        invert(&fit.file, CsvRef { file: "table1.json".into(), sha256: String::new() }, &invert::InvertSettings::default()).unwrap();
    let table2 = inverse.file.maps[0].table().unwrap();
    let cells = measured(map, truth);
    let torque: Vec<f64> = cells.iter().filter_map(|[v, u, _, a]| Some(table2.torque_from_accel(*v, *a)? - u)).collect();
    assert!(torque.len() * 10 > cells.len() * 8, "{} of {} cells are answered", torque.len(), cells.len());
    let breakaway_nm = truth.breakaway_nm(Gear::Forward, map.wheel_angle_deg * RAD_PER_DEG);
    Errors {
        accel_mps2: accel_rms_mps2(std::slice::from_ref(map), truth),
        torque_nm: rms(&torque),
        breakaway_nm: (map.breakaway.torque_nm - breakaway_nm).abs(),
    }
}

#[test]
fn a_drive_with_a_rate_limit_is_found_with_its_feedback_and_without() {
    let (recording, truth) = recorded(Some(60.0));
    let grouped = AngleGroup::of(vec![surveyed(&recording, |_| ())]).into();
    let (with, traces) = fit_angles(grouped, false, 90.0, &fit::FitSettings::default()).unwrap();
    let without = fitted(&recording, |track| track.feedback_nm = None);
    let by_feedback =
        fit(vec![surveyed(&recording, |_| ())], &fit::FitSettings { drive: Some(DriveFamily::Feedback), ..fit::FitSettings::default() })
            .unwrap();
    for (name, fit) in [("with", &with), ("without", &without), ("by the feedback", &by_feedback)] {
        let errors = errors(fit, &truth);
        println!("{name}: {errors:?}\n{:?}", fit.file.actuator);
        assert!(errors.accel_mps2 < 0.015 && errors.torque_nm < 0.2 && errors.breakaway_nm < 0.2);
    }
    assert_eq!(without.file.actuator.input, ActuatorInput::COMMAND);
    let drive = without.file.actuator.drive.as_ref().unwrap();
    let [up, down] = drive.slopes_nm_s.unwrap();
    assert!(drive.family == DriveFamily::RateLimit && (up - 60.0).abs() < 3.0 && (down - 60.0).abs() < 3.0, "{drive:?}");
    // asked for by name, the feedback is the torque, and there is nothing to say about the drive but its nearest first-order lag
    let actuator = &by_feedback.file.actuator;
    assert_eq!(actuator.input.source, InputSource::TorqueFeedback);
    // ramps of up to 0.7 s behind the drive's own 52 and 48 ms: the nearest first-order drive begins late and rises slowly
    let (dead_time, lag) = (&actuator.dead_time, &actuator.lag);
    assert!((0.07..0.30).contains(&dead_time.value_s) && (0.12..0.30).contains(&lag.value_s), "{dead_time:?} {lag:?}");
    assert!(dead_time.std_err_s.unwrap() > 1e-3 && lag.std_err_s.unwrap() > 1e-3, "no first-order drive is known to a tenth of a ms");
    // the picture of the likelihood has its minimum at the dead time that is reported
    let traces: serde_json::Value = serde_json::from_str(&traces.to_json().unwrap()).unwrap();
    let log = &traces["delay"]["per_log"][0];
    let found_s = log["found_s"].as_f64().unwrap();
    assert!((found_s - with.file.actuator.dead_time.value_s).abs() < 1e-5, "{found_s} {:?}", with.file.actuator.dead_time);
    let offset = &with.file.actuator.per_log[0].clock_offset;
    assert!(offset.status == DelayStatus::NoneFound && offset.value_s.abs() < 0.01, "{offset:?}");
}

/// The feedback behind a first-order filter of its own.
fn filtered(track: &mut Track, lag_s: f64) {
    let series = feedback(track);
    let mut last = (series.t_s[0], series.value[0]);
    for (t, value) in series.t_s.iter().zip(series.value.iter_mut()) {
        *value = last.1 + (*value - last.1) * (1.0 - (-(t - last.0) / lag_s).exp());
        last = (*t, *value);
    }
}

#[test]
fn the_lag_of_a_first_order_drive_is_observed_by_its_feedback_unless_the_speeds_contradict_it() {
    let (recording, truth) = recorded(None);
    let with = fitted(&recording, |_| ());
    let without = fitted(&recording, |track| track.feedback_nm = None);
    let slow = fitted(&recording, |track| filtered(track, 0.04));
    for (name, fit) in [("with", &with), ("without", &without), ("slow", &slow)] {
        println!("{name} feedback: lag {:?}, torque errors {:.3} N·m", fit.file.actuator.lag, errors(fit, &truth).torque_nm);
        assert_eq!(fit.file.actuator.input, ActuatorInput::COMMAND);
        assert!(fit.file.checks.iter().all(|check| check.outcome == CheckOutcome::Passed), "{:#?}", fit.file.checks);
        let lag = &fit.file.actuator.lag;
        assert!((lag.value_s - 0.048).abs() < 3.0 * lag.std_err_s.unwrap(), "{name}: {lag:?}");
    }
    let [with_s, without_s, slow_s] = [&with, &without, &slow].map(|fit| fit.file.actuator.lag.std_err_s.unwrap());
    assert!(with_s < 0.6 * without_s, "{with_s} {without_s}");
    // 40 ms more than the speeds show, with a standard error of some milliseconds at most
    assert!(slow_s > 0.9 * without_s, "{slow_s} {without_s}");
    assert!(errors(&with, &truth).torque_nm < 1.05 * errors(&without, &truth).torque_nm);
}

#[test]
fn a_feedback_of_another_scale_is_refused_with_the_reason() {
    for slew_limit_nm_s in [None, Some(60.0)] {
        let (recording, _) = recorded(slew_limit_nm_s);
        let high = fitted(&recording, |track| feedback(track).value.iter_mut().for_each(|u| *u *= 1.1));
        let without = fitted(&recording, |track| track.feedback_nm = None);
        let input = high.file.actuator.input.to_string();
        println!("{input}");
        assert!(input.starts_with("torque command (the feedback ") && input.contains("reads 10 % high"), "{input}");
        assert!(high.file.report.notes.iter().any(|n| n.contains("reads 10 % high")), "{:?}", high.file.report.notes);
        assert_eq!(high.csvs, without.csvs);
    }
}

#[test]
fn a_feedback_that_cannot_stand_in_is_refused_with_the_reason() {
    let (recording, _) = recorded(Some(60.0));
    let input = |change: &dyn Fn(&mut Track)| fitted(&recording, change).file.actuator.input.to_string();
    let keep = |track: &mut Track, kept: &dyn Fn(usize, f64) -> bool| {
        let own = feedback(track);
        let (t_s, value) =
            own.t_s.iter().zip(&own.value).enumerate().filter(|(k, (t, _))| kept(*k, **t)).map(|(_, (t, v))| (*t, *v)).unzip();
        *own = Series { t_s, value };
    };
    for (why, change) in [
        ("has the other sign", &(|track: &mut Track| feedback(track).value.iter_mut().for_each(|u| *u = -*u)) as &dyn Fn(&mut Track)),
        ("reads 2.0 N·m low", &|track| feedback(track).value.iter_mut().for_each(|u| *u -= 2.0)),
        ("instead of 40.0 N·m", &|track| feedback(track).value.iter_mut().for_each(|u| *u = u.min(37.0))),
        ("comes at 8.3 Hz only", &|track| keep(track, &|k, _| k % 3 == 0)),
        ("is missing in", &|track| keep(track, &|_, t| t % 5.0 > 1.0)),
    ] {
        let input_text = input(change);
        println!("{input_text}");
        assert!(input_text.starts_with("torque command (the feedback ") && input_text.contains(why), "{why}: {input_text}");
    }
    let given = fit::FitSettings { lag_s: Some(0.05), ..fit::FitSettings::default() };
    let actuator = fit(vec![surveyed(&recording, |_| ())], &given).unwrap().file.actuator;
    assert!(actuator.input.to_string().contains("dead time or lag are given") && actuator.lag.status == DelayStatus::Given, "{actuator:?}");
    let bare = surveyed(&recording, |track| {
        track.feedback_nm = None;
        track.source.file = "bare.mcap".into();
        track.source.sha256 = "0".repeat(64);
    });
    let input_text = fit(vec![surveyed(&recording, |_| ()), bare], &fit::FitSettings::default()).unwrap().file.actuator.input.to_string();
    assert!(input_text.starts_with("torque command (") && input_text.contains("not every log has one"), "{input_text}");
}

#[test]
fn a_gap_of_the_feedback_is_left_out_and_a_lost_reading_is_bridged() {
    let (recording, truth) = recorded(Some(60.0));
    // 0.3 % of the readings are lost anyway
    let usable = surveyed(&recording, |_| ());
    let stretch = usable.stretches.iter().max_by(|a, b| (a.to_s - a.from_s).total_cmp(&(b.to_s - b.from_s))).unwrap();
    let middle_s = 0.5 * (stretch.from_s + stretch.to_s);
    let seconds = |fit: &Fit| fit.file.report.ledger.iter().find(|row| row.verdict == SampleVerdict::Gap).map_or(0.0, |row| row.seconds);
    let settings = fit::FitSettings { drive: Some(DriveFamily::Feedback), ..fit::FitSettings::default() };
    let by_feedback = |change: &dyn Fn(&mut Track)| fit(vec![surveyed(&recording, change)], &settings).unwrap();
    let whole = by_feedback(&|_| ());
    let with_gap = by_feedback(&|track| {
        let own = feedback(track);
        let kept = own.t_s.iter().zip(&own.value).filter(|(t, _)| (**t - middle_s).abs() > 0.3);
        let (t_s, value) = kept.map(|(t, v)| (*t, *v)).unzip();
        *own = Series { t_s, value };
    });
    let more_s = seconds(&with_gap) - seconds(&whole);
    println!("{more_s:.2} s more of gaps; {:?}", errors(&with_gap, &truth));
    assert_eq!(with_gap.file.actuator.input.source, InputSource::TorqueFeedback);
    // 0.6 s without a reading, and up to a period at either end
    assert!((0.55..0.75).contains(&more_s), "{more_s}");
    assert!(errors(&with_gap, &truth).torque_nm < 0.2);
}

#[test]
fn the_input_is_the_same_at_every_wheel_angle() {
    let campaign = text("data/campaigns/wheel_angles.toml").replace("[0, 30, 60, 90]", "[60, 90]");
    let (recording, truth) = driven(&campaign, Some(60.0));
    let errors_of = |recording: &Recording| {
        let grouped = group_by_angle(std::slice::from_ref(recording), &[60.0, 90.0], &campaign::SurveySettings::default()).unwrap();
        let fit = fit_angles(grouped, true, 90.0, &fit::FitSettings::default()).unwrap().0;
        println!("{} {:?}", fit.file.actuator.input, fit.file.report.notes);
        assert_eq!(fit.file.maps.len(), 2);
        let rms = accel_rms_mps2(&fit.file.maps, &truth);
        (fit, rms)
    };
    let (with, with_mps2) = errors_of(&recording);
    let mut bare = recording.clone();
    bare.signals.torque_feedback = None;
    let (without, without_mps2) = errors_of(&bare);
    println!("{with_mps2:.4} m/s² with the feedback, {without_mps2:.4} without");
    // one drive for all angles
    for fit in [&with, &without] {
        let actuator = &fit.file.actuator;
        let followed = actuator.input.source == InputSource::TorqueFeedback;
        let limited = actuator.drive.as_ref().is_some_and(|d| d.family == DriveFamily::RateLimit);
        assert!(followed || limited, "{actuator:?}");
    }
    let said = with.file.report.notes.iter().filter(|n| n.contains("the fit's input")).count();
    assert!(said <= 1, "once for all angles");
    assert!(with_mps2 < 0.02 && without_mps2 < 0.02);
}
