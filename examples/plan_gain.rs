//! What five minutes of `plan` are worth beside five minutes of the uniform campaign:
//! `cargo run --release --example plan_gain -- [--seeds 101:116] [--minutes 5] [--first 1] [--vehicle sweeper] [--quiet] [--model] [--dump cells.csv]`.
//! docs/plan.md has the protocol and the figures. `--vehicle` takes the bundled sweeper instead of the scrubber, `--quiet` takes the
//! disturbance and the spread of the friction away: what is left is what no campaign removes. `--model` stops at what the model of `plan` expects. `--dump` writes errors and standard errors cell by cell.

#![allow(clippy::print_stdout)] // a study prints

#[path = "plan_gain/campaigns.rs"]
mod campaigns;
#[path = "../tests/common/yardstick.rs"]
mod yardstick;

use campaigns::{drive, in_order, shuffled};
use pivot_cal::fit;
use pivot_cal::fit::fit;
use pivot_cal::internals::{Campaign, ExpectedCell, RunGroup, Torques, VehicleFile, expected, known_maps};
use pivot_cal::map::Table1File;
use pivot_cal::plan::{PlanSettings, PlannedRun, plan};
use std::fmt::Write as _;
use yardstick::{Errors, Yardstick, rms};

type Fallible<T> = Result<T, Box<dyn std::error::Error>>;

/// What the plan must reach of the uniform campaign's torque error.
const ENOUGH: f64 = 0.8;
/// Slowest speed of the cells [m/s]: no reading determines the row of a wheel that has just begun to move, so it is reported separately.
const SLOWEST_MPS: f64 = 0.05;
/// Draws of the bootstrap.
const DRAWS: u64 = 10_000;

/// A bundled vehicle with its uniform campaign, and over what its maps are judged.
struct Case {
    vehicle: &'static str,
    /// Lines that are random in the vehicle file, and what they are without disturbance.
    quiet: [(&'static str, &'static str); 2],
    campaign: &'static str,
    /// Speed up to which maps are judged [m/s]: the uniform campaign's speed limit, ...
    fastest_mps: f64,
    /// ... and the speed from which it brakes: up to there it drives every level.
    braking_mps: f64,
    /// Torques over which maps are judged [N·m]: those of the uniform campaign, as far as the drive's power lets them come about.
    torques_nm: [f64; 2],
    /// Step of the torques of the cells that the plan is made for [N·m].
    step_nm: f64,
}

const SCRUBBER: Case = Case {
    vehicle: include_str!("../data/vehicles/scrubber.toml"),
    quiet: [("disturbance_nm = 0.25", "disturbance_nm = 0.0"), ("friction_spread = 0.01", "friction_spread = 0.0")],
    campaign: include_str!("../data/campaigns/torque_steps.toml"),
    fastest_mps: 1.2,
    braking_mps: 1.0,
    torques_nm: [-24.0, 40.0],
    step_nm: 4.0,
};

const SWEEPER: Case = Case {
    vehicle: include_str!("../data/vehicles/sweeper.toml"),
    quiet: [("disturbance_nm = 0.8", "disturbance_nm = 0.0"), ("friction_spread = 0.02", "friction_spread = 0.0")],
    campaign: include_str!("../data/campaigns/sweeper_steps.toml"),
    fastest_mps: 1.0,
    braking_mps: 0.9,
    torques_nm: [-60.0, 60.0],
    step_nm: 10.0,
};

/// The value after a flag, or its default.
fn after(flag: &str, otherwise: &str) -> String {
    let arguments: Vec<String> = std::env::args().collect();
    arguments.iter().position(|a| a == flag).and_then(|k| arguments.get(k + 1)).cloned().unwrap_or_else(|| otherwise.to_owned())
}

