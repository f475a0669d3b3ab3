//! `verify`: judges the map in a folder, prints the verdict and writes `verify.json`.

use super::logs::LogArguments;
use super::{Outcome, Ui, points};
use crate::log::Preset;
use crate::map::write_whole;
use crate::sim::VehicleFile;
use crate::spelling::edits;
use crate::verify::{
    Check, Class, Comparison, Error, Gate, Manoeuvre, Maps, Metric, ReplayedRun, Scenario, ScenarioVerdict, Settings, Statistic, Status,
    Verdict, closed_loop, log_of, log_of_manoeuvre, manoeuvre_traces, replayed, verify_watched,
};
use anyhow::{Context, bail};
use comfy_table::{ContentArrangement, Table, presets};
use std::path::{Path, PathBuf};

/// Arguments of `verify`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  pivot-cal verify                            all pivots on the map in ./maps
  pivot-cal verify --scenario left-90 -v      one scenario, every metric
  pivot-cal verify --scenario polyline-lqr -v one manoeuvre (all of them: manoeuvres)
  pivot-cal verify --scenario polyline-mpc --points yard.csv   the same along points of your own
  pivot-cal verify --gate strict.toml         limits of your own, over the built-in ones
  pivot-cal verify --replay held_out.mcap     recorded runs through the plant, too

Exit status: 0 the map passes, 3 it does not, 1 it cannot be judged.")]
pub(super) struct Arguments {
    /// Folder with table1.json, table2.json and table2.csv
    #[arg(long, value_name = "DIR", default_value = "maps")]
    maps: PathBuf,
    /// Run this scenario, manoeuvre or group (pivots, manoeuvres, all) instead of the pivots (may be repeated)
    #[arg(long, value_name = "NAME")]
    scenario: Vec<String>,
    /// List the scenarios and stop
    #[arg(long)]
    list: bool,
    /// Go on when a hash does not match
    #[arg(long)]
    force: bool,
    /// Write a log of each scenario's nominal run into this folder
    #[arg(long, value_name = "DIR")]
    log: Option<PathBuf>,
    /// Limits that replace the built-in ones
    #[arg(long, value_name = "FILE")]
    gate: Option<PathBuf>,
    /// Also replay the runs of this log, best one that the fit has not seen, through the plant: recorded against simulated speed (may be
    /// repeated)
    #[arg(long, value_name = "LOG")]
    replay: Vec<PathBuf>,
    /// Signal map of the replayed logs
    #[arg(long, value_name = "FILE", requires = "replay", conflicts_with = "preset")]
    signals: Option<PathBuf>,
    /// Signal map of the replayed logs that comes with the program: pivot-cal, autoware, joint-state
    #[arg(long, value_name = "NAME", requires = "replay")]
    preset: Option<Preset>,
    /// Points that the polyline manoeuvres drive instead of their own (CSV: x and y in metres, a line each)
    #[arg(long, value_name = "FILE")]
    points: Option<PathBuf>,
    /// Vehicle that drives the manoeuvres (TOML) instead of the bundled scrubber
    #[arg(long, value_name = "FILE")]
    vehicle: Option<PathBuf>,
    /// Perturbed plants per scenario
    #[arg(long, value_name = "N", default_value_t = 200)]
    draws: usize,
    /// Seed of everything random
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
}

