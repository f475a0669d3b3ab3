//! `calibrate LOG…`: fit, invert, verify and report in one go, with one summary at the end.

use crate::calibrate::{CalibrateSettings, Calibrated, FittedLogs, InvertStage, calibrate_with};
use crate::cli::advice::with_advice;
use crate::cli::listener::UiListener;
use crate::cli::outcome::Outcome;
use crate::cli::{Ui, controller_file, fit, invert, verify_text};
use crate::invert::InvertSettings;
use crate::text::shown;
use serde_json::json;
use std::path::PathBuf;

/// Arguments of `calibrate`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  pivot-cal calibrate logs.mcap
  pivot-cal calibrate --signals signals.toml --maps maps/monday monday/*.mcap

Runs fit, invert, verify and report with their defaults; the folder of --maps gets all files at the end, or after an error none.
Memory: logs of any size are read by the chunk (256 MB at most, two per thread) with 32 bytes for each value of a signal, at most
128 million values in all logs (4 GB). What needs more is refused. The fit itself needs about 1.9 kB for each speed reading used: 200
logs of 14 runs take 605 MB at their peak.
Exit status: 0 the map passes, 3 it fails or a check rejects it, 1 error or too little was driven to judge.")]
pub(crate) struct Arguments {
    #[command(flatten)]
    fit: fit::Arguments,
    /// Breaks of the desired acceleration [m/s²]: start:step:stop or a list
    #[arg(long, value_name = "BREAKS", allow_hyphen_values = true)]
    accel_breaks: Option<crate::cli::breaks::Breaks>,
    /// Settings of the controller that drives in the verdict (TOML) instead of the built-in ones
    #[arg(long, value_name = "FILE")]
    controller_settings: Option<PathBuf>,
    /// Overrule the objection of this check; it is written into verify.json and onto the page (may be repeated)
    #[arg(long, value_name = "NAME")]
    accept: Vec<String>,
}

pub(crate) fn run(arguments: &Arguments, ui: Ui) -> anyhow::Result<Outcome> {
    let maps = &arguments.fit.maps;
    let accel_breaks_mps2 = arguments.accel_breaks.clone().map(|b| b.0);
    let settings = CalibrateSettings {
        fit: arguments.fit.stage()?,
        invert: InvertStage { settings: InvertSettings { accel_breaks_mps2, ..InvertSettings::default() }, ..InvertStage::default() },
        accept: arguments.accept.clone(),
        controller: arguments.controller_settings.as_deref().map(|path| controller_file::read(Some(path))).transpose()?,
    };
    let listener = UiListener::new(ui, "calibrating");
    let made = calibrate_with(&arguments.fit.input.logs, maps, &settings, &|event| listener.hear(event)).map_err(with_advice)?;
    let Calibrated { fitted: FittedLogs { fit, is_damaged }, inversion, verdict } = made;
    let damaged = is_damaged && arguments.fit.is_strict();
    ui.document(&json!({ "table1": fit.file, "table2": inversion.file, "verify": verdict }))?;
    ui.say(format!("verdict: {}", verdict.headline()));
    ui.say("");
    ui.say("── Table 1 ──");
    fit::show(&fit.file, ui);
    ui.say("");
    ui.say("── Table 2 ──");
    invert::show(&inversion.file, ui);
    ui.say("");
    ui.say("── Verdict ──");
    verify_text::show(&verdict, ui);
    ui.say("written: verify.json");
    let folder = shown(&arguments.fit.maps);
    let used = fit.file.report.ledger.iter().find(|r| r.verdict == crate::map::SampleVerdict::Used).map_or(0.0, |r| r.seconds);
    let total: f64 = fit.file.report.ledger.iter().map(|r| r.seconds).sum();
    let at_test_angle = |m: &&crate::map::AccelMap| m.angle().is_same(fit.file.vehicle.test_angle());
    let breakaway: Vec<String> =
        fit.file.maps.iter().filter(at_test_angle).map(|m| format!("{} {:.1} N·m", m.gear, m.breakaway.torque_nm)).collect();
    ui.say("");
    ui.say("── Summary ──");
    ui.say(format!("used         {used:.1} s of {total:.1} s, {} runs", fit.file.report.used_runs()));
    ui.say(format!(
        "drive        dead time {:.0} ms, lag {:.0} ms",
        1e3 * fit.file.actuator.dead_time.value_s,
        1e3 * fit.file.actuator.lag.value_s
    ));
    ui.say(format!("breakaway    {}", breakaway.join(", ")));
    ui.say(format!("coverage     {:.0} % of the cells measured", 100.0 * fit.file.report.coverage));
    let trip = inversion.file.maps.iter().map(|m| m.round_trip.between_rms_mps2).fold(0.0, f64::max);
    ui.say(format!("round trip   {trip:.4} m/s² root mean square"));
    ui.say(format!("verdict      {}", verify_text::status_word(verdict.status)));
    ui.say(format!("files        {folder}/table1.csv, table1.json, table2.csv, table2.json, verify.json, report.html"));
    Ok(if damaged { Outcome::Rejected } else { verdict.status.into() })
}
