//! `fit LOG…`: Table 1 from logs.

use crate::cli::Ui;
use crate::cli::angles::AngleChoice;
use crate::cli::breaks::Breaks;
use crate::cli::logs::{LogArguments, survey};
use crate::cli::outcome::Outcome;
use crate::fit::{Fit, FitSettings, fit_angles, fit_traced};
use crate::map::{FitTraces, Table1File, write_whole};
use anyhow::Context;
use comfy_table::{CellAlignment, Table, presets};
use std::path::{Path, PathBuf};

/// Arguments of `fit`.
#[derive(Debug, Clone, clap::Args)]
#[group(id = "fit")] // flattened into `calibrate`, whose own group is named after its struct, too
#[command(after_help = "\
Examples:
  pivot-cal fit logs.mcap
  pivot-cal fit --signals signals.toml monday.mcap tuesday.mcap
  pivot-cal fit --angle 0,30,60,90 angles.mcap
  pivot-cal fit --preset autoware --wheelbase-m 0.92 --wheel-radius-m 0.12 drive.mcap

Writes table1.csv and table1.json (and table1.reverse.csv when reverse gear was tested) into the folder of --maps, and fit_traces.json for
the report. A log with runs at several wheel angles gives a map of each: table1.csv is that of the test angle, table1.angle30.csv that of 30°.
Exit status: 0 done, 3 written but the coverage is too thin (or, with --strict, a log is damaged), 1 error.")]
pub(crate) struct Arguments {
    #[command(flatten)]
    pub(crate) input: LogArguments,
    /// Folder to write into
    #[arg(long, value_name = "DIR", default_value = "maps")]
    pub(crate) maps: PathBuf,
    /// Dead time of the drive [ms] when it is known
    #[arg(long, value_name = "MS")]
    pub(crate) dead_time_ms: Option<f64>,
    /// Time constant of the drive's lag [ms] when it is known
    #[arg(long, value_name = "MS")]
    pub(crate) lag_ms: Option<f64>,
    /// Wheel angle whose runs are used [°], or several; by default all at which at least three torques were held
    #[arg(long, value_name = "DEG,…", value_delimiter = ',', allow_hyphen_values = true)]
    pub(crate) angle: Vec<f64>,
    /// Speed breaks [m/s]: start:step:stop or a list
    #[arg(long, value_name = "BREAKS")]
    pub(crate) speed_breaks: Option<Breaks>,
    /// Torque breaks [N·m]: start:step:stop or a list
    #[arg(long, value_name = "BREAKS", allow_hyphen_values = true)]
    pub(crate) torque_breaks: Option<Breaks>,
}

impl Arguments {
    fn settings(&self) -> anyhow::Result<FitSettings> {
        let delay = |name: &str, value: Option<f64>, most_ms: f64| match value {
            Some(ms) if !(0.0..=most_ms).contains(&ms) => anyhow::bail!("{name} is {ms}; allowed: 0 to {most_ms}"),
            other => Ok(other.map(|ms| ms * 1e-3)),
        };
        Ok(FitSettings {
            dead_time_s: delay("--dead-time-ms", self.dead_time_ms, 500.0)?,
            lag_s: delay("--lag-ms", self.lag_ms, 300.0)?,
            speed_breaks_mps: self.speed_breaks.clone().map(|b| b.0),
            torque_breaks_nm: self.torque_breaks.clone().map(|b| b.0),
            ..FitSettings::default()
        })
    }
}

pub(crate) fn run(arguments: &Arguments, ui: Ui) -> anyhow::Result<Outcome> {
    let (fit, damaged) = make(arguments, ui)?;
    ui.document(&fit.file)?;
    show(&fit.file, ui);
    Ok(if fit.sound && !damaged { Outcome::Done } else { Outcome::Rejected })
}

