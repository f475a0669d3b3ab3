//! `check MAP…`: judges maps, ours and foreign ones.

use crate::check::{CheckReport, CheckSettings, RuleBreach, Severity, check};
use crate::cli::Ui;
use crate::cli::outcome::Outcome;
use std::path::PathBuf;

/// Number of findings of one rule that are listed without `-v`.
const SHOWN: usize = 5;

/// Arguments of `check`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  pivot-cal check maps/table1.json maps/table2.json maps/table2.csv
  pivot-cal check accel_map.csv brake_map.csv calibration_table.pb.txt
  pivot-cal check tuned.dcm pivot_map.c
  pivot-cal check --json maps/table2.json

Reads table1 and table2 (CSV and JSON), exported DCM, CDFX, C and Rust files, Autoware's accel and brake maps, Apollo's calibration tables (also inside a control
configuration) and long-form CSV (a header that names speed, acceleration and command). Errors and warnings are findings; notes are not.
Exit status: 0 no finding, 3 findings, 1 a file cannot be opened.")]
pub(crate) struct Arguments {
    /// Maps to judge
    #[arg(required = true, value_name = "MAP")]
    maps: Vec<PathBuf>,
    /// A step this many times as steep as the 90th percentile of the map's steps is a jump
    #[arg(long, value_name = "FACTOR", default_value_t = CheckSettings::default().slope_bound)]
    slope_bound: f64,
}

#[derive(serde::Serialize)]
struct CheckDocument {
    sound: bool,
    maps: Vec<CheckReport>,
}

pub(crate) fn run(arguments: &Arguments, ui: Ui) -> anyhow::Result<Outcome> {
    if !(arguments.slope_bound.is_finite() && arguments.slope_bound >= 1.0) {
        anyhow::bail!("--slope-bound is {}; allowed: 1 or more", arguments.slope_bound);
    }
    let settings = CheckSettings { slope_bound: arguments.slope_bound };
    let maps = arguments.maps.iter().map(|path| check(path, settings)).collect::<Result<Vec<_>, _>>()?;
    let document = CheckDocument { sound: maps.iter().all(|m| m.sound), maps };
    ui.document(&document)?;
    for report in &document.maps {
        show(report, ui);
    }
    Ok(if document.sound { Outcome::Done } else { Outcome::Rejected })
}

fn show(report: &CheckReport, ui: Ui) {
    let verdict = if report.sound { "sound" } else { "FINDINGS" };
    ui.say(format!("{}: {}, {}: {verdict}", report.map, report.format, report.size));
    for count in &report.counts {
        let of_rule = || report.findings.iter().filter(|f| f.rule == count.rule && f.severity == count.severity);
        let line = |finding: &RuleBreach| {
            let place = finding.place();
            if place.is_empty() { format!("    {}", finding.what) } else { format!("    {place}: {}", finding.what) }
        };
        if count.severity == Severity::Note {
            ui.detail(format!("  {} {count}", count.severity));
            of_rule().for_each(|finding| ui.detail(line(finding)));
            continue;
        }
        ui.say(format!("  {} {count}", count.severity));
        of_rule().take(SHOWN).for_each(|finding| ui.say(line(finding)));
        of_rule().skip(SHOWN).for_each(|finding| ui.detail(line(finding)));
        if count.findings > SHOWN && !ui.is_verbose() {
            ui.say(format!("    and {} more (-v lists all)", count.findings - SHOWN));
        }
    }
}
