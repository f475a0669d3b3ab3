//! Closed loop: the pivot over time by the map and by the conventional law, the laws compared, and every scenario.

use crate::controller::{ControllerFile, ControllerSettings};
use crate::report::ReportFiles;
use crate::report::chart::{Area, Chart, Line, Panel, Points};
use crate::report::html::TableColumn::{Number, Text};
use crate::report::html::{TableColumn, num_or_dash, table};
use crate::report::section::{Figures, Section};
use crate::report::svg::num;
use crate::text::shown;
use crate::verify::{
    Bands, ClosedLoop, ControllerCommand, LawComparison, LawTraces, LimitCheck, MapVerdict, Metric, MetricSummary, ScenarioVerdict,
    Statistic, Status,
};
use maud::{Markup, html};

/// The closed loop as a section.
pub(crate) fn closed_loop(inputs: &ReportFiles) -> Section {
    let mut figures = Figures::default();
    let body = html! {
        @if let Some(traces) = &inputs.closed_loop {
            p {
                (traces.what) ", from the gear being set, driven by the map and by the conventional law (heading PID, tuned for this vehicle) on \
                 the plant that Table 1 identified. Lines are medians over " (traces.draws) " perturbed plants, the inner bands hold half of \
                 them, the outer ones 90 %."
            }
            (figures.chart(&pivot(traces)))
        } @else {
            p.absent { "The traces of the pivot are not here: verify_traces.json is missing or belongs to another Table 2." }
        }
        @if let Some(verdict) = inputs.verdict.as_ref().filter(|_| inputs.verdict_is_current) {
            @if let Some(comparison) = &verdict.comparison { (laws(comparison, verdict.comparison_draws)) }
            h3 { "Scenarios" }
            (scenarios(verdict))
            @if let Some(file) = &verdict.controller_settings { (controller(file, verdict.controller_command.as_ref())) }
        } @else {
            p.absent { "There is no verdict on these tables: run pivot-cal verify." }
        }
    };
    Section { id: "closed-loop", title: "Closed loop", body, figures }
}

/// The settings of the controller that was judged; those that are not the default's are marked.
fn controller(file: &ControllerFile, command: Option<&ControllerCommand>) -> Markup {
    let defaults = ControllerSettings::default().sections();
    let settings = file.settings();
    let mut rows = Vec::new();
    for ((section, _, own), (_, _, usual)) in settings.sections().into_iter().zip(defaults) {
        for (own, usual) in own.into_iter().zip(usual) {
            let mark = if own.value == usual.value { String::new() } else { format!("default {}", usual.value) };
            rows.push(vec![format!("{section}.{}", own.key), own.value.to_string(), mark, own.about.to_owned()]);
        }
    }
    html! {
        h3 { "Controller" }
        @if let Some(command) = command {
            p {
                "The verdict is about " @if command.is_library() { "a library" } @else { "a process" } " of the user's, " code { (shown(&command.command)) }
                @if let Some(sha256) = &command.sha256 { " (SHA-256 " code { (sha256) } ")" }
                ", with " (command.timeout_ms)
                " ms for an answer, and not about the bundled controller. The settings are those of the plan that it was judged by."
            }
        }
        p { @if command.is_some() { "The plan is of the controller " } @else { "The verdict is about the controller " } (settings.name()) ", SHA-256 " code { (file.sha256()) } "." }
        details {
            summary { "Its " (rows.len()) " settings" }
            (table("", &[Text("setting"), Number("value"), Text("if not the default"), Text("meaning")], &rows))
        }
    }
}

