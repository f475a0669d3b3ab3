//! `report`: the page with the verdict on a map.

use crate::calibrate::report_folder;
use crate::cli::Ui;
use crate::cli::outcome::Outcome;
use crate::cli::verify_text::show_checks;
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
}

pub(crate) fn run(arguments: &Arguments, ui: Ui) -> anyhow::Result<Outcome> {
    let ui = ui.beside(arguments.output.as_deref())?;
    let output = arguments.output.clone().unwrap_or_else(|| arguments.maps.join("report.html"));
    let made = report_folder(&arguments.maps, &output, arguments.svg.as_deref())?;
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
