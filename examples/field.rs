//! How the estimator does on drives and sensors as they are in the field: vehicles with one thing changed, several seeds each.
//!
//! `cargo run --release --example field -- [--seeds 3] [--kinds base,slew,…]`
//!
//! Every kind changes one thing of each of three vehicles. A campaign of five levels from rest and five braking levels in both gears is
//! recorded and fitted without any option. Per kind: the root mean square torque error of Table 2 over the cells that Table 1 calls
//! measured, the share of them within 1.96 reported standard errors, the share that is confidently wrong (above 1 N·m and 3 standard
//! errors), and the drive that was reported.

#![allow(clippy::print_stdout)] // a study prints

use pivot_cal::internals::{Campaign, VehicleFile, record};
use pivot_cal::map::{Check, Table1File};
use std::collections::BTreeMap;

#[path = "../tests/common/field_campaign.rs"]
mod field_campaign;
#[path = "../tests/common/measured_cells.rs"]
mod measured_cells;
#[path = "../tests/common/vehicle_text.rs"]
mod vehicle_text;

use field_campaign::{CAMPAIGN, SCRUBBER, fitted};
use measured_cells::measured_cells;
use vehicle_text::changed;

type Fallible<T> = Result<T, Box<dyn std::error::Error>>;

/// Kinds: a name, what is put into the vehicle file below a heading, and what is put before the campaign.
type Kind = (&'static str, &'static [(&'static str, &'static str)], &'static str);

const KINDS: [Kind; 17] = [
    ("base", &[], ""),
    ("slew", &[("[drive]", "slew_limit_nm_s = 60.0")], ""),
    ("two slopes", &[("[drive]", "slew_limit_nm_s = 50.0\nslew_fall_limit_nm_s = 150.0")], ""),
    ("resonant", &[("[drive]", "frequency_hz = 6.0\ndamping = 0.2")], ""),
    ("damped second order", &[("[drive]", "frequency_hz = 4.0\ndamping = 0.7")], ""),
    ("power limit", &[("[motion]", "power_limit_w = 140.0")], ""),
    ("high power limit", &[("[motion]", "power_limit_w = 220.0")], ""),
    ("torque limit", &[("[drive]", "torque_limit_nm = 30.0")], ""),
    ("governor", &[("[motion]", "governor_mps = [0.58, 0.64]"), ("[sensors.torque_feedback]", "shows_limits = true")], ""),
    ("coarse encoder", &[("[sensors.encoder]", "counts_per_rev = 300")], ""),
    ("feedback of 80 %", &[("[sensors.torque_feedback]", "scale = 0.8")], ""),
    ("warming", &[("[motion]", "friction_fall = 0.2\nwarming_time_s = 150.0")], ""),
    ("bursts", BURSTS, "[topics.torque_command]\nburst_s = 0.1\nstamped_on_arrival = true\n"),
    ("command on change", &[], "[topics]\ntorque_command_on_change = true\n"),
    ("command's clock 2 s ahead", &[], "[topics.torque_command]\nclock_offset_s = 2.0\n"),
    ("command's clock 0.4 s behind", &[], "[topics.torque_command]\nclock_offset_s = -0.4\n"),
    ("stamps of 0.1 s", &[("[sensors.encoder]", "timing = { rate_hz = 50.0, stamp_step_s = 0.1 }")], ""),
];

/// Everything arrives in bursts, with stamps that jitter.
const BURSTS: &[(&str, &str)] = &[
    ("[sensors.encoder]", "timing = { rate_hz = 50.0, burst_s = 0.1, jitter_s = 0.01 }"),
    ("[sensors.gyro]", "timing = { rate_hz = 100.0, burst_s = 0.1, jitter_s = 0.01 }"),
];

/// Vehicles: the bundled scrubber, a heavier one, one with more friction.
const VEHICLES: [&[(&str, &str)]; 3] = [
    &[],
    &[("[motion]", "mass_kg = 240.0"), ("[motion]", "yaw_inertia_kgm2 = 108.0")],
    &[("[motion]", "coulomb_nm = 5.0"), ("[motion]", "viscous_nm_s_m = 8.0"), ("[motion]", "drive_efficiency = 0.88")],
];

/// Sums over the judged cells.
#[derive(Default)]
struct Outcome {
    squares: f64,
    within: f64,
    wrong: f64,
    cells: f64,
    drives: BTreeMap<String, usize>,
}

impl Outcome {
    fn add(&mut self, vehicle: &VehicleFile, file: &Table1File) -> Fallible<()> {
        for cell in measured_cells(vehicle, file)? {
            self.squares += cell.error_nm * cell.error_nm;
            self.within += f64::from(cell.error_nm < 1.96 * cell.std_err_nm);
            self.wrong += f64::from(cell.is_off_by(1.0, 3.0));
            self.cells += 1.0;
        }
        let drive = file.actuator.drive.as_ref().map_or("first order".to_owned(), |d| {
            let limit = d.limit.map_or(String::new(), |l| format!(", {:?} limit", l.kind).to_lowercase());
            format!("{:?}{limit}", d.family)
        });
        *self.drives.entry(drive).or_insert(0) += 1;
        Ok(())
    }
}

fn after(flag: &str, otherwise: &str) -> String {
    let arguments: Vec<String> = std::env::args().collect();
    arguments.iter().position(|a| a == flag).and_then(|k| arguments.get(k + 1)).cloned().unwrap_or_else(|| otherwise.to_owned())
}

fn main() -> Fallible<()> {
    let seeds: u64 = after("--seeds", "3").parse()?;
    let kinds = after("--kinds", "");
    println!("| kind | runs | RMS N·m | within 1.96 | confidently wrong | drive reported |\n|---|---|---|---|---|---|");
    for (name, changes, topics) in KINDS.iter().filter(|(name, ..)| kinds.is_empty() || kinds.split(',').any(|k| k == *name)) {
        let (mut outcome, mut refused) = (Outcome::default(), BTreeMap::<String, usize>::new());
        let campaign = Campaign::from_toml(&format!("{topics}{CAMPAIGN}"))?;
        for vehicle in VEHICLES {
            let vehicle = VehicleFile::from_toml(&changed(SCRUBBER, &[vehicle, changes].concat()))?;
            for seed in 1..=seeds {
                let driven = record(&vehicle, &campaign, Some(seed))?;
                match fitted(driven.bytes) {
                    Ok(file) if file.checks.iter().any(Check::objects) => {
                        let first = file.checks.iter().find(|c| c.objects()).map_or("", |c| c.name.as_str());
                        *refused.entry(format!("by {first}")).or_insert(0) += 1;
                    }
                    Ok(file) => outcome.add(&vehicle, &file)?,
                    Err(error) => *refused.entry(error.to_string()).or_insert(0) += 1,
                }
            }
        }
        let share = |sum: f64| 100.0 * sum / outcome.cells.max(1.0);
        let drives: Vec<String> = outcome.drives.iter().map(|(drive, count)| format!("{drive} ({count})")).collect();
        println!(
            "| {name} | {} | {:.3} | {:.0} % | {:.1} % | {}{} |",
            VEHICLES.len() as u64 * seeds,
            (outcome.squares / outcome.cells.max(1.0)).sqrt(),
            share(outcome.within),
            share(outcome.wrong),
            drives.join(", "),
            refused.iter().map(|(why, count)| format!(", rejected ({count}): {why}")).collect::<Vec<_>>().concat()
        );
    }
    Ok(())
}