pub(super) fn run(arguments: &Arguments, ui: Ui) -> anyhow::Result<Outcome> {
    if arguments.list {
        list(ui)?;
        return Ok(Outcome::Done);
    }
    let gate = arguments.gate.as_ref().map(fs_err::read_to_string).transpose()?;
    let defaults = Settings::new()?;
    let (scenarios, mut manoeuvres) = chosen(&arguments.scenario)?;
    if let Some(path) = &arguments.points {
        if manoeuvres.iter().all(|m| m.class != Class::Polyline) {
            bail!("--points needs a polyline to drive them, as --scenario polyline-lqr");
        }
        let points = points::read(path)?;
        manoeuvres =
            manoeuvres.into_iter().map(|m| m.along(&points)).collect::<Result<_, _>>().with_context(|| path.display().to_string())?;
    }
    let settings = Settings {
        scenarios,
        manoeuvres,
        manoeuvre_draws: arguments.draws.min(defaults.manoeuvre_draws),
        manoeuvre_vehicle: match &arguments.vehicle {
            Some(path) => {
                let text = fs_err::read_to_string(path)?;
                VehicleFile::from_toml(&text).with_context(|| path.display().to_string())?.settings()
            }
            None => defaults.manoeuvre_vehicle.clone(),
        },
        draws: arguments.draws,
        seed: arguments.seed,
        gate: match &arguments.gate {
            Some(path) => Gate::with(gate.as_deref()).with_context(|| path.display().to_string())?,
            None => Gate::with(None)?,
        },
        ..defaults
    };
    let maps = Maps::read(&arguments.maps, arguments.force)?;
    for forced in &maps.forced {
        ui.warn(format!("{forced}; going on, since --force was given"));
    }
    let mut verdict = watched(&maps, &settings, ui)?;
    verdict.replayed = replay_logs(arguments, &maps, ui)?;
    let path = arguments.maps.join("verify.json");
    save(&maps, &settings, &verdict, &arguments.maps)?;
    ui.document(&verdict)?;
    show(&verdict, ui);
    ui.say(format!("written: {}", path.display()));
    if let Some(folder) = &arguments.log {
        for scenario in settings.scenarios.iter().filter(|s| !s.needs_reverse() || maps.reverse.is_some()) {
            let path = folder.join(format!("{}.mcap", scenario.name));
            write_whole(&path, &log_of(&maps, &settings, scenario)?)?;
            ui.detail(format!("written: {}", path.display()));
        }
        let tested = |m: &&Manoeuvre| verdict.scenarios.iter().any(|s| s.name == m.name && s.status != Status::NotTested);
        for manoeuvre in settings.manoeuvres.iter().filter(tested) {
            let path = folder.join(format!("{}.mcap", manoeuvre.name));
            write_whole(&path, &log_of_manoeuvre(&maps, &settings, manoeuvre)?)?;
            ui.detail(format!("written: {}", path.display()));
        }
    }
    Ok(if verdict.passes() { Outcome::Done } else { Outcome::Rejected })
}

/// Judges the map in `folder` with the defaults and writes `verify.json` there.
pub(super) fn make(folder: &Path, ui: Ui) -> anyhow::Result<Verdict> {
    let maps = Maps::read(folder, false)?;
    let settings = Settings::new()?;
    let verdict = watched(&maps, &settings, ui)?;
    save(&maps, &settings, &verdict, folder)?;
    Ok(verdict)
}

/// The verdict, with a progress bar on a terminal.
fn watched(maps: &Maps, settings: &Settings, ui: Ui) -> anyhow::Result<Verdict> {
    let bar = ui.progress_runs("verifying");
    let verdict = verify_watched(maps, settings, &|total| {
        bar.set_length(total as u64);
        bar.inc(1);
    })?;
    bar.finish_and_clear();
    Ok(verdict)
}

/// Writes `verify.json`, and the traces of the comparison and of the manoeuvres beside it for the report.
fn save(maps: &Maps, settings: &Settings, verdict: &Verdict, folder: &Path) -> anyhow::Result<()> {
    write_whole(&folder.join("verify.json"), verdict.to_json()?.as_bytes())?;
    let path = folder.join("verify_traces.json");
    match closed_loop(maps, settings, verdict)? {
        Some(traces) => write_whole(&path, traces.to_json()?.as_bytes())?,
        // those of an earlier verdict would pass for its own
        None if path.exists() => fs_err::remove_file(path)?,
        None => {}
    }
    // those of an earlier verdict stay: they name the Table 2 that they belong to
    if let Some(traces) = manoeuvre_traces(maps, settings, verdict)? {
        write_whole(&folder.join("manoeuvre_traces.json"), traces.to_json()?.as_bytes())?;
    }
    Ok(())
}

