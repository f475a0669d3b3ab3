//! What to drive next: a campaign that `record` drives in the time it promises, and that first fills what is missing.

#![allow(clippy::unwrap_used)]

#[path = "common/yardstick.rs"]
mod yardstick;

use pivot_cal::internals::{Campaign, VehicleFile, expected, known_maps, record};
use pivot_cal::map::{Gear, Table1File};
use pivot_cal::plan::{PlanSettings, Proposal, plan};
use std::sync::LazyLock;
use yardstick::{Yardstick, rms};

type Fallible<T> = Result<T, Box<dyn std::error::Error>>;

/// The demo's table, on a coarse lattice: that keeps the tests quick.
static TABLE1: LazyLock<Table1File> = LazyLock::new(|| {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("maps/table1.json");
    let mut file = Table1File::from_json(&std::fs::read_to_string(path).unwrap()).unwrap();
    file.settings["speed_nodes"] = 8.into();
    file.settings["torque_nodes"] = 10.into();
    file
});

static PLANNED: LazyLock<Proposal> = LazyLock::new(|| planned(&TABLE1));

fn scrubber() -> VehicleFile {
    VehicleFile::from_toml(include_str!("../data/vehicles/scrubber.toml")).unwrap()
}

fn wish(budget_s: f64) -> PlanSettings {
    PlanSettings { budget_s, ..PlanSettings::default() }
}

fn planned(file: &Table1File) -> Proposal {
    plan(file, &wish(30.0)).unwrap()
}

#[test]
fn a_plan_is_a_campaign_within_its_time_and_the_most_useful_run_comes_first() {
    let plan = &*PLANNED;
    assert_eq!(*plan, planned(&TABLE1), "the same table gives the same plan");
    let text = plan.to_toml(None).unwrap();
    let campaign = Campaign::from_toml(&text).unwrap();
    let runs = campaign.plan(1).unwrap();
    assert_eq!(runs.len(), plan.runs as usize);
    let limit_nm = TABLE1.vehicle.torque_limit_nm.unwrap();
    assert!(runs.iter().all(|r| r.torque_nm.abs() <= limit_nm && r.settings.spin_up_nm <= limit_nm));
    assert!(plan.seconds <= 30.0 && plan.seconds > 24.0, "{} s", plan.seconds);
    assert!(plan.std_err_after_nm < plan.std_err_nm);
    let first = plan.entries[0].gain_nm_per_s;
    assert!(plan.entries.iter().all(|e| e.gain_nm_per_s > 0.0 && e.gain_nm_per_s <= first));
    assert!(plan.entries.iter().all(|e| text.contains(&e.reason) && e.reason.contains("have a standard error of ")));
}

#[test]
fn record_drives_a_plan_in_the_time_it_promises_and_every_level_happens() {
    let campaign = Campaign::from_toml(&PLANNED.to_toml(None).unwrap()).unwrap();
    let report = record(&scrubber(), &campaign, Some(3)).unwrap().report;
    // the driver's cycles and the run's friction: a tenth of a second per run
    let off_s = report.duration_s - PLANNED.seconds;
    assert!(off_s.abs() < 0.1 * f64::from(PLANNED.runs) + 0.5, "{} s instead of {}", report.duration_s, PLANNED.seconds);
    // a spin-up overshoots: it must not end the braking that it is for
    let ended = |end| serde_json::to_value(end).unwrap();
    let braking: Vec<_> = report.runs.iter().filter(|r| r.torque_nm < 0.0).collect();
    assert!(!braking.is_empty() && braking.iter().all(|r| ended(r.end) == "slowed" && r.duration_s > 0.2), "{braking:?}");
    assert!(report.runs.iter().all(|r| ended(r.end) != "no_spin_up"));
}

#[test]
fn braking_that_is_missing_is_driven_first() {
    let mut file = TABLE1.clone();
    // both gears: what one gear does the other mostly does too
    file.report.runs.retain(|r| r.torque_nm > 4.5);
    let missing = planned(&file);
    assert!(missing.std_err_nm > 1.2 * PLANNED.std_err_nm, "{} {}", missing.std_err_nm, PLANNED.std_err_nm);
    let first = missing.entries[0].run;
    assert!(first.torque_nm < 0.0 && first.spin_up_nm.is_some(), "{first:?}");
}

#[test]
fn one_gear_that_was_hardly_driven_comes_first() {
    let mut file = TABLE1.clone();
    let mut kept = 0;
    file.report.runs.retain(|r| {
        kept += u32::from(r.gear == Gear::Reverse);
        r.gear == Gear::Forward || kept <= 3
    });
    assert_eq!(planned(&file).entries[0].run.gear, Gear::Reverse);
}

#[test]
fn cells_that_are_asked_for_are_what_runs_are_for() {
    let asked = PlanSettings {
        speed_breaks_mps: Some(vec![0.0, 0.1, 0.2, 0.3, 0.4]),
        torque_breaks_nm: Some(vec![-8.0, 0.0, 8.0, 16.0, 24.0, 60.0]),
        ..wish(20.0)
    };
    let plan = plan(&TABLE1, &asked).unwrap();
    // the limit is 44 N·m; a level that slows down is not ended by its speed
    assert!(plan.entries.iter().all(|e| (-8.0..=24.0).contains(&e.run.torque_nm) && e.run.start_speed_mps < 0.5));
    let after = expected(&TABLE1, &asked, &[]).unwrap();
    assert!(after.iter().all(|c| c.speed_mps > 0.0 && c.torque_nm < 44.0));
    assert!((rms(&after.iter().map(|c| c.std_err_nm).collect::<Vec<_>>()) - plan.std_err_nm).abs() < 1e-6);
}

