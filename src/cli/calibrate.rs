//! `calibrate LOG…`: fit, invert, verify and report in one go, with one summary at the end.

use crate::cli::outcome::Outcome;
use crate::cli::{Ui, fit, invert, report, verify, verify_text};
use crate::invert::ZeroRow;
use serde_json::json;

/// Arguments of `calibrate`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  pivot-cal calibrate logs.mcap
  pivot-cal calibrate --signals signals.toml --maps maps/monday monday/*.mcap

Does what fit, invert, verify and report do, with their defaults, in the folder of --maps.
Exit status: 0 the map passes, 3 it does not (or the coverage is too thin), 1 error.")]
pub(crate) struct Arguments {
    #[command(flatten)]
    fit: fit::Arguments,
    /// Breaks of the desired acceleration [m/s²]: start:step:stop or a list
    #[arg(long, value_name = "BREAKS", allow_hyphen_values = true)]
    accel_breaks: Option<crate::cli::breaks::Breaks>,
}

pub(crate) fn run(arguments: &Arguments, ui: Ui) -> anyhow::Result<Outcome> {
    let (fit, damaged) = fit::make(&arguments.fit, ui)?;
    let inversion = invert::make(
        &invert::Arguments {
            maps: arguments.fit.maps.clone(),
            speed_breaks: None,
            accel_breaks: arguments.accel_breaks.clone(),
            place: None,
            zero_row: ZeroRow::Moving,
            node_exact: false,
            angle: Vec::new(),
            force: false,
        },
        ui,
    )?;
    let verdict = verify::make(&arguments.fit.maps, ui)?;
    let maps = &arguments.fit.maps;
    report::make(maps, &maps.join("report.html"), None)?;
    ui.document(&json!({ "table1": fit.file, "table2": inversion.file, "verify": verdict }))?;
    ui.say("── Table 1 ──");
    fit::show(&fit.file, ui);
    ui.say("");
    ui.say("── Table 2 ──");
    invert::show(&inversion.file, ui);
    ui.say("");
    ui.say("── Verdict ──");
    verify_text::show(&verdict, ui);
    ui.say("written: verify.json");
    let folder = arguments.fit.maps.display();
    let used = fit.file.report.ledger.iter().find(|r| r.verdict == crate::map::SampleVerdict::Used).map_or(0.0, |r| r.seconds);
    let total: f64 = fit.file.report.ledger.iter().map(|r| r.seconds).sum();
    let at_test_angle = |m: &&crate::map::AccelMap| m.angle().is_same(fit.file.vehicle.test_angle());
    let breakaway: Vec<String> =
        fit.file.maps.iter().filter(at_test_angle).map(|m| format!("{} {:.1} N·m", m.gear, m.breakaway.torque_nm)).collect();
    ui.say("");
    ui.say("── Summary ──");
    ui.say(format!("used         {used:.1} s of {total:.1} s, {} runs", fit.file.report.runs.iter().filter(|r| r.used_s > 0.0).count()));
    ui.say(format!(
        "drive        dead time {:.0} ms, lag {:.0} ms",
        1e3 * fit.file.actuator.dead_time.value_s,
        1e3 * fit.file.actuator.lag.value_s
    ));
    ui.say(format!("breakaway    {}", breakaway.join(", ")));
    ui.say(format!("coverage     {:.0} % of the cells measured", 100.0 * fit.file.report.coverage));
    let trip = inversion.file.maps.iter().map(|m| m.round_trip.between_rms_mps2).fold(0.0, f64::max);
    ui.say(format!("round trip   {trip:.4} m/s² root mean square"));
    ui.say(format!("verdict      {}", if verdict.passes() { "pass" } else { "FAIL" }));
    ui.say(format!("files        {folder}/table1.csv, table1.json, table2.csv, table2.json, verify.json, report.html"));
    Ok(if verdict.passes() && fit.sound && !damaged { Outcome::Done } else { Outcome::Rejected })
}