/// The runs of the logs of `--replay` through the plant of Table 1.
fn replay_logs(arguments: &Arguments, maps: &Maps, ui: Ui) -> anyhow::Result<Vec<ReplayedRun>> {
    if arguments.replay.is_empty() {
        return Ok(Vec::new());
    }
    let logs = LogArguments::of_vehicle(&arguments.replay, arguments.signals.clone(), arguments.preset, &maps.table1.vehicle);
    let mut runs = Vec::new();
    for survey in logs.survey(None, ui)? {
        runs.extend(replayed(&maps.table1, &survey)?);
    }
    Ok(runs)
}

/// The scenarios and manoeuvres named, in the order of the command line; without a name all pivots. Groups: `pivots`, `manoeuvres`, `all`.
fn chosen(names: &[String]) -> Result<(Vec<Scenario>, Vec<Manoeuvre>), Error> {
    let (all, all_manoeuvres) = (Scenario::all(), Manoeuvre::all());
    if names.is_empty() {
        return Ok((all, Vec::new()));
    }
    let groups = ["pivots", "manoeuvres", "all"];
    let known: Vec<&str> =
        groups.into_iter().chain(all.iter().map(|s| s.name.as_str())).chain(all_manoeuvres.iter().map(|m| m.name.as_str())).collect();
    if let Some(name) = names.iter().find(|name| !known.contains(&name.as_str())) {
        let nearest = known.iter().min_by_key(|known| apart(known, name)).map(|known| (*known).to_owned()).unwrap_or_default();
        return Err(Error::NoScenario { found: name.clone(), nearest });
    }
    let (mut scenarios, mut manoeuvres): (Vec<Scenario>, Vec<Manoeuvre>) = (Vec::new(), Vec::new());
    for name in names {
        let is = |group: &str, own: &str| name == own || name == group || name == "all";
        for scenario in all.iter().filter(|s| is("pivots", &s.name)) {
            if !scenarios.contains(scenario) {
                scenarios.push(scenario.clone());
            }
        }
        for manoeuvre in all_manoeuvres.iter().filter(|m| is("manoeuvres", &m.name)) {
            if manoeuvres.iter().all(|m| m.name != manoeuvre.name) {
                manoeuvres.push(manoeuvre.clone());
            }
        }
    }
    Ok((scenarios, manoeuvres))
}

/// How far a known name is from one that was given: none if it begins with it, else the letters to change.
fn apart(known: &str, given: &str) -> usize {
    if !given.is_empty() && known.starts_with(given) { 0 } else { edits(known, given) }
}

fn list(ui: Ui) -> anyhow::Result<()> {
    let (all, manoeuvres) = (Scenario::all(), Manoeuvre::all());
    let documents: Result<Vec<_>, _> = all.iter().map(serde_json::to_value).chain(manoeuvres.iter().map(serde_json::to_value)).collect();
    ui.document(&documents?)?;
    let mut table = new_table(&["scenario", "what"]);
    for (name, what) in all.into_iter().map(|s| (s.name, s.what)).chain(manoeuvres.into_iter().map(|m| (m.name, m.what))) {
        table.add_row([name, what]);
    }
    ui.say(table.to_string());
    Ok(())
}

fn new_table(header: &[&str]) -> Table {
    let mut table = Table::new();
    table.load_style(presets::UTF8_FULL_CONDENSED).set_content_arrangement(ContentArrangement::Disabled).set_header(header.to_vec());
    table
}

