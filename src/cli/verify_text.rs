//! A verdict as text: the table of the scenarios, replayed runs, pivots in operation, manoeuvres, and the comparison with other laws.

use crate::cli::Ui;
use crate::controller::ControllerFile;
use crate::map::{Check, CheckOutcome};
use crate::verify::{
    Class, LawComparison, LimitCheck, MapVerdict, Metric, RecordedPivots, ReplayedRun, ScenarioVerdict, Statistic, Status,
};
use comfy_table::{ContentArrangement, Table, presets};

/// An empty table under a header.
pub(crate) fn new_table(header: &[&str]) -> Table {
    let mut table = Table::new();
    table.load_style(presets::UTF8_FULL_CONDENSED).set_content_arrangement(ContentArrangement::Disabled).set_header(header.to_vec());
    table
}

/// Prints a verdict as text.
pub(crate) fn show(verdict: &MapVerdict, ui: Ui) {
    ui.say(format!("verdict: {}", verdict.headline()));
    let plan = verdict.controller_settings.as_ref().map(ControllerFile::label);
    if let Some(command) = &verdict.controller_command {
        let plan = plan.map_or(String::new(), |plan| format!("; planned and judged by the settings of {plan}"));
        ui.say(format!("controller: {}, {} ms for an answer{plan}", command.label(), command.timeout_ms));
    } else if let Some(plan) = plan {
        ui.say(format!("controller: {plan}"));
    }
    show_checks(&verdict.checks, ui);
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
    for scenario in verdict.scenarios.iter().filter(|s| s.status == Status::Fail) {
        for note in &scenario.notes {
            ui.say(format!("{}: {note}", scenario.name));
        }
    }
    manoeuvres(verdict, Class::Polyline, &[Metric::CornerErrorM, Metric::SegmentErrorM, Metric::SegmentRmsM, Metric::TimeS], ui);
    let compensated = [Metric::LateralBeforeM, Metric::LateralAfterM, Metric::LateralRatio, Metric::HeadingRateRatio];
    manoeuvres(verdict, Class::Compensation, &compensated, ui);
    if let Some(comparison) = &verdict.comparison {
        compare(comparison, ui);
    }
    show_replayed(&verdict.replayed, ui);
    show_pivots(&verdict.pivots, ui);
    for note in &verdict.notes {
        ui.say(format!("note: {note}"));
    }
    if verdict.scenarios.iter().any(|s| s.notes.iter().any(|n| n.starts_with("symmetry"))) {
        ui.say("note: mirrored right turns use the table of the wheel to the left: symmetry assumed");
    }
    ui.say(format!("verdict: {}", status_word(verdict.status)));
}

/// The checks that are not passed, one a line; with `-v` all of them.
pub(crate) fn show_checks(checks: &[Check], ui: Ui) {
    for check in checks {
        let line = |outcome: &str| format!("{outcome} {}: {}", check.name, check.text());
        match check.outcome {
            CheckOutcome::Passed => ui.detail(line("passed")),
            CheckOutcome::Warning => ui.say(line("warning")),
            CheckOutcome::Objection => ui.say(line("objection")),
        }
    }
}

/// A status as a word.
pub(crate) fn status_word(status: Status) -> &'static str {
    match status {
        Status::Pass => "pass",
        Status::Fail => "FAIL",
        Status::Rejected => "rejected",
        Status::NotJudged => "not judged",
        Status::NotTested => "not tested",
    }
}

/// Shown of a scenario: the broken limits, or the one nearest to being broken. `verify.json` has all of them.
fn rows(table: &mut Table, scenario: &ScenarioVerdict) {
    if scenario.status == Status::NotTested {
        table.add_row([scenario.name.as_str(), "", "", "", "", "not tested"]);
        return;
    }
    if scenario.controller_fault().is_some() {
        table.add_row([scenario.name.as_str(), "controller", "", "broke", "", mark(false)]);
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

/// Used share of a limit: 1 at the limit. A lower limit counts little while it is kept.
fn used(check: &LimitCheck) -> f64 {
    match (check.value, check.at_most) {
        (Some(value), Some(limit)) if limit > 0.0 => value / limit,
        _ => 0.0,
    }
}

fn mark(pass: bool) -> &'static str {
    if pass { "pass" } else { "FAIL" }
}

fn value(check: &LimitCheck) -> String {
    check.value.map_or("none".to_owned(), |v| check.metric.with_unit(v))
}

fn limit(check: &LimitCheck) -> String {
    let at_most = check.at_most.map(|m| format!("≤ {}", check.metric.with_unit(m)));
    at_most.or_else(|| check.at_least.map(|m| format!("≥ {}", check.metric.with_unit(m)))).unwrap_or_default()
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
        let figure = |s: Statistic| summary.figure(s).map_or("none".to_owned(), |v| summary.metric.with_unit(v));
        table.add_row(std::iter::once(summary.metric.title().to_owned()).chain(statistics.map(figure)));
    }
    ui.detail(table.to_string());
}

/// The replayed runs, one per row, and their medians.
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

/// The pivots in operation, one row per log and gear.
fn show_pivots(pivots: &[RecordedPivots], ui: Ui) {
    if pivots.is_empty() {
        return;
    }
    let mut table =
        new_table(&["pivots in operation", "gear", "compared", "desired (RMS)", "actual − desired: mean", "RMS", "of it noise", "gain"]);
    for found in pivots {
        let of_reach = |mps2: f64| format!("{mps2:.3} m/s² ({:.1} %)", 100.0 * mps2 / found.reach_mps2);
        table.add_row([
            found.file.clone(),
            found.gear.to_string(),
            format!("{:.1} s", found.seconds),
            of_reach(found.desired_rms_mps2),
            of_reach(found.mean_mps2),
            of_reach(found.rms_mps2),
            of_reach(found.noise_mps2),
            format!("{:.2}", found.gain),
        ]);
    }
    ui.say(table.to_string());
    ui.say("percentages are of the largest acceleration; gain: actual over desired acceleration");
}

/// The values of manoeuvres of one class: nominal, and the largest over the draws.
fn manoeuvres(verdict: &MapVerdict, class: Class, metrics: &[Metric], ui: Ui) {
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

/// The map compared with the other laws: medians over the draws.
fn compare(comparison: &LawComparison, ui: Ui) {
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
            found.map_or("none".to_owned(), |v| metric.with_unit(v))
        };
        table.add_row(std::iter::once(law.name.clone()).chain(metrics.map(figure)));
    }
    ui.say(table.to_string());
    let text = |ratio: Option<f64>| ratio.map_or("none".to_owned(), |r| format!("{r:.2}"));
    ui.say(format!("start jerk, map over conventional law: {} (goal: at most 0.33)", text(comparison.start_jerk_ratio)));
    ui.say(format!("speed tracking, map over perfect inverse: {} (goal: at most 1.15)", text(comparison.speed_rms_ratio)));
}