fn pivot(traces: &ClosedLoop) -> Chart {
    let points = |values: &[f64]| -> Points { traces.t_s.iter().copied().zip(values.iter().copied()).collect() };
    let panel = |title: &str, of: &dyn Fn(&LawTraces) -> &Bands| {
        let mut panel = Panel { title: title.to_owned(), with_zero: true, ..Panel::default() };
        for law in &traces.laws {
            let (name, line, outer, inner) =
                if law.name == "map" { ("map", "a", "af o", "af p") } else { ("conventional", "b d", "bf o", "bf p") };
            let bands = of(law);
            panel.areas.push(Area { class: outer, lower: points(&bands.p05), upper: points(&bands.p95) });
            panel.areas.push(Area { class: inner, lower: points(&bands.p25), upper: points(&bands.p75) });
            panel.lines.push(Line { name, class: line, points: points(&bands.median) });
        }
        panel
    };
    let mut speed = panel("front-wheel speed [m/s]", &|l| &l.speed_mps);
    let target: Points = traces.t_s.iter().zip(&traces.target_speed_mps).filter_map(|(t, v)| Some((*t, (*v)?))).collect();
    speed.lines.insert(0, Line { name: "desired", class: "k", points: target });
    Chart {
        id: "pivot".to_owned(),
        label: format!("{}: map and conventional law over time", traces.what),
        x_title: "time since the gear was set [s]",
        width: 1010.0,
        panel: 130.0,
        panels: vec![
            speed,
            panel("acceleration [m/s²]", &|l| &l.accel_mps2),
            panel("effective torque [N·m]", &|l| &l.torque_nm),
            panel("heading turned [°]", &|l| &l.heading_deg),
        ],
    }
}

/// The map compared with other laws, on one scenario.
fn laws(comparison: &LawComparison, draws: usize) -> Markup {
    let metrics = [
        Metric::HeadingErrorDeg,
        Metric::SpeedRmsMps,
        Metric::StartJerkMps3,
        Metric::PeakJerkMps3,
        Metric::PeakAccelMps2,
        Metric::SettlingTimeS,
    ];
    let titles = metrics.map(|m| format!("{} {}", m.title(), m.unit()).trim().to_owned());
    let columns: Vec<TableColumn> = std::iter::once(Text("law")).chain(titles.iter().map(|title| Number(title))).collect();
    let median = |all: &[MetricSummary], metric| num_or_dash(figure(all, metric, Statistic::Median), 3);
    let rows: Vec<Vec<String>> = comparison
        .laws
        .iter()
        .map(|law| std::iter::once(law.name.clone()).chain(metrics.map(|m| median(&law.metrics, m))).collect())
        .collect();
    let ratio = |ratio: Option<f64>| ratio.map_or("none".to_owned(), |r| num(r, 2));
    html! {
        h3 { "The map compared with other laws: " (comparison.scenario) ", medians over " (draws) " perturbed plants" }
        (table("", &columns, &rows))
        p {
            "Start jerk, map over conventional law: " (ratio(comparison.start_jerk_ratio)) " (goal: at most 0.33). "
            "Speed tracking, map over perfect inverse: " (ratio(comparison.speed_rms_ratio)) " (goal: at most 1.15)."
        }
    }
}

/// Every pivot; the manoeuvres have a separate section.
fn scenarios(verdict: &MapVerdict) -> Markup {
    let columns = [
        Text("scenario"),
        Text("what"),
        Text("verdict"),
        Text("nearest limit"),
        Number("value"),
        Number("limit"),
        Number("heading error, median"),
        Number("99 %"),
        Number("settling time, median"),
    ];
    let rows: Vec<Vec<Markup>> = verdict.scenarios.iter().filter(|s| s.class.is_pivot()).map(scenario).collect();
    html! {
        @if rows.is_empty() {
            p.absent { "The verdict holds no pivot: run pivot-cal verify without --scenario." }
        } @else {
            (table("", &columns, &rows))
        }
    }
}

