//! The runs of a log for `inspect --runs`: the data that a fit would use, and the cuts with their reasons, before there is a model.

use crate::campaign;
use crate::campaign::{Census, HeldAngle, Survey, ledger, runs as run_rows, with_missing};
use crate::cli::Ui;
use crate::cli::verify_text::show_checks;
use crate::log::{SignalName, Source, VehicleOverrides, read_split};
use crate::map::{Check, LedgerRow, RunRow};
use crate::signal::Track;
use crate::text::shown;
use comfy_table::{Table, presets};
use std::path::PathBuf;

/// The runs and the ledger of one log.
#[derive(serde::Serialize)]
pub(crate) struct Runs {
    ledger: Vec<LedgerRow>,
    runs: Vec<RunRow>,
    /// The checks that need no fit.
    checks: Vec<Check>,
    /// The wheel angles of the runs, if they are not all at the test angle.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    wheel_angles: Vec<HeldAngle>,
}

/// Surveys one recording, given as its files, and prints its runs. A log that cannot be surveyed is reported; `inspect` does not fail.
pub(crate) fn runs(files: &[PathBuf], source: &Source, overrides: &VehicleOverrides, ui: Ui) -> Option<Runs> {
    let mut census = Census::default();
    let mut survey = || -> anyhow::Result<Survey> {
        let bytes = files.iter().map(|path| Ok(std::fs::metadata(path)?.len())).sum::<std::io::Result<u64>>()?;
        let bar = ui.progress(bytes, "reading runs");
        let recording = read_split(files, &SignalName::ALL, source, overrides, &|read| bar.inc(read));
        bar.finish_and_clear();
        let track = Track::new(&recording?)?;
        census = Census::new([&track], &campaign::SurveySettings::default());
        if census.has_others(track.vehicle.test_angle_deg) {
            ui.say(format!("wheel angles of the runs: {}; below, the test angle (--test-angle-deg shows another)", census.text()));
        } else {
            census.held.clear();
        }
        Ok(Survey::new(track, &campaign::SurveySettings::default())?)
    };
    let survey = match survey() {
        Ok(survey) => survey,
        Err(error) => {
            let named: Vec<String> = files.iter().map(shown).collect();
            ui.warn(format!("{}: no runs: {error:#}", named.join(", ")));
            return None;
        }
    };
    let rows: Vec<RunRow> = run_rows(&survey, &survey.verdicts, 1.0).into_iter().map(|(_, row)| row).collect();
    let table = with_missing(ledger(survey.verdicts.iter().copied().zip(survey.seconds.iter().copied())), survey.missing_s());
    ui.say(text(&rows));
    for row in &table {
        ui.say(format!("  {:32} {:6} samples {:8.2} s", row.verdict, row.samples, row.seconds));
    }
    for note in &survey.track.notes {
        ui.say(format!("  note: {note}"));
    }
    let checks = survey.checks();
    show_checks(&checks, ui);
    Some(Runs { ledger: table, runs: rows, checks, wheel_angles: census.held })
}

impl Runs {
    /// Whether a check is an objection.
    pub(crate) fn objects(&self) -> bool {
        self.checks.iter().any(Check::objects)
    }
}

fn text(rows: &[RunRow]) -> String {
    let mut table = Table::new();
    table.load_style(presets::NOTHING).set_header([
        "start s",
        "held s",
        "gear",
        "torque N·m",
        "from m/s",
        "to m/s",
        "usable s",
        "left out",
    ]);
    for row in rows {
        let reasons: Vec<String> = row.rejected.iter().map(|r| format!("{} {:.2} s", r.verdict, r.seconds)).collect();
        table.add_row([
            format!("{:.2}", row.start_s),
            format!("{:.2}", row.duration_s),
            row.gear.to_string(),
            format!("{:.1}", row.torque_nm),
            format!("{:.3}", row.start_speed_mps),
            format!("{:.3}", row.end_speed_mps),
            format!("{:.2}", row.used_s),
            reasons.join(", "),
        ]);
    }
    table.to_string()
}