/// What is printed of each seed: before, uniform, planned [N·m].
const FIGURES: [&str; 6] = [
    "exact inverse",
    "exact inverse up to the speed of braking",
    "Table 2",
    "Table 2 up to the speed of braking",
    "exact inverse, just moving",
    "exact inverse with the cells that just move",
];
type Figures = [[f64; 3]; 6];

fn main() -> Fallible<()> {
    let seeds = after("--seeds", "101:116");
    let (from, to) = seeds.split_once(':').unwrap_or((&seeds, &seeds));
    let (from, to): (u64, u64) = (from.parse()?, to.parse()?);
    let more_s = 60.0 * after("--minutes", "5").parse::<f64>()?;
    let first_s = 60.0 * after("--first", "1").parse::<f64>()?;
    let dump = after("--dump", "");
    let flag = |name: &str| std::env::args().any(|a| a == name);
    let (model_only, quiet) = (flag("--model"), flag("--quiet"));
    let case = match after("--vehicle", "scrubber").as_str() {
        "scrubber" => SCRUBBER,
        "sweeper" => SWEEPER,
        other => return Err(format!("--vehicle: {other:?}; allowed: scrubber, sweeper").into()),
    };
    let Case { fastest_mps, braking_mps, torques_nm, .. } = case;
    let mut text = case.vehicle.to_owned();
    if quiet {
        text = case.quiet.iter().fold(text, |text, (random, none)| text.replace(random, none));
    }
    // plans are made by what the vehicle is really like
    let planning = VehicleFile::from_toml(case.vehicle)?;
    let vehicle = VehicleFile::from_toml(&text)?;
    let uniform = Campaign::from_toml(case.campaign)?;
    let yardstick = Yardstick::new(&vehicle, fastest_mps, torques_nm)?;
    match yardstick.judge(&known_maps(&vehicle.settings())?.0) {
        Ok(known) => println!(
            "{} cells; the known map, which ends at {braking_mps} m/s, up to there through the same inversion: {:.4} N·m by Table 2, {:.4} exactly inverted",
            yardstick.cells.len(),
            yardstick.rms_between(&known.table, SLOWEST_MPS, braking_mps),
            yardstick.rms_between(&known.surface, SLOWEST_MPS, braking_mps)
        ),
        // a drive at its limit of power answers more torque by nothing
        Err(error) => println!("{} cells; the known map has no inverse: {error}", yardstick.cells.len()),
    }
    let mut all: Vec<Figures> = Vec::new();
    let mut rows = "seed,arm,gear,speed_mps,torque_nm,table_nm,surface_nm,std_err_nm,model_nm\n".to_owned();
    for seed in from..=to {
        // the first campaign, and the uniform one going on from there
        let runs = shuffled(&uniform, seed, 4)?;
        let first = drive(&vehicle, &uniform, &runs, first_s, 100 * seed)?;
        let more = drive(&vehicle, &uniform, &runs[first.runs..], more_s, 100 * seed + 1)?;
        let start = fit(vec![drive(&planning, &uniform, &runs, first_s, 100 * seed)?.survey], &fit::FitSettings::default())?.file;
        let wish = PlanSettings {
            budget_s: more_s,
            speed_breaks_mps: Some(yardstick.speeds_mps()),
            torque_breaks_nm: Some(in_steps(torques_nm, case.step_nm)),
        };
        let planned = plan(&start, &wish)?;
        let campaign = Campaign { topics: uniform.topics, ..Campaign::from_toml(&planned.to_toml(None)?)? };
        let wanted_runs = in_order(&campaign)?;
        let wanted = drive(&vehicle, &campaign, &wanted_runs, more_s, 100 * seed + 1)?;
        let first_cells = model_cells(&start, &wish, &[])?;
        let uniform_cells = model_cells(&start, &wish, &runs[first.runs..first.runs + more.runs])?;
        let plan_cells = model_cells(&start, &wish, &wanted_runs[..wanted.runs])?;
        let [uniform_expected, plan_expected] =
            [&uniform_cells, &plan_cells].map(|cells| rms(&cells.iter().map(|c| c.std_err_nm).collect::<Vec<_>>()));
        if model_only {
            println!(
                "seed {seed}: by the model {:.4} → {uniform_expected:.4}, {plan_expected:.4}: {:.3}",
                planned.std_err_nm,
                plan_expected / uniform_expected
            );
            if !dump.is_empty() {
                std::fs::write(&dump, planned.to_toml(None)?)?;
            }
            continue;
        }
        let by_uniform = fit(vec![first.survey.clone(), more.survey], &fit::FitSettings::default())?.file;
        let by_plan = fit(vec![first.survey, wanted.survey], &fit::FitSettings::default())?.file;
        let files = [&start, &by_uniform, &by_plan];
        let mut errors = Vec::new();
        for file in files {
            errors.push(yardstick.judge(file)?);
        }
        if !dump.is_empty() {
            for (((arm, file), errors), cells) in
                ["first", "uniform", "plan"].into_iter().zip(files).zip(&errors).zip([&first_cells, &uniform_cells, &plan_cells])
            {
                write_cells(&mut rows, (seed, arm), file, &yardstick, errors, cells)?;
            }
            std::fs::write(&dump, &rows)?;
        }
        let of = |f: &dyn Fn(&Errors) -> f64| [f(&errors[0]), f(&errors[1]), f(&errors[2])];
        let figures: Figures = [
            of(&|e| yardstick.rms_between(&e.surface, SLOWEST_MPS, fastest_mps)),
            of(&|e| yardstick.rms_between(&e.surface, SLOWEST_MPS, braking_mps)),
            of(&|e| yardstick.rms_between(&e.table, SLOWEST_MPS, fastest_mps)),
            of(&|e| yardstick.rms_between(&e.table, SLOWEST_MPS, braking_mps)),
            of(&|e| yardstick.rms_between(&e.surface, 0.0, 0.0)),
            of(&|e| rms(&e.surface)),
        ];
        let shown: Vec<String> = figures.iter().map(|[a, b, c]| format!("{a:.4} {b:.4} {c:.4}: {:.3}", c / b)).collect();
        println!(
            "seed {seed}: exact inverse {}; to {braking_mps} m/s {}; Table 2 {}; to {braking_mps} m/s {}; just moving {}; with it {}; {:.0} s uniform, {:.0} s planned, {} of {} runs, \
             {:.0} s promised; by the model {:.4} → {uniform_expected:.4}, {plan_expected:.4}: {:.3}; outside {} {} {}",
            shown[0],
            shown[1],
            shown[2],
            shown[3],
            shown[4],
            shown[5],
            more.seconds,
            wanted.seconds,
            wanted.runs,
            wanted_runs.len(),
            planned.seconds,
            planned.std_err_nm,
            plan_expected / uniform_expected,
            errors[0].outside,
            errors[1].outside,
            errors[2].outside,
        );
        all.push(figures.map(|e| e.map(|x| x * x)));
    }
    for (which, name) in FIGURES.into_iter().enumerate() {
        let squares: Vec<[f64; 3]> = all.iter().map(|s| s[which]).collect();
        print_pooled(name, &squares);
    }
    Ok(())
}

