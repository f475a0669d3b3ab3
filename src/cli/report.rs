//! `report`: the page that says whether to deploy a map.

use crate::cli::Ui;
use crate::cli::outcome::Outcome;
use crate::map::write_whole;
use crate::report::{Judgement, ReportFiles, coverage_text, report};
use std::path::{Path, PathBuf};

/// Arguments of `report`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  pivot-cal report                            the page of the map in ./maps
  pivot-cal report --svg figures              the figures as SVG files, too
  pivot-cal report --maps maps/monday -o monday.html

Reads table1.json and, where they are there, table2.json, verify.json, fit_traces.json, verify_traces.json,
manoeuvre_traces.json (of verify --scenario manoeuvres) and plan.json (of plan). The page is one file that needs no network; it says what is missing. The exit status is that of the writing, not of the map: 0 written, 1 error.")]
pub(crate) struct Arguments {
    /// Folder with the files of the map
    #[arg(long, value_name = "DIR", default_value = "maps")]
    maps: PathBuf,
    /// Page to write, by default report.html in the folder of --maps
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Write every figure as an SVG file into this folder, too
    #[arg(long, value_name = "DIR")]
    svg: Option<PathBuf>,
}

pub(crate) fn run(arguments: &Arguments, ui: Ui) -> anyhow::Result<Outcome> {
    let output = arguments.output.clone().unwrap_or_else(|| arguments.maps.join("report.html"));
    let made = make(&arguments.maps, &output, arguments.svg.as_deref())?;
    ui.document(&serde_json::json!({
        "file": output.display().to_string(),
        "bytes": made.bytes,
        "judgement": made.inputs.judgement(),
        "notes": made.inputs.notes,
        "figures": made.figures,
    }))?;
    for map in &made.inputs.table1.maps {
        ui.picture(coverage_text(map));
    }
    for note in &made.inputs.notes {
        ui.say(format!("note: {note}"));
    }
    let judgement = match made.inputs.judgement() {
        Judgement::Pass => "pass",
        Judgement::Fail => "FAIL",
        Judgement::NotJudged => "not judged",
    };
    ui.say(format!("verdict: {judgement}"));
    if let Some(folder) = &arguments.svg {
        ui.say(format!("written: {} figures in {}", made.figures.len(), folder.display()));
    }
    ui.say(format!("written: {} ({:.2} MB)", output.display(), made.bytes as f64 / 1e6));
    Ok(Outcome::Done)
}

/// A report that was written.
pub(crate) struct Made {
    inputs: ReportFiles,
    bytes: usize,
    figures: Vec<String>,
}

/// Writes the page of the map in `maps`, and its figures.
pub(crate) fn make(maps: &Path, output: &Path, svg: Option<&Path>) -> anyhow::Result<Made> {
    let inputs = ReportFiles::read(maps)?;
    let report = report(&inputs)?;
    write_whole(output, report.html.as_bytes())?;
    let mut figures = Vec::new();
    for (name, text) in &report.pictures {
        if let Some(folder) = svg {
            write_whole(&folder.join(format!("{name}.svg")), text.as_bytes())?;
        }
        figures.push(name.clone());
    }
    Ok(Made { inputs, bytes: report.html.len(), figures })
}