/// Prints a verdict for people.
pub(super) fn show(verdict: &Verdict, ui: Ui) {
    let mut table = new_table(&["scenario", "metric", "", "value", "limit", ""]);
    for trip in &verdict.round_trip {
        let value = trip.worst.map_or("none".to_owned(), |w| format!("{:.3} m/s²", w.error_mps2.abs()));
        let limit = trip.worst.map_or(String::new(), |w| format!("≤ {:.3}", w.limit_mps2));
        let angle = trip.wheel_angle_deg.map_or(String::new(), |angle| format!(" at {angle}°"));
        let name = format!("round trip, {}{angle} ({} places)", trip.gear, trip.places);
        table.add_row([name, "worst |Δa|".to_owned(), String::new(), value, limit, mark(trip.pass).to_owned()]);
    }
    for scenario in &verdict.scenarios {
        rows(&mut table, scenario);
    }
    ui.say(table.to_string());
    for scenario in &verdict.scenarios {
        detail(scenario, ui);
    }
    manoeuvres(verdict, Class::Polyline, &[Metric::CornerErrorM, Metric::SegmentErrorM, Metric::SegmentRmsM, Metric::TimeS], ui);
    let compensated = [Metric::LateralBeforeM, Metric::LateralAfterM, Metric::LateralRatio, Metric::HeadingRateRatio];
    manoeuvres(verdict, Class::Compensation, &compensated, ui);
    if let Some(comparison) = &verdict.comparison {
        compare(comparison, ui);
    }
    show_replayed(&verdict.replayed, ui);
    for note in &verdict.notes {
        ui.say(format!("note: {note}"));
    }
    if verdict.scenarios.iter().any(|s| s.notes.iter().any(|n| n.starts_with("symmetry"))) {
        ui.say("note: mirrored right turns use the table of the wheel to the left: symmetry assumed");
    }
    ui.say(format!("verdict: {}", if verdict.passes() { "pass" } else { "FAIL" }));
}

/// Shown of a scenario: the limits that are not kept, or the one nearest to not being kept. `verify.json` has them all.
fn rows(table: &mut Table, scenario: &ScenarioVerdict) {
    if scenario.status == Status::NotTested {
        table.add_row([scenario.name.as_str(), "", "", "", "", "not tested"]);
        return;
    }
    let failed = scenario.checks.iter().any(|c| !c.pass);
    let nearest = scenario.checks.iter().enumerate().max_by(|a, b| used(a.1).total_cmp(&used(b.1))).map(|(k, _)| k);
    let shown = scenario.checks.iter().enumerate().filter(|(k, c)| if failed { !c.pass } else { Some(*k) == nearest });
    for (row, (_, check)) in shown.enumerate() {
        let name = if row == 0 { scenario.name.clone() } else { String::new() };
        let (metric, statistic) = (check.metric.title().to_owned(), check.statistic.title().to_owned());
        table.add_row([name, metric, statistic, value(check), limit(check), mark(check.pass).to_owned()]);
    }
}

/// How much of a limit is used up: 1 at the limit. A limit from below counts little while it is kept.
fn used(check: &Check) -> f64 {
    match (check.value, check.at_most) {
        (Some(value), Some(limit)) if limit > 0.0 => value / limit,
        _ => 0.0,
    }
}

fn mark(pass: bool) -> &'static str {
    if pass { "pass" } else { "FAIL" }
}

fn value(check: &Check) -> String {
    check.value.map_or("none".to_owned(), |v| number(check.metric, v))
}

fn limit(check: &Check) -> String {
    let at_most = check.at_most.map(|m| format!("≤ {}", number(check.metric, m)));
    at_most.or_else(|| check.at_least.map(|m| format!("≥ {}", number(check.metric, m)))).unwrap_or_default()
}

/// A value with its unit; shares in per cent.
fn number(metric: Metric, value: f64) -> String {
    match metric.unit() {
        "" => format!("{:.1} %", 100.0 * value),
        "°" => format!("{value:.2}°"),
        unit => format!("{value:.3} {unit}"),
    }
}

/// Every metric of a scenario, with `-v`.
fn detail(scenario: &ScenarioVerdict, ui: Ui) {
    if scenario.status == Status::NotTested {
        return;
    }
    ui.detail(format!("{}: {}", scenario.name, scenario.what));
    let statistics = [Statistic::Nominal, Statistic::Median, Statistic::P95, Statistic::P99, Statistic::Max];
    let mut table = new_table(&["metric", "nominal", "median", "95 %", "99 %", "max"]);
    for summary in &scenario.metrics {
        let figure = |s: Statistic| summary.figure(s).map_or("none".to_owned(), |v| number(summary.metric, v));
        table.add_row(std::iter::once(summary.metric.title().to_owned()).chain(statistics.map(figure)));
    }
    ui.detail(table.to_string());
}