#[test]
fn cells_beyond_the_torques_of_the_table_weigh_as_those_at_its_end() {
    let surface = TABLE1.maps[0].surface.table().unwrap();
    let (low, high) = (surface.torque_nm().first(), surface.torque_nm().last());
    let torques = vec![low - 2.0, low, high, high + 1.0]; // the vehicle takes 44 N·m
    let asked = PlanSettings { speed_breaks_mps: Some(vec![0.3, 0.6]), torque_breaks_nm: Some(torques.clone()), ..wish(20.0) };
    let cells = expected(&TABLE1, &asked, &[]).unwrap();
    let at = |torque_nm: f64| {
        let errors: Vec<f64> = cells.iter().filter(|c| (c.torque_nm - torque_nm).abs() < 1e-9).map(|c| c.std_err_nm).collect();
        rms(&errors)
    };
    for [end, beyond] in [[torques[1], torques[0]], [torques[2], torques[3]]] {
        let ratio = at(beyond) / at(end);
        assert!((0.9..1.4).contains(&ratio), "{ratio} from {end} to {beyond} N·m");
    }
}

/// The runs as `record` drives them, the information as the estimator has it: so the model expects about the standard errors that the fit then reports.
#[test]
fn what_the_model_expects_of_the_runs_driven_is_about_what_the_fit_shows_of_them() {
    for map in &TABLE1.maps {
        // near standstill, where the coarse lattice of these tests is too coarse, neither is held to the other
        let speeds = map.speed_mps.iter().copied().filter(|v| *v > 0.15).collect();
        let asked = PlanSettings { speed_breaks_mps: Some(speeds), torque_breaks_nm: Some(map.torque_nm.clone()), ..wish(20.0) };
        let cells = expected(&TABLE1, &asked, &[]).unwrap();
        let table = map.surface.table().unwrap();
        let mut pairs = Vec::new();
        for cell in cells.iter().filter(|c| c.gear == map.gear) {
            let place = |breaks: &[f64], x: f64| breaks.iter().position(|b| (b - x).abs() < 1e-9);
            let (Some(i), Some(j)) = (place(&map.torque_nm, cell.torque_nm), place(&map.speed_mps, cell.speed_mps)) else { continue };
            let at = |u: f64| table.accel_from_torque_clamped(cell.speed_mps, u).unwrap();
            let slope = (at(cell.torque_nm + 0.5) - at(cell.torque_nm - 0.5)).max(0.01);
            pairs.push((cell.std_err_nm, map.std_err_mps2[i][j] / slope));
        }
        let (model, fitted): (Vec<f64>, Vec<f64>) = pairs.into_iter().unzip();
        let ratio = rms(&model) / rms(&fitted);
        assert!((0.77..1.3).contains(&ratio), "{}: {} by the model, {} by the fit", map.gear, rms(&model), rms(&fitted));
    }
}

#[test]
fn what_cannot_be_planned_is_reported() {
    let refusal = |file: &Table1File, settings: &PlanSettings| plan(file, settings).unwrap_err().to_string();
    assert!(refusal(&TABLE1, &wish(3.0)).contains("no run fits"));
    let braking_only = PlanSettings { torque_breaks_nm: Some(vec![-20.0, -4.0]), ..wish(20.0) };
    assert!(refusal(&TABLE1, &braking_only).contains("are -20 to -4 N·m"));
    let mut file = TABLE1.clone();
    file.report.runs.clear();
    assert!(refusal(&file, &wish(20.0)).contains("Drive a first campaign"));
}

/// The yardstick of the study: the known map is without error on it, and what lies beyond a map's end is counted, not taken for an error of
/// the map unseen.
#[test]
fn the_known_map_is_without_error_on_the_yardstick_of_the_study() {
    let vehicle = scrubber();
    let (table1, _) = known_maps(&vehicle.settings()).unwrap();
    let within = Yardstick::new(&vehicle, 1.0, [-24.0, 40.0]).unwrap();
    assert_eq!((within.speeds_mps().len(), within.cells.len()), (20, 2 * 21 * 33));
    let errors = within.judge(&table1).unwrap();
    // lines between 0.01 m/s and 1 N·m
    assert!(rms(&errors.surface) < 1e-3 && errors.outside == 0, "{} {}", rms(&errors.surface), errors.outside);
    // breaks every 0.05 m/s: they cost where friction changes fast, most of all at the row of a wheel that has just begun to move
    let [moving_nm, just_moving_nm] = [(0.05, 1.0), (0.0, 0.0)].map(|(from, to)| within.rms_between(&errors.table, from, to));
    assert!(moving_nm < 0.02 && just_moving_nm < 0.15, "{moving_nm} {just_moving_nm}");
    let beyond = Yardstick::new(&vehicle, 1.1, [-24.0, 40.0]).unwrap();
    let errors = beyond.judge(&table1).unwrap();
    assert_eq!(errors.outside, beyond.cells.iter().filter(|c| c.speed_mps > 1.0 + 1e-9).count());
    assert!(rms(&errors.table) > 0.1, "{}", rms(&errors.table));
}