/// Fits and writes; also tells whether a damaged log counts (with `--strict`).
pub(crate) fn make(arguments: &Arguments, ui: Ui) -> anyhow::Result<(Fit, bool)> {
    let settings = arguments.settings()?;
    let one = match arguments.angle[..] {
        [angle] => Some(angle),
        _ => None,
    };
    let (recordings, census) = arguments.input.census(one, ui)?;
    let damaged = recordings.iter().any(|r| r.loss.is_damaged()) && arguments.input.strict;
    let chosen = crate::cli::angles::choose(&recordings, &census, &arguments.angle, ui)?;
    let (fit, traces) = if let Some(AngleChoice { grouped, test_angle_deg }) = chosen {
        fit_angles(grouped, !arguments.angle.is_empty(), test_angle_deg, &settings)?
    } else {
        let surveys = survey(&recordings, ui).with_context(|| format!("wheel angles of the runs: {}", census.text()))?;
        fit_traced(surveys, &settings)?
    };
    save(&fit, &traces, &arguments.maps)?;
    Ok((fit, damaged))
}

fn save(fit: &Fit, traces: &FitTraces, folder: &Path) -> anyhow::Result<()> {
    // a table of an earlier fit that this one does not have would pass for its own
    crate::cli::angles::remove_stale(folder, "table1", fit.csvs.iter().map(|(name, _)| name.as_str()))?;
    for (name, text) in &fit.csvs {
        write_whole(&folder.join(name), text.as_bytes())?;
    }
    write_whole(&folder.join("table1.json"), fit.file.to_json()?.as_bytes())?;
    write_whole(&folder.join("fit_traces.json"), traces.to_json()?.as_bytes())?;
    Ok(())
}

/// The summary for people.
pub(crate) fn show(file: &Table1File, ui: Ui) {
    let mut table = Table::new();
    table.load_style(presets::NOTHING).set_header(["verdict on samples", "samples", "seconds"]);
    for row in &file.report.ledger {
        table.add_row([row.verdict.to_string(), row.samples.to_string(), format!("{:.2}", row.seconds)]);
    }
    for column in 1..3 {
        if let Some(column) = table.column_mut(column) {
            column.set_cell_alignment(CellAlignment::Right);
        }
    }
    ui.say(table.to_string());
    ui.say("");
    let actuator = &file.actuator;
    let told = |d: &crate::map::DelayEstimate| {
        let error = d.std_err_s.map_or(String::new(), |e| format!(" ± {:.1}", 1e3 * e));
        format!("{:.1}{error} ms ({})", 1e3 * d.value_s, d.status)
    };
    if !actuator.input.is_plain_command() {
        ui.say(format!("input      {}", actuator.input));
    }
    ui.say(format!("dead time  {}", told(&actuator.dead_time)));
    ui.say(format!("lag        {}", told(&actuator.lag)));
    for log in &actuator.per_log {
        ui.say(format!("  {}: dead time {}, clock offset {}", log.file, told(&log.dead_time), told(&log.clock_offset)));
    }
    for witness in &file.witnesses {
        let error = witness.scale_std_err.map_or(String::new(), |e| format!(" ± {e:.4}"));
        let delay = 1e3 * witness.delay_s;
        ui.say(format!(
            "{}: scale {:.4}{error}, reads {delay:.1} ms late, noise {:.4} m/s",
            witness.name, witness.scale, witness.noise_mps
        ));
    }
    let several = file.has_several_angles();
    for map in &file.maps {
        let b = &map.breakaway;
        let bound = |label: &str, v: Option<f64>| v.map_or(String::new(), |v| format!(", {label} {v:.1}"));
        ui.say(format!(
            "{}{} gear: breakaway {:.2} N·m{}{}{}",
            if several { format!("{}°, ", map.wheel_angle_deg) } else { String::new() },
            map.gear,
            b.torque_nm,
            b.std_err_nm.map_or(String::new(), |e| format!(" ± {e:.2}")),
            bound("at rest up to", b.at_rest_up_to_nm),
            bound("moved from", b.moved_from_nm)
        ));
    }
    for map in &file.maps {
        ui.picture(crate::report::coverage_text(map));
    }
    for family in &file.families {
        ui.say(crate::cli::angles::family_text(family));
    }
    ui.say(format!("coverage   {:.0} % of the cells measured", 100.0 * file.report.coverage));
    ui.say(format!("residual   {:.4} m/s² root mean square", file.report.residual_rms_mps2));
    for note in &file.report.notes {
        ui.say(format!("note: {note}"));
    }
    for map in &file.maps {
        ui.say(format!("written: {}", map.csv.file));
    }
    ui.say("written: table1.json, fit_traces.json");
}
