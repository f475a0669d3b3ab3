//! `fit LOG…`: Table 1 from logs.

use crate::calibrate::{FitStage, fit_logs};
use crate::cli::Ui;
use crate::cli::advice::with_advice;
use crate::cli::breaks::Breaks;
use crate::cli::listener::UiListener;
use crate::cli::logs::LogArguments;
use crate::cli::outcome::Outcome;
use crate::cli::verify_text::show_checks;
use crate::fit::{CampaignTime, FitSettings};
use crate::map::{Check, DriveFamily, Table1File};
use comfy_table::{CellAlignment, Table, presets};
use std::path::PathBuf;

/// Arguments of `fit`.
#[derive(Debug, Clone, clap::Args)]
#[group(id = "fit")] // flattened into `calibrate`, whose own group is also named after its struct
#[command(after_help = "\
Examples:
  pivot-cal fit logs.mcap
  pivot-cal fit --signals signals.toml monday.mcap tuesday.mcap
  pivot-cal fit --angle 0,30,60,90 angles.mcap
  pivot-cal fit --preset autoware --wheelbase-m 0.92 --wheel-radius-m 0.12 drive.mcap

Writes table1.csv and table1.json (and table1.reverse.csv if reverse gear was tested) into the folder of --maps, and fit_traces.json for
the report. A log with runs at several wheel angles gives a map of each angle: table1.csv for the test angle, table1.angle30.csv for 30°.
Memory: logs of any size are read by the chunk (256 MB at most, two per thread) with 32 bytes for each value of a signal, at most
128 million values in all logs (4 GB). What needs more is refused. The fit itself needs about 1.9 kB for each speed reading used: 200
logs of 14 runs take 605 MB at their peak.
Exit status: 0 done, 3 written but a check is an objection (or, with --strict, a log is damaged), 1 error.")]
pub(crate) struct Arguments {
    #[command(flatten)]
    pub(crate) input: LogArguments,
    /// Folder to write into
    #[arg(long, value_name = "DIR", default_value = "maps")]
    pub(crate) maps: PathBuf,
    /// Dead time of the drive [ms], if known
    #[arg(long, value_name = "MS")]
    pub(crate) dead_time_ms: Option<f64>,
    /// Kind of drive, if known; by default the one that predicts runs left out best
    #[arg(long, value_name = "KIND")]
    pub(crate) drive: Option<DriveArgument>,
    /// Time of the campaign whose map is made, where friction or torque changed
    #[arg(long, value_name = "TIME", default_value = "mean")]
    pub(crate) at: TimeArgument,
    /// Time constant of the drive's lag [ms], if known
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

/// A kind of drive on the command line.
#[derive(Debug, Clone, Copy, clap::ValueEnum)]
pub(crate) enum DriveArgument {
    /// A first-order lag
    FirstOrder,
    /// A rate limit, and a lag behind it
    RateLimit,
    /// A second-order lag
    SecondOrder,
    /// The torque feedback is the torque
    Feedback,
}

impl From<DriveArgument> for DriveFamily {
    fn from(argument: DriveArgument) -> Self {
        match argument {
            DriveArgument::FirstOrder => Self::FirstOrder,
            DriveArgument::RateLimit => Self::RateLimit,
            DriveArgument::SecondOrder => Self::SecondOrder,
            DriveArgument::Feedback => Self::Feedback,
        }
    }
}

/// A time of the campaign on the command line.
#[derive(Debug, Clone, Copy, clap::ValueEnum)]
pub(crate) enum TimeArgument {
    /// The campaign's mean
    Mean,
    /// Its end
    End,
}

impl From<TimeArgument> for CampaignTime {
    fn from(argument: TimeArgument) -> Self {
        match argument {
            TimeArgument::Mean => Self::Mean,
            TimeArgument::End => Self::End,
        }
    }
}

impl Arguments {
    /// Settings of reading and fitting logs, from the arguments.
    pub(crate) fn stage(&self) -> anyhow::Result<FitStage> {
        let delay = |name: &str, value: Option<f64>, most_ms: f64| match value {
            Some(ms) if !(0.0..=most_ms).contains(&ms) => anyhow::bail!("{name} is {ms}; allowed: 0 to {most_ms}"),
            other => Ok(other.map(|ms| ms * 1e-3)),
        };
        let settings = FitSettings {
            dead_time_s: delay("--dead-time-ms", self.dead_time_ms, 500.0)?,
            lag_s: delay("--lag-ms", self.lag_ms, 300.0)?,
            drive: self.drive.map(Into::into),
            at: self.at.into(),
            speed_breaks_mps: self.speed_breaks.clone().map(|b| b.0),
            torque_breaks_nm: self.torque_breaks.clone().map(|b| b.0),
            ..FitSettings::default()
        };
        Ok(FitStage { source: self.input.log_source()?, wheel_angles_deg: self.angle.clone(), settings })
    }

    /// Whether a damaged log counts.
    pub(crate) fn is_strict(&self) -> bool {
        self.input.strict
    }
}

pub(crate) fn run(arguments: &Arguments, ui: Ui) -> anyhow::Result<Outcome> {
    let listener = UiListener::new(ui, "reading");
    let logs = &arguments.input.logs;
    let fitted = fit_logs(logs, &arguments.maps, &arguments.stage()?, &|event| listener.hear(event)).map_err(with_advice)?;
    ui.document(&fitted.fit.file)?;
    show(&fitted.fit.file, ui);
    Ok(if fitted.fit.sound && !(fitted.is_damaged && arguments.is_strict()) { Outcome::Done } else { Outcome::Rejected })
}

/// The text summary.
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
    let text = |d: &crate::map::DelayEstimate| {
        let error = d.std_err_s.map_or(String::new(), |e| format!(" ± {:.1}", 1e3 * e));
        format!("{:.1}{error} ms ({})", 1e3 * d.value_s, d.status)
    };
    if !actuator.input.is_plain_command() {
        ui.say(format!("input      {}", actuator.input));
    }
    ui.say(format!("dead time  {}", text(&actuator.dead_time)));
    ui.say(format!("lag        {}", text(&actuator.lag)));
    for (label, text) in actuator.drive_lines() {
        ui.say(format!("{label:<10} {text}"));
    }
    for log in &actuator.per_log {
        ui.say(format!("  {}: dead time {}, clock offset {}", log.file, text(&log.dead_time), text(&log.clock_offset)));
    }
    for source in &file.witnesses {
        let error = source.scale_std_err.map_or(String::new(), |e| format!(" ± {e:.4}"));
        let delay = 1e3 * source.delay_s;
        ui.say(format!("{}: scale {:.4}{error}, reads {delay:.1} ms late, noise {:.4} m/s", source.name, source.scale, source.noise_mps));
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
    let noted = |check: &Check| file.report.notes.contains(&check.text());
    show_checks(&file.checks.iter().filter(|c| !noted(c)).cloned().collect::<Vec<_>>(), ui);
    for map in &file.maps {
        ui.say(format!("written: {}", map.csv.file));
    }
    ui.say("written: table1.json, fit_traces.json");
}
