//! `report`: the page with the verdict on a map.

use crate::calibrate::report_with;
use crate::cli::Ui;
use crate::cli::outcome::Outcome;
use crate::cli::verify_text::show_checks;
use crate::diff::DiffSide;
use crate::import::{FullScale, read_map};
use crate::report::coverage_text;
use crate::text::shown;
use std::path::PathBuf;

/// Arguments of `report`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  pivot-cal report                            the page of the map in ./maps
  pivot-cal report --svg figures              also the figures as SVG files
  pivot-cal report --maps maps/monday -o monday.html
  pivot-cal report --table tuned.dcm -o tuned.html        a map that came back from a tool, in place of Table 2

Reads table1.json and, if they exist, table2.json, verify.json, fit_traces.json, verify_traces.json,
manoeuvre_traces.json (of verify --scenario manoeuvres) and plan.json (of plan). The page is one file that needs no
network; it lists missing files. The exit status is about the writing, not about the map: 0 written, 1 error.")]
pub(crate) struct Arguments {
    /// Folder with the files of the map
    #[arg(long, value_name = "DIR", default_value = "maps")]
    maps: PathBuf,
    /// Page to write, by default report.html in the folder of --maps; `-` is standard output
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Also write every figure as an SVG file into this folder
    #[arg(long, value_name = "DIR")]
    svg: Option<PathBuf>,
    /// Show the tables of this file in place of Table 2: DCM, CDFX, C, Rust, Autoware, Apollo, CSV or JSON
    #[arg(long, value_name = "FILE", requires = "output")]
    table: Option<PathBuf>,
    /// Torque that is 100 % [N·m], for a --table in % that does not say it
    #[arg(long, value_name = "NM", requires = "table")]
    torque_full_scale: Option<f64>,
}

pub(crate) fn run(arguments: &Arguments, ui: Ui) -> anyhow::Result<Outcome> {
    let ui = ui.beside(arguments.output.as_deref())?;
    let output = arguments.output.clone().unwrap_or_else(|| arguments.maps.join("report.html"));
    let imported = match &arguments.table {
        Some(path) => {
            let vehicle = DiffSide::read(&arguments.maps.join("table1.json"))?.vehicle;
            let torque_nm = arguments.torque_full_scale.or(vehicle.torque_full_scale_nm);
            Some((path.as_path(), read_map(path, FullScale { torque_nm, wheel_radius_m: vehicle.wheel_radius_m })?))
        }
        None => None,
    };
    let table = imported.as_ref().map(|(path, imported)| (*path, imported));
    let made = report_with(&arguments.maps, &output, arguments.svg.as_deref(), table)?;
    let (judgement, reason) = made.files.judgement();
    ui.document(&serde_json::json!({
        "file": shown(&output),
        "bytes": made.bytes,
        "judgement": judgement,
        "reason": reason,
        "checks": made.files.checks,
        "notes": made.files.notes,
        "figures": made.figures,
    }))?;
    ui.say(format!("verdict: {reason}"));
    show_checks(&made.files.checks, ui);
    for map in &made.files.table1.maps {
        ui.picture(coverage_text(map));
    }
    for note in &made.files.notes {
        ui.say(format!("note: {note}"));
    }
    if let Some(folder) = &arguments.svg {
        ui.say(format!("written: {} figures in {}", made.figures.len(), shown(folder)));
    }
    ui.say(format!("written: {} ({:.2} MB)", shown(&output), made.bytes as f64 / 1e6));
    Ok(Outcome::Done)
}