fn scenario(scenario: &ScenarioVerdict) -> Vec<Markup> {
    let nearest = scenario.checks.iter().max_by(|a, b| used(a).total_cmp(&used(b)));
    let of_nearest = |text: &dyn Fn(&LimitCheck) -> String| nearest.map_or("–".to_owned(), text);
    let shown = |metric, statistic| figure(&scenario.metrics, metric, statistic).map_or("–".to_owned(), |v| with_unit(metric, v));
    vec![
        html! { (scenario.name) },
        html! {
            (scenario.what)
            @if let Some(fault) = scenario.controller_fault() { ". " strong { "The controller broke: " (fault) } }
        },
        html! {
            @match scenario.status {
                Status::Pass => "pass",
                Status::Fail => strong { "FAIL" },
                Status::NotTested | Status::NotJudged => "not tested",
                Status::Rejected => "rejected",
            }
        },
        html! { (of_nearest(&|c| format!("{}, {}", c.metric.title(), c.statistic.title()))) },
        html! { (of_nearest(&|c| c.value.map_or("none".to_owned(), |v| with_unit(c.metric, v)))) },
        html! { (of_nearest(&limit)) },
        html! { (shown(Metric::HeadingErrorDeg, Statistic::Median)) },
        html! { (shown(Metric::HeadingErrorDeg, Statistic::P99)) },
        html! { (shown(Metric::SettlingTimeS, Statistic::Median)) },
    ]
}

/// Used share of a limit: 1 at the limit.
fn used(check: &LimitCheck) -> f64 {
    match (check.pass, check.value, check.at_most) {
        (false, ..) => f64::INFINITY,
        (true, Some(value), Some(limit)) if limit > 0.0 => value / limit,
        _ => 0.0,
    }
}

fn figure(all: &[MetricSummary], metric: Metric, statistic: Statistic) -> Option<f64> {
    all.iter().find(|s| s.metric == metric).and_then(|s| s.figure(statistic))
}

fn limit(check: &LimitCheck) -> String {
    match (check.at_most, check.at_least) {
        (Some(most), _) => format!("≤\u{a0}{}", with_unit(check.metric, most)),
        (_, Some(least)) => format!("≥\u{a0}{}", with_unit(check.metric, least)),
        _ => String::new(),
    }
}

fn with_unit(metric: Metric, value: f64) -> String {
    match metric.unit() {
        "" => format!("{}\u{a0}%", num(100.0 * value, 0)),
        "°" => format!("{}°", num(value, 2)),
        "m" => format!("{}\u{a0}mm", num(1e3 * value, 0)),
        unit => format!("{}\u{a0}{unit}", num(value, 2)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(metric: Metric, value: Option<f64>, at_most: f64, pass: bool) -> LimitCheck {
        LimitCheck { metric, statistic: Statistic::P99, value, at_most: Some(at_most), at_least: None, pass }
    }

    fn verdict(checks: Vec<LimitCheck>) -> ScenarioVerdict {
        let class = crate::verify::Class::Turn;
        let (name, what) = ("left-90".to_owned(), "<90°>".to_owned());
        let failed = ScenarioVerdict::not_tested(&name, &what, class, String::new());
        ScenarioVerdict { status: Status::Fail, notes: Vec::new(), checks, ..failed }
    }

    #[test]
    fn the_nearest_limit_is_the_most_used_one_and_a_broken_one_is_nearest() {
        let close = check(Metric::HeadingErrorDeg, Some(0.9), 1.0, true);
        let far = check(Metric::SettlingTimeS, Some(1.0), 4.0, true);
        let cells = |checks| scenario(&verdict(checks)).into_iter().map(maud::PreEscaped::into_string).collect::<Vec<_>>();
        let found = cells(vec![close.clone(), far]);
        assert_eq!(found[3..6], ["final heading error, 99 %", "0.90°", "≤\u{a0}1.00°"]);
        let broken = check(Metric::SettlingTimeS, None, 4.0, false);
        let found = cells(vec![close, broken]);
        assert_eq!(found[3..6], ["settling time, 99 %", "none", "≤\u{a0}4.00\u{a0}s"]);
        assert_eq!(found[1..3], ["&lt;90°&gt;", "<strong>FAIL</strong>"]);
    }

    #[test]
    fn a_scenario_without_checks_has_dashes() {
        let found = scenario(&verdict(Vec::new()));
        assert!(found[3..].iter().all(|cell| cell.0 == "–"), "{found:?}");
    }
}
