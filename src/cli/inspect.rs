//! `inspect LOG…`: the content of logs, and the signals found.

use crate::cli::Ui;
use crate::cli::logs::preset;
use crate::cli::outcome::Outcome;
use crate::log;
use crate::log::{Depth, LogSurvey, Preset, Source, VehicleOverrides};
use crate::text::shown;
use anyhow::Context as _;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// Logs up to this size are read completely by default, which takes no longer than the summary [bytes].
const SMALL: u64 = 64 << 20;

/// Arguments of `inspect`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  pivot-cal inspect drive.mcap
  pivot-cal inspect drive.csv                 a table: which column is which signal, how its times are read
  pivot-cal inspect --runs --signals data/signals/reference.toml logs/*.mcap

Memory: logs of any size are read by the chunk (256 MB at most, two per thread) with 32 bytes for each value of a signal, at most
128 million values in all logs (4 GB); tables by the line (4 MB at most) or the page of a column. What needs more is refused.")]
pub(crate) struct Arguments {
    /// Logs: files, folders of logs, rosbag2 folders, or patterns
    #[arg(required = true, value_name = "LOG")]
    logs: Vec<PathBuf>,
    /// Signal map: which message path is which signal, and where its time is (docs/signals.md)
    #[arg(long, value_name = "FILE", conflicts_with = "preset")]
    signals: Option<PathBuf>,
    /// Signal map that comes with the program: pivot-cal, autoware or joint-state
    #[arg(long, value_name = "NAME", value_parser = preset(), hide_possible_values = true)]
    preset: Option<Preset>,
    /// Read every message: true rates, losses, the runs, and checks of the signals; an objection ends with status 3
    #[arg(long)]
    runs: bool,
    /// Wheelbase [m], for --runs, over any signal map
    #[arg(long, value_name = "M")]
    wheelbase_m: Option<f64>,
    /// Rolling radius of the front wheel [m], for --runs, over any signal map
    #[arg(long, value_name = "M")]
    wheel_radius_m: Option<f64>,
    /// Wheel angle of the test [°], for --runs, over any signal map
    #[arg(long, value_name = "DEG", allow_negative_numbers = true)]
    test_angle_deg: Option<f64>,
    /// End with status 3 if a log is damaged
    #[arg(long)]
    strict: bool,
}

/// The JSON document.
#[derive(serde::Serialize)]
struct InspectDocument {
    logs: Vec<Inspected>,
}

/// One log of the JSON document: its content, and with `--runs` its runs. A recording in several files has its runs at the last file.
#[derive(serde::Serialize)]
struct Inspected {
    #[serde(flatten)]
    survey: LogSurvey,
    #[serde(skip_serializing_if = "Option::is_none")]
    runs: Option<crate::cli::inspect_runs::Runs>,
}

pub(crate) fn run(arguments: &Arguments, ui: Ui) -> anyhow::Result<Outcome> {
    let source = crate::cli::logs::source(arguments.signals.as_deref(), arguments.preset)?;
    let overrides = VehicleOverrides {
        wheelbase_m: arguments.wheelbase_m,
        wheel_radius_m: arguments.wheel_radius_m,
        test_angle_deg: arguments.test_angle_deg,
        torque_limit_nm: None,
        torque_full_scale_nm: None,
    };
    let mut recordings = Vec::new();
    for named in &arguments.logs {
        recordings.extend(log::find_logs(named).with_context(|| shown(named))?);
    }
    let mut surveys = Vec::new();
    for files in &recordings {
        for (number, path) in files.iter().enumerate() {
            let survey = survey(path, &source, arguments.runs, ui).with_context(|| shown(path))?;
            if let Some(loss) = survey.loss.as_ref().and_then(log::Loss::summary) {
                ui.warn(format!("{}: {loss}", shown(path)));
            }
            ui.say(text(&survey));
            let is_whole = arguments.runs && number + 1 == files.len();
            let runs = is_whole.then(|| crate::cli::inspect_runs::runs(files, &source, &overrides, ui)).flatten();
            surveys.push(Inspected { survey, runs });
        }
    }
    let objects = surveys.iter().any(|inspected| inspected.runs.as_ref().is_some_and(crate::cli::inspect_runs::Runs::objects));
    let damaged = surveys.iter().any(|inspected| inspected.survey.loss.as_ref().is_some_and(log::Loss::is_damaged));
    ui.document(&InspectDocument { logs: surveys })?;
    Ok(if objects || damaged && arguments.strict { Outcome::Rejected } else { Outcome::Done })
}

fn survey(path: &Path, source: &Source, everything: bool, ui: Ui) -> anyhow::Result<LogSurvey> {
    let bytes = std::fs::metadata(path)?.len();
    let depth = if everything || bytes <= SMALL { Depth::Everything } else { Depth::Summary };
    let bar = ui.progress(bytes, "reading");
    let survey = log::survey(path, source, depth, &|read| bar.inc(read));
    bar.finish_and_clear();
    Ok(survey?)
}

/// The survey as text.
fn text(survey: &LogSurvey) -> String {
    let mut text = String::new();
    let count = |number: Option<u64>| number.map_or_else(|| "?".to_owned(), |number| number.to_string());
    if let Some(table) = &survey.table {
        let _ = writeln!(text, "{}  {}, a table: {table}", survey.file, indicatif::HumanBytes(survey.bytes));
        let _ = writeln!(text, "  {} row(s){}", count(survey.messages), span(survey));
    } else {
        let writer = if survey.library.is_empty() { "an unknown writer" } else { &survey.library };
        let _ = writeln!(text, "{}  {}, by {writer}", survey.file, indicatif::HumanBytes(survey.bytes));
        let index = if survey.indexed { "indexed" } else { "no usable index: scanned" };
        let compression = if survey.compression.is_empty() { String::new() } else { format!(", {}", survey.compression.join(" + ")) };
        let _ =
            writeln!(text, "  {} message(s) in {} chunk(s){compression}, {index}{}", count(survey.messages), survey.chunks, span(survey));
    }
    let mut table = comfy_table::Table::new();
    table.load_style(comfy_table::presets::NOTHING);
    table.set_header(["topic", "schema", "encoding", "messages", "rate [Hz]"]);
    for topic in &survey.topics {
        let schema = match (&topic.schema, &topic.schema_encoding) {
            (Some(name), Some(encoding)) if *encoding != topic.encoding => format!("{name} ({encoding})"),
            (Some(name), _) => name.clone(),
            _ => "none".to_owned(),
        };
        let rate = topic.rate_hz.map_or_else(String::new, |rate| format!("{rate:.1}"));
        table.add_row([topic.topic.clone(), schema, topic.encoding.clone(), count(topic.messages), rate]);
    }
    let _ = writeln!(text, "{}", indented(&table.to_string()));
    let _ = writeln!(text, "signals");
    for found in &survey.signals {
        let mut rates = String::new();
        if let Some(rate) = found.rate {
            let _ = write!(rates, ", {:.1} Hz", rate.logged_hz);
            if rate.true_hz < 0.9 * rate.logged_hz {
                let _ = write!(rates, " (but the value changes at {:.1} Hz only: it is repeated)", rate.true_hz);
            }
        }
        if let Some(kind) = found.messages.filter(|kind| *kind != log::MessageKind::Periodic) {
            let _ = write!(rates, ", {kind}");
        }
        let values = found.values.map_or_else(String::new, |values| format!(", {values} values{}", range_text(found.range)));
        let _ = writeln!(text, "  {:16} {} [{}]{values}{rates}: {}", found.signal.key(), found.path, found.unit, found.reason);
    }
    for missing in &survey.missing {
        let need = if missing.required { "missing" } else { "not found, not required" };
        let near = if missing.candidates.is_empty() { String::new() } else { format!("; nearest: {}", missing.candidates.join(", ")) };
        let _ = writeln!(text, "  {:16} {need}{near}", missing.signal.key());
    }
    for note in &survey.notes {
        let _ = writeln!(text, "note: {note}");
    }
    if !survey.checked {
        let part = if survey.table.is_some() { "the first rows" } else { "the summary" };
        let _ = writeln!(text, "(from {part} alone; --runs reads every message)");
    }
    text.trim_end().to_owned()
}

/// Between which values a signal lies, in which steps, and whether it stays at a limit.
fn range_text(range: Option<log::ValueRange>) -> String {
    let Some(range) = range else { return String::new() };
    // four digits, without a minus before zero
    let short = |value: f64| {
        let digits = if value == 0.0 { 0 } else { (3 - value.abs().log10().floor() as i32).clamp(0, 9) };
        let text = format!("{value:.*}", digits as usize);
        let text = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text };
        if text == "-0" { "0".to_owned() } else { text }
    };
    let mut text = if range.lowest < range.highest {
        format!(" from {} to {}", short(range.lowest), short(range.highest))
    } else {
        format!(", all {}", short(range.lowest))
    };
    if let Some(step) = range.step {
        let _ = write!(text, " in steps of {}", short(step));
    }
    if let Some(share) = range.at_limit_share {
        let _ = write!(text, ", {:.0} % of them at a limit", 100.0 * share);
    }
    text
}

fn span(survey: &LogSurvey) -> String {
    let Some((start, end)) = survey.start_ns.zip(survey.end_ns) else {
        return String::new();
    };
    let seconds = end.saturating_sub(start) as f64 / crate::units::NS_PER_S;
    let date = i64::try_from(start).ok().and_then(|start| jiff::Timestamp::from_nanosecond(i128::from(start)).ok());
    date.map_or_else(|| format!(", {seconds:.1} s"), |date| format!(", {seconds:.1} s from {date:.0}"))
}

fn indented(table: &str) -> String {
    table.lines().map(|line| format!("  {}", line.trim())).collect::<Vec<_>>().join("\n")
}
