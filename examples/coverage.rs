//! How honest the reported intervals are: campaigns of the bundled simulator, each with its own seed, against the simulator's exact map.
//!
//! `cargo run --release --example coverage -- [CAMPAIGNS]` prints, per gear and in all, the share of measured cells whose 95 % interval
//! holds the truth, the median width of the interval, and the error's quantiles.

#![allow(clippy::print_stdout)] // a study prints

use pivot_cal::campaign;
use pivot_cal::campaign::Survey;
use pivot_cal::control::RAD_PER_DEG;
use pivot_cal::fit;
use pivot_cal::fit::fit;
use pivot_cal::internals::{Campaign, VehicleFile, record};
use pivot_cal::log::{Source, VehicleOverrides, read_bytes};
use pivot_cal::map::{CellStatus, Gear};
use pivot_cal::signal::Track;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let campaigns: u64 = std::env::args().nth(1).map_or(Ok(20), |n| n.parse())?;
    let vehicle = VehicleFile::from_toml(&std::fs::read_to_string("data/vehicles/scrubber.toml")?)?;
    let campaign = Campaign::from_toml(&std::fs::read_to_string("data/campaigns/torque_steps.toml")?)?;
    let truth = vehicle.truth()?;
    let (mut inside, mut cells) = (0usize, 0usize);
    let (mut widths, mut errors) = (Vec::new(), Vec::new());
    for seed in 1..=campaigns {
        let log = record(&vehicle, &campaign, Some(seed))?;
        let recording = read_bytes(log.bytes, "campaign.mcap", &Source::Detect, &VehicleOverrides::default())?;
        let survey = Survey::new(Track::new(&recording)?, &campaign::SurveySettings::default())?;
        let fit = fit(vec![survey], &fit::FitSettings::default())?;
        let before = (inside, cells);
        for map in &fit.file.maps {
            for (i, u) in map.torque_nm.iter().enumerate() {
                for (j, v) in map.speed_mps.iter().enumerate() {
                    if map.status[i][j] != CellStatus::Measured || *v == 0.0 {
                        continue;
                    }
                    let error = map.accel_mps2[i][j] - truth.gear_accel_mps2(map.gear, *v, *u, 90.0 * RAD_PER_DEG);
                    cells += 1;
                    inside += usize::from(error.abs() <= 1.96 * map.std_err_mps2[i][j]);
                    widths.push(2.0 * 1.96 * map.std_err_mps2[i][j]);
                    errors.push(error.abs());
                }
            }
        }
        let breakaway = |gear| fit.file.maps.iter().find(|m| m.gear == gear).map_or(f64::NAN, |m| m.breakaway.torque_nm);
        println!(
            "seed {seed:3}: {:5.1} % of {} cells; breakaway {:.2} and {:.2} N·m",
            100.0 * (inside - before.0) as f64 / (cells - before.1) as f64,
            cells - before.1,
            breakaway(Gear::Forward),
            breakaway(Gear::Reverse)
        );
    }
    widths.sort_unstable_by(f64::total_cmp);
    errors.sort_unstable_by(f64::total_cmp);
    let at = |values: &[f64], q: f64| values[((values.len() - 1) as f64 * q) as usize];
    println!(
        "95 % intervals hold {:.1} % of {cells} measured cells; median width {:.4} m/s²",
        100.0 * inside as f64 / cells as f64,
        at(&widths, 0.5)
    );
    println!("error: median {:.4}, 95 % {:.4}, max {:.4} m/s²", at(&errors, 0.5), at(&errors, 0.95), at(&errors, 1.0));
    Ok(())
}