/// The replayed runs, one a row, and their medians.
fn show_replayed(runs: &[ReplayedRun], ui: Ui) {
    if runs.is_empty() {
        return;
    }
    let mut table = new_table(&["replayed run", "gear", "from", "length", "R²", "RMSE", "largest"]);
    for run in runs {
        let r_squared = run.r_squared.map_or("none".to_owned(), |r| format!("{r:.4}"));
        let (from, length) = (format!("{:.2} s", run.from_s), format!("{:.2} s", run.seconds));
        let (rmse, largest) = (format!("{:.4} m/s", run.rmse_mps), format!("{:.4} m/s", run.max_mps));
        table.add_row([run.file.clone(), run.gear.to_string(), from, length, r_squared, rmse, largest]);
    }
    ui.say(table.to_string());
    let median = |mut values: Vec<f64>| {
        values.sort_by(f64::total_cmp);
        values.get(values.len() / 2).map_or("none".to_owned(), |v| format!("{v:.4}"))
    };
    let held_out = runs.iter().filter(|r| !r.fitted).count();
    ui.say(format!(
        "replayed open loop: {} runs, {held_out} of them held out of the fit; median R² {}, median RMSE {} m/s",
        runs.len(),
        median(runs.iter().filter_map(|r| r.r_squared).collect()),
        median(runs.iter().map(|r| r.rmse_mps).collect())
    ));
}

/// The figures of manoeuvres of one class: nominal, and the largest over the draws.
fn manoeuvres(verdict: &Verdict, class: Class, metrics: &[Metric], ui: Ui) {
    let tested: Vec<_> = verdict.scenarios.iter().filter(|s| s.class == class && s.status != Status::NotTested).collect();
    if tested.is_empty() {
        return;
    }
    let header: Vec<_> = std::iter::once("nominal (largest)").chain(metrics.iter().map(|m| m.title())).collect();
    let mut table = new_table(&header);
    for scenario in tested {
        let figure = |metric: &Metric| {
            let shown = |v: f64| match metric.unit() {
                "m" => format!("{:.1}", 1e3 * v),
                "s" => format!("{v:.1}"),
                _ => format!("{v:.3}"),
            };
            let unit = if metric.unit() == "m" { "mm" } else { metric.unit() };
            let summary = scenario.metrics.iter().find(|s| s.metric == *metric);
            let nominal = summary.and_then(|s| s.nominal).map_or("none".to_owned(), |v| format!("{} {unit}", shown(v)));
            summary.and_then(|s| s.max).map_or(nominal.clone(), |v| format!("{nominal} ({})", shown(v)))
        };
        table.add_row(std::iter::once(scenario.name.clone()).chain(metrics.iter().map(figure)));
    }
    ui.say(table.to_string());
}

/// The map beside the other laws: medians over the draws.
fn compare(comparison: &Comparison, ui: Ui) {
    let metrics = [
        Metric::AsExpected,
        Metric::HeadingErrorDeg,
        Metric::SpeedRmsMps,
        Metric::StartJerkMps3,
        Metric::PeakAccelMps2,
        Metric::SettlingTimeS,
    ];
    let header: Vec<_> = std::iter::once(comparison.scenario.as_str()).chain(metrics.map(Metric::title)).collect();
    let mut table = new_table(&header);
    for law in &comparison.laws {
        let figure = |metric: Metric| {
            let statistic = if metric == Metric::AsExpected { Statistic::Mean } else { Statistic::Median };
            let found = law.metrics.iter().find(|s| s.metric == metric).and_then(|s| s.figure(statistic));
            found.map_or("none".to_owned(), |v| number(metric, v))
        };
        table.add_row(std::iter::once(law.name.clone()).chain(metrics.map(figure)));
    }
    ui.say(table.to_string());
    let told = |ratio: Option<f64>| ratio.map_or("none".to_owned(), |r| format!("{r:.2}"));
    ui.say(format!("start jerk, map over conventional law: {} (goal: at most 0.33)", told(comparison.start_jerk_ratio)));
    ui.say(format!("speed tracking, map over perfect inverse: {} (goal: at most 1.15)", told(comparison.speed_rms_ratio)));
}