/// Pooled errors, their ratio and its spread over the seeds.
fn print_pooled(name: &str, squares: &[[f64; 3]]) {
    let pooled = |k: usize| (squares.iter().map(|s| s[k]).sum::<f64>() / squares.len() as f64).sqrt();
    let ratio = pooled(2) / pooled(1);
    // bootstrap over the seeds, paired
    let mut state = 1u64;
    let mut ratios: Vec<f64> = (0..DRAWS)
        .map(|_| {
            let (mut by_plan, mut by_uniform) = (0.0, 0.0);
            for _ in squares {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                let drawn = squares[((state >> 33) as usize) % squares.len()];
                by_uniform += drawn[1];
                by_plan += drawn[2];
            }
            (by_plan / by_uniform).sqrt()
        })
        .collect();
    ratios.sort_unstable_by(f64::total_cmp);
    let quantile = |q: f64| ratios[((q * DRAWS as f64) as usize).min(ratios.len() - 1)];
    let better = squares.iter().filter(|s| s[2] < s[1]).count();
    println!(
        "{name}: {:.4} N·m before, {:.4} uniform, {:.4} planned: ratio {ratio:.3}, 95 % {:.3} to {:.3} by bootstrap; better in {better} of {} seeds; {}: at most {ENOUGH} is required",
        pooled(0),
        pooled(1),
        pooled(2),
        quantile(0.025),
        quantile(0.975),
        squares.len(),
        if ratio <= ENOUGH { "reached" } else { "missed" }
    );
}

