//! `record`: a campaign on a simulated vehicle → an MCAP log.

use crate::cli::Ui;
use crate::cli::outcome::Outcome;
use crate::cli::text_file::read_file;
use crate::map::write_whole;
use crate::record::{Campaign, record};
use crate::sim::VehicleFile;
use crate::text::shown;
use anyhow::Context;
use clap::Args;
use std::path::PathBuf;

/// Drive a torque-step campaign on a simulated vehicle and write its log
#[derive(Debug, Args)]
#[command(after_help = "\
Example: the demo log
  pivot-cal record --vehicle data/vehicles/scrubber.toml --campaign data/campaigns/torque_steps.toml -o demo.mcap")]
pub(crate) struct Arguments {
    /// Vehicle to simulate (TOML)
    #[arg(long, value_name = "FILE")]
    vehicle: PathBuf,
    /// Campaign to drive (TOML)
    #[arg(long, value_name = "FILE")]
    campaign: PathBuf,
    /// Log to write (MCAP); `-` is standard output
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Seed of everything random, in place of the campaign's
    #[arg(long, value_name = "N")]
    seed: Option<u64>,
}

pub(crate) fn run(arguments: &Arguments, ui: Ui) -> anyhow::Result<Outcome> {
    let ui = ui.beside(Some(&arguments.output))?;
    let at = |path: &PathBuf| shown(path);
    let text = read_file(&arguments.vehicle)?;
    let vehicle = VehicleFile::from_toml(&text).with_context(|| at(&arguments.vehicle))?;
    let text = read_file(&arguments.campaign)?;
    let campaign = Campaign::from_toml(&text).with_context(|| at(&arguments.campaign))?;
    let recording = record(&vehicle, &campaign, arguments.seed)?;
    write_whole(&arguments.output, &recording.bytes)?;
    let report = &recording.report;
    ui.detail("     at s  gear     torque N·m  held s  from m/s  to m/s  end");
    for run in &report.runs {
        ui.detail(format!(
            "{:9.2}  {:7}  {:10.1}  {:6.2}  {:8.2}  {:6.2}  {}",
            run.start_s,
            run.gear.to_string(),
            run.torque_nm,
            run.duration_s,
            run.start_speed_mps,
            run.end_speed_mps,
            serde_json::to_value(run.end)?.as_str().unwrap_or_default()
        ));
    }
    ui.say(format!(
        "{}: {} runs, {:.0} s, {} messages, {:.2} MB, seed {}",
        at(&arguments.output),
        report.runs.len(),
        report.duration_s,
        report.messages,
        recording.bytes.len() as f64 / 1e6,
        report.seed
    ));
    ui.document(&serde_json::json!({ "file": at(&arguments.output), "bytes": recording.bytes.len(), "report": report }))?;
    Ok(Outcome::Done)
}
