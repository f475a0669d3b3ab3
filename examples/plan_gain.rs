//! What five minutes of `plan` are worth beside five minutes of the uniform campaign:
//! `cargo run --release --example plan_gain -- [SEEDS]`; docs/plan.md tells the figures.
//!
//! The bundled scrubber drives two minutes of the uniform campaign, which are fitted. Then it drives either five minutes of the plan made
//! from that fit, or five minutes more of the uniform campaign. Each is fitted together with the first log and inverted; Table 2 is judged
//! against the simulator's own map. The uniform campaign is `data/campaigns/torque_steps.toml` with its runs shuffled and repeated, cut
//! where the time is over; the plan is cut at the same time.

#![allow(clippy::print_stdout)] // a study prints

use pivot_cal::campaign::{self, Survey};
use pivot_cal::fit::{self, PlanSettings, fit, plan};
use pivot_cal::invert::{self, invert};
use pivot_cal::log::{Source, VehicleOverrides, read_bytes};
use pivot_cal::map::{CsvRef, Gear, Table1File};
use pivot_cal::record::{Campaign, RunGroup, Torques, record};
use pivot_cal::signal::Track;
use pivot_cal::sim::VehicleFile;
use pivot_cal::units::RAD_PER_DEG;

type Fallible<T> = Result<T, Box<dyn std::error::Error>>;

const FIRST_S: f64 = 120.0;
const MORE_S: f64 = 300.0;
/// What the plan must reach of the uniform campaign's torque error.
const ENOUGH: f64 = 0.8;

fn main() -> Fallible<()> {
    let seeds: u64 = std::env::args().nth(1).map_or(Ok(5), |text| text.parse())?;
    let vehicle = VehicleFile::from_toml(include_str!("../data/vehicles/scrubber.toml"))?;
    let uniform = Campaign::from_toml(include_str!("../data/campaigns/torque_steps.toml"))?;
    let mut sums = [0.0; 3];
    for seed in 1..=seeds {
        let (first, _) = drive(&vehicle, &shuffled(&uniform, 100 * seed)?, FIRST_S, 100 * seed)?;
        let start = fit(vec![first.clone()], &fit::Settings::default())?;
        let planned = plan(&start.file, &PlanSettings { budget_s: MORE_S })?;
        let (more, more_s) = drive(&vehicle, &shuffled(&uniform, 100 * seed + 1)?, MORE_S, 100 * seed + 1)?;
        let (wanted, wanted_s) = drive(&vehicle, &Campaign::from_toml(&planned.to_toml())?, MORE_S, 100 * seed + 1)?;
        let before_nm = judged(&vehicle, &start.file)?;
        let uniform_nm = judged(&vehicle, &fit(vec![first.clone(), more], &fit::Settings::default())?.file)?;
        let plan_nm = judged(&vehicle, &fit(vec![first, wanted], &fit::Settings::default())?.file)?;
        println!(
            "seed {seed}: {before_nm:.4} N·m after {FIRST_S:.0} s; {uniform_nm:.4} with {more_s:.0} s uniform, {plan_nm:.4} with {wanted_s:.0} s planned (expected {:.4} → {:.4}): {:.3}",
            planned.std_err_nm,
            planned.std_err_after_nm,
            plan_nm / uniform_nm
        );
        for (sum, error) in sums.iter_mut().zip([before_nm, uniform_nm, plan_nm]) {
            *sum += error * error;
        }
    }
    let [before_nm, uniform_nm, plan_nm] = sums.map(|s| (s / seeds as f64).sqrt());
    let ratio = plan_nm / uniform_nm;
    println!("all: {before_nm:.4} N·m before, {uniform_nm:.4} uniform, {plan_nm:.4} planned: ratio {ratio:.3}");
    println!("{}: at most {ENOUGH} is asked for", if ratio <= ENOUGH { "reached" } else { "missed" });
    Ok(())
}

/// The campaign's runs one by one, in an order drawn from `seed`, three times over.
fn shuffled(campaign: &Campaign, seed: u64) -> Fallible<Campaign> {
    let mut runs = Vec::new();
    for round in 0..3 {
        let single: Vec<RunGroup> = campaign
            .plan(seed + 1000 * round)?
            .into_iter()
            .map(|run| RunGroup { torque_nm: Torques::One(run.torque_nm), repeats: 1, shuffle: false, ..run.settings })
            .collect();
        // an order of its own: by a hash of place, round and seed
        let key =
            |k: usize| (k as u64 + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15 ^ (seed + 1000 * round).wrapping_mul(0xD134_2543_DE82_EF95)) >> 20;
        let mut order: Vec<usize> = (0..single.len()).collect();
        order.sort_by_key(|k| (key(*k), *k));
        runs.extend(order.into_iter().map(|k| single[k].clone()));
    }
    Ok(Campaign { runs, ..campaign.clone() })
}

/// Drives as many of the campaign's runs as fit into `limit_s`; the survey of the log and its length.
fn drive(vehicle: &VehicleFile, campaign: &Campaign, limit_s: f64, seed: u64) -> Fallible<(Survey, f64)> {
    let mut runs: Vec<RunGroup> = campaign
        .plan(campaign.seed)?
        .into_iter()
        .map(|run| RunGroup { torque_nm: Torques::One(run.torque_nm), repeats: 1, shuffle: false, ..run.settings })
        .collect();
    loop {
        let recording = record(vehicle, &Campaign { runs: runs.clone(), ..campaign.clone() }, Some(seed))?;
        let length_s = recording.report.duration_s;
        if length_s <= limit_s {
            let log = read_bytes(
                recording.bytes,
                &format!("{}_{seed}.mcap", campaign.name.replace(' ', "_")),
                &Source::Detect,
                &VehicleOverrides::default(),
            )?;
            return Ok((Survey::new(Track::new(&log)?, &campaign::Settings::default())?, length_s));
        }
        // as many as ended in time, one fewer each time after that
        let in_time = recording.report.runs.iter().filter(|r| r.start_s + r.duration_s <= limit_s).count();
        runs.truncate(in_time.min(runs.len() - 1));
    }
}

/// Root mean square error of Table 2's torque over speeds 0 to 1.1 m/s and torques −24 to 40 N·m of both gears [N·m].
fn judged(vehicle: &VehicleFile, file: &Table1File) -> Fallible<f64> {
    let inversion = invert(file, CsvRef { file: "table1.json".into(), sha256: String::new() }, &invert::Settings::default())?;
    let truth = vehicle.truth()?;
    let (mut sum, mut count) = (0.0, 0);
    for gear in Gear::ALL {
        let map = inversion.file.maps.iter().find(|m| m.gear == gear).ok_or("no map of a gear")?;
        let table = map.table()?;
        for v in (0..=22).map(|k| 0.05 * f64::from(k)) {
            for torque_nm in (-12..=20).map(|k| 2.0 * f64::from(k)) {
                let accel = truth.gear_accel_mps2(gear, v, torque_nm, 90.0 * RAD_PER_DEG);
                if let Some(found_nm) = table.torque_from_accel_clamped(v, accel) {
                    sum += (found_nm - torque_nm).powi(2);
                    count += 1;
                }
            }
        }
    }
    Ok((sum / f64::from(count)).sqrt())
}