/// What the model of `plan` expects of runs: root mean square over the cells at which maps are judged [N·m].
fn model_cells(start: &Table1File, wish: &PlanSettings, runs: &[RunGroup]) -> Fallible<Vec<ExpectedCell>> {
    let runs: Vec<PlannedRun> = runs
        .iter()
        .filter_map(|run| {
            let Torques::One(torque_nm) = run.torque_nm else { return None };
            Some(PlannedRun {
                gear: run.gear,
                torque_nm,
                start_speed_mps: run.start_speed_mps,
                spin_up_nm: (run.start_speed_mps > 0.0).then_some(run.spin_up_nm),
                speed_limit_mps: run.speed_limit_mps,
                end_speed_mps: run.end_speed_mps,
                hold_s: run.hold_s,
            })
        })
        .collect();
    Ok(expected(start, wish, &runs)?)
}

/// From the lowest torque to the highest every `step_nm` [N·m].
fn in_steps([low, high]: [f64; 2], step_nm: f64) -> Vec<f64> {
    let steps = ((high - low) / step_nm + 1e-9) as u32;
    (0..=steps).map(|k| low + f64::from(k) * step_nm).collect()
}

/// One line per cell, for maps of the error.
fn write_cells(
    rows: &mut String,
    (seed, arm): (u64, &str),
    file: &Table1File,
    yardstick: &Yardstick,
    errors: &Errors,
    model: &[ExpectedCell],
) -> Fallible<()> {
    for ((cell, table_nm), surface_nm) in yardstick.cells.iter().zip(&errors.table).zip(&errors.surface) {
        let map = file.maps.iter().find(|m| m.gear == cell.gear).ok_or("no Table 1 of a gear")?;
        let nearest = |breaks: &[f64], x: f64| {
            (0..breaks.len()).min_by(|a, b| (breaks[*a] - x).abs().total_cmp(&(breaks[*b] - x).abs())).unwrap_or_default()
        };
        let (i, j) = (nearest(&map.torque_nm, cell.torque_nm), nearest(&map.speed_mps, cell.speed_mps));
        let surface = map.surface.table()?;
        let at = |u: f64| surface.accel_from_torque_clamped(cell.speed_mps, u).unwrap_or_default();
        let slope = (at(cell.torque_nm + 1.0) - at(cell.torque_nm - 1.0)) / 2.0;
        let expected = model
            .iter()
            .filter(|c| c.gear == cell.gear && (c.speed_mps - cell.speed_mps).abs() < 1e-6)
            .min_by(|a, b| (a.torque_nm - cell.torque_nm).abs().total_cmp(&(b.torque_nm - cell.torque_nm).abs()));
        writeln!(
            rows,
            "{seed},{arm},{},{:.2},{},{table_nm:.5},{surface_nm:.5},{:.5},{:.5}",
            cell.gear,
            cell.speed_mps,
            cell.torque_nm,
            map.std_err_mps2[i][j] / slope,
            expected.map_or(f64::NAN, |c| c.std_err_nm)
        )?;
    }
    Ok(())
}
