//! From a log to Table 1, judged against answers that do not come from the estimator: the answer key and the dynamometer of a vehicle
//! simulated by other software, and the exact map of the bundled simulator.

#![allow(clippy::unwrap_used, clippy::print_stdout)] // a test says what it measured

#[path = "common/program.rs"]
mod program;

use pivot_cal::campaign;
use pivot_cal::campaign::Survey;
use pivot_cal::control::RAD_PER_DEG;
use pivot_cal::fit;
use pivot_cal::fit::{Fit, fit};
use pivot_cal::internals::{Campaign, VehicleFile, record};
use pivot_cal::invert;
use pivot_cal::invert::invert;
use pivot_cal::log::{Recording, SignalMap, Source, VehicleOverrides, read, read_bytes};
use pivot_cal::map::{CellStatus, CsvRef, Gear, SampleVerdict, Table1File};
use pivot_cal::signal::Track;
use program::{repo, text};

/// When the reference drive's answer key starts [ns].
const MESSY_START_NS: i64 = 1_764_667_800_123_456_789;

fn survey(recording: &Recording) -> Survey {
    Survey::new(Track::new(recording).unwrap(), &campaign::SurveySettings::default()).unwrap()
}

fn messy() -> (Survey, Fit) {
    messy_with(|track| track)
}

/// The messy drive and the mini one, each changed before it is surveyed.
fn messy_with(change: impl Fn(Track) -> Track) -> (Survey, Fit) {
    let source = Source::Map(SignalMap::from_toml(&text("data/signals/reference.toml")).unwrap());
    let read = |path: &str| {
        let recording = read(repo(path).as_ref(), &source, &VehicleOverrides::default(), &|_| {}).unwrap();
        Survey::new(change(Track::new(&recording).unwrap()), &campaign::SurveySettings::default()).unwrap()
    };
    let messy = read("tests/data/reference_messy.zstd.mcap");
    let fit = fit(vec![messy.clone(), read("tests/data/mini_ros2.zstd.mcap")], &fit::FitSettings::default()).unwrap();
    (messy, fit)
}

struct Event {
    from_s: f64,
    to_s: f64,
    kind: String,
}

fn events() -> Vec<Event> {
    text("tests/data/reference_messy_events.csv")
        .lines()
        .skip(1)
        .map(|line| {
            let cells: Vec<&str> = line.split(',').collect();
            Event { from_s: cells[0].parse().unwrap(), to_s: cells[1].parse().unwrap(), kind: cells[2].to_owned() }
        })
        .collect()
}

/// The truth of the reference vehicle: (speed, torque, acceleration), forward gear.
fn truth() -> Vec<(f64, f64, f64)> {
    text("tests/data/reference_truth.csv")
        .lines()
        .skip(1)
        .map(|line| {
            let cells: Vec<f64> = line.split(',').map(|c| c.parse().unwrap()).collect();
            (cells[0], cells[1], cells[2])
        })
        .collect()
}

/// Errors of Table 1 on its measured cells that the dynamometer visited, sorted [m/s²].
fn errors_on_measured_cells(fit: &Fit) -> Vec<f64> {
    let map = &fit.file.maps[0];
    let table = map.table().unwrap();
    let mut errors: Vec<f64> = truth()
        .iter()
        .filter_map(|(v, u, a)| {
            let (i, j) = (table.torque_nm().nearest(*u), table.speed_mps().nearest(*v));
            let same = (table.torque_nm().breaks()[i] - u).abs() < 1e-6 && (table.speed_mps().breaks()[j] - v).abs() < 1e-6;
            (same && map.status[i][j] == CellStatus::Measured).then(|| (table.at(j, i) - a).abs())
        })
        .collect();
    errors.sort_unstable_by(f64::total_cmp);
    errors
}

fn quantile(sorted: &[f64], share: f64) -> f64 {
    sorted[((sorted.len() - 1) as f64 * share) as usize]
}

#[test]
fn the_encoder_alone_shows_the_delays_and_the_table() {
    let (survey, fit) = messy_with(|track| Track { yaw_speed_mps: None, ..track });
    let own = fit.file.logs.iter().position(|l| *l == survey.track.source).unwrap();
    // the encoder reads 8 to 10 ms late, which nothing but the dead time can take up
    let actuator = &fit.file.actuator;
    let sum_s = actuator.lag.value_s + actuator.per_log[own].dead_time.value_s;
    let errors = errors_on_measured_cells(&fit);
    println!("{sum_s:.4} s; {} cells: median {:.4}, 95 % {:.4} m/s²", errors.len(), quantile(&errors, 0.5), quantile(&errors, 0.95));
    assert!((sum_s - 0.110).abs() < 0.010, "{actuator:?}");
    assert!(errors.len() > 60 && quantile(&errors, 0.5) < 0.02 && quantile(&errors, 0.95) < 0.1);
}

#[test]
fn a_messy_drive_is_judged_as_its_answer_key_says_and_fits_its_dynamometer() {
    let (survey, fit) = messy();
    let events = events();
    let times: Vec<f64> = survey.track.encoder_mps.t_s.iter().map(|t| t + (survey.track.start_ns - MESSY_START_NS) as f64 * 1e-9).collect();
    let own = fit.file.logs.iter().position(|l| *l == survey.track.source).unwrap();
    let verdicts = &fit.verdicts[own];
    assert_eq!(verdicts.len(), times.len(), "every sample has one verdict");

    let bad = ["aborted", "estop", "slip", "hand_push", "wrong_angle", "steering", "drive_straight", "drive_curve"];
    let clean = ["step", "coast", "spinup", "step_from_speed", "step_after_slip"];
    // the key has the times of the commands; dead time and lag pass before the vehicle follows
    let settle_s = 0.3;
    let (mut moving, mut used) = (0, 0);
    let mut left_out = std::collections::BTreeMap::new();
    let mut at_angle_since = f64::NEG_INFINITY;
    for (t, verdict) in times.iter().zip(verdicts) {
        let Some(event) = events.iter().find(|e| *t >= e.from_s && *t < e.to_s) else { continue };
        let kind = event.kind.as_str();
        assert!(!(bad.contains(&kind) && *verdict == SampleVerdict::Used), "a sample of {kind} at {t:.2} s is used");
        if matches!(verdict, SampleVerdict::WheelNotAtAngle | SampleVerdict::SteeringMoving) {
            at_angle_since = t + 0.1;
        }
        let resting = matches!(verdict, SampleVerdict::AtRest | SampleVerdict::NoTorque);
        if clean.contains(&kind) && *t > event.from_s + settle_s && *t > at_angle_since && !resting {
            moving += 1;
            used += usize::from(*verdict == SampleVerdict::Used);
            if *verdict != SampleVerdict::Used {
                *left_out.entry((kind, verdict.to_string())).or_insert(0) += 1;
            }
        }
    }
    println!("{used} of {moving} clean moving samples are used; left out: {left_out:?}");
    assert!(moving > 500 && used as f64 >= 0.95 * f64::from(moving));

    // two minutes of data, half of it messy: a third of what the table needs. Half of the measured cells within 0.02 m/s², 95 % within
    // 0.1 m/s²: about 0.25 and 1.3 N·m, a third of what binning and differencing reaches with five times the data
    let errors = errors_on_measured_cells(&fit);
    println!("{} cells: median {:.4}, 95 % {:.4} m/s²", errors.len(), quantile(&errors, 0.5), quantile(&errors, 0.95));
    assert!(errors.len() > 60 && quantile(&errors, 0.5) < 0.02 && quantile(&errors, 0.95) < 0.1);

    // lag 50 ms; dead time 51 ms as this drive's stamps show it
    let actuator = &fit.file.actuator;
    assert!((actuator.lag.value_s - 0.050).abs() < 0.015, "{:?}", actuator.lag);
    assert!((actuator.lag.value_s + actuator.per_log[own].dead_time.value_s - 0.101).abs() < 0.010, "{:?}", actuator.per_log);
    assert_monotone(&fit.file);
}

/// Both tables rise, everywhere.
fn assert_monotone(file: &Table1File) {
    let inversion = invert(file, CsvRef { file: "table1.json".into(), sha256: String::new() }, &invert::InvertSettings::default()).unwrap();
    for map in &file.maps {
        for rows in map.accel_mps2.windows(2) {
            assert!(rows[0].iter().zip(&rows[1]).all(|(low, high)| high > low), "Table 1 does not rise");
        }
    }
    for map in &inversion.file.maps {
        assert!(map.torque_nm.iter().all(|row| row.windows(2).all(|w| w[1] >= w[0])), "Table 2 falls");
    }
}

#[test]
fn a_simulated_campaign_gives_back_the_simulators_own_map() {
    let vehicle = VehicleFile::from_toml(&text("data/vehicles/scrubber.toml")).unwrap();
    let campaign = Campaign::from_toml(&text("data/campaigns/torque_steps.toml")).unwrap();
    let seed = 11;
    println!("seed {seed}");
    let recording = record(&vehicle, &campaign, Some(seed)).unwrap();
    let recording = read_bytes(recording.bytes, "campaign.mcap", &Source::Detect, &VehicleOverrides::default()).unwrap();
    let fit = fit(vec![survey(&recording)], &fit::FitSettings::default()).unwrap();
    assert_monotone(&fit.file);
    let truth = vehicle.truth().unwrap();
    for gear in Gear::ALL {
        let map = fit.file.maps.iter().find(|m| m.gear == gear).unwrap();
        let (mut inside, mut cells) = (0, 0);
        let mut errors = Vec::new();
        for (i, u) in map.torque_nm.iter().enumerate() {
            for (j, v) in map.speed_mps.iter().enumerate() {
                if map.status[i][j] == CellStatus::Measured && *v > 0.0 {
                    let error = (map.accel_mps2[i][j] - truth.gear_accel_mps2(gear, *v, *u, 90.0 * RAD_PER_DEG)).abs();
                    cells += 1;
                    inside += usize::from(error <= 1.96 * map.std_err_mps2[i][j]);
                    errors.push(error);
                }
            }
        }
        errors.sort_unstable_by(f64::total_cmp);
        let share = inside as f64 / f64::from(cells);
        println!("{gear}: {cells} cells, 95 % intervals hold {:.0} %, median error {:.4} m/s²", 100.0 * share, errors[errors.len() / 2]);
        // one campaign's errors go together; the pooled study over seeds is `examples/coverage.rs`
        assert!(share > 0.7, "{gear}: {share}");
        assert!(errors[errors.len() / 2] < 0.02);
        let breakaway = truth.breakaway_nm(gear, 90.0 * RAD_PER_DEG);
        assert!((map.breakaway.torque_nm - breakaway).abs() < 2.0, "{gear}: {:?}, true {breakaway}", map.breakaway);
    }
}
