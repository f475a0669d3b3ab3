//! Closed loop: the pivot over time by the map and by the conventional law, the laws compared, and every scenario.

use crate::report::Inputs;
use crate::report::chart::{Area, Chart, Line, Panel, Points};
use crate::report::section::Section;
use crate::report::svg::{escaped, num};
use crate::verify::{Bands, ClosedLoop, LawTraces, LimitCheck, MapVerdict, Metric, MetricSummary, ScenarioVerdict, Statistic, Status};

/// The closed loop as a section.
pub(crate) fn closed_loop(inputs: &Inputs) -> Section {
    let mut section = Section::new("closed-loop", "Closed loop");
    match &inputs.closed_loop {
        Some(traces) => pivot(&mut section, traces),
        None => section.absent("The traces of the pivot are not here: verify_traces.json is missing or belongs to another Table 2."),
    }
    let Some(verdict) = inputs.verdict.as_ref().filter(|_| inputs.verdict_is_current) else {
        section.absent("There is no verdict on these tables: run pivot-cal verify.");
        return section;
    };
    compare(&mut section, verdict);
    section.heading("Scenarios");
    // manoeuvres have a section of their own
    let rows: Vec<Vec<String>> = verdict.scenarios.iter().filter(|s| s.class.is_pivot()).map(scenario).collect();
    if rows.is_empty() {
        section.absent("The verdict holds no pivot: run pivot-cal verify without --scenario.");
        return section;
    }
    let header =
        ["scenario|", "what|", "verdict|", "nearest limit|", "value", "limit", "heading error, median", "99 %", "settling time, median"];
    section.table("", &header, &rows);
    section
}

fn pivot(section: &mut Section, traces: &ClosedLoop) {
    section.paragraph(&format!(
        "{}, from the gear being set, driven by the map and by the conventional law (heading PID, tuned for this vehicle) on the plant that \
         Table 1 identified. Lines are medians over {} perturbed plants, the inner bands hold half of them, the outer ones 90 %.",
        traces.what, traces.draws
    ));
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
    speed.lines.insert(0, Line { name: "asked for", class: "k", points: target });
    section.chart(&Chart {
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
    });
}

fn compare(section: &mut Section, verdict: &MapVerdict) {
    let Some(comparison) = &verdict.comparison else { return };
    let metrics = [
        Metric::HeadingErrorDeg,
        Metric::SpeedRmsMps,
        Metric::StartJerkMps3,
        Metric::PeakJerkMps3,
        Metric::PeakAccelMps2,
        Metric::SettlingTimeS,
    ];
    let header: Vec<String> =
        std::iter::once("law|".to_owned()).chain(metrics.map(|m| format!("{} {}", m.title(), m.unit()).trim().to_owned())).collect();
    let header: Vec<&str> = header.iter().map(String::as_str).collect();
    let median = |all: &[MetricSummary], metric| {
        let value = all.iter().find(|s| s.metric == metric).and_then(|s| s.figure(Statistic::Median));
        value.map_or("–".to_owned(), |v| num(v, 3))
    };
    let rows: Vec<Vec<String>> = comparison
        .laws
        .iter()
        .map(|law| std::iter::once(escaped(&law.name)).chain(metrics.map(|m| median(&law.metrics, m))).collect())
        .collect();
    section.heading(&format!(
        "The map beside other laws: {}, medians over {} perturbed plants",
        comparison.scenario, verdict.comparison_draws
    ));
    section.table("", &header, &rows);
    let told = |ratio: Option<f64>| ratio.map_or("none".to_owned(), |r| num(r, 2));
    section.paragraph(&format!(
        "Start jerk, map over conventional law: {} (goal: at most 0.33). Speed tracking, map over perfect inverse: {} (goal: at most 1.15).",
        told(comparison.start_jerk_ratio),
        told(comparison.speed_rms_ratio)
    ));
}

/// How much of a limit is used up: 1 at the limit.
fn used(check: &LimitCheck) -> f64 {
    match (check.pass, check.value, check.at_most) {
        (false, ..) => f64::INFINITY,
        (true, Some(value), Some(limit)) if limit > 0.0 => value / limit,
        _ => 0.0,
    }
}

fn scenario(scenario: &ScenarioVerdict) -> Vec<String> {
    let status = match scenario.status {
        Status::Pass => "pass",
        Status::Fail => "<strong>FAIL</strong>",
        Status::NotTested => "not tested",
    };
    let nearest = scenario.checks.iter().max_by(|a, b| used(a).total_cmp(&used(b)));
    let unit = |m: Metric, v: f64| match m.unit() {
        "" => format!("{}\u{a0}%", num(100.0 * v, 0)),
        "°" => format!("{}°", num(v, 2)),
        "m" => format!("{}\u{a0}mm", num(1e3 * v, 0)),
        unit => format!("{}\u{a0}{unit}", num(v, 2)),
    };
    let figure = |metric: Metric, statistic| {
        let value = scenario.metrics.iter().find(|s| s.metric == metric).and_then(|s| s.figure(statistic));
        value.map_or("–".to_owned(), |v| unit(metric, v))
    };
    let told = |f: &dyn Fn(&LimitCheck) -> String| nearest.map_or("–".to_owned(), f);
    vec![
        escaped(&scenario.name),
        escaped(&scenario.what),
        status.to_owned(),
        told(&|c| format!("{}, {}", c.metric.title(), c.statistic.title())),
        told(&|c| c.value.map_or("none".to_owned(), |v| unit(c.metric, v))),
        told(&|c| match (c.at_most, c.at_least) {
            (Some(most), _) => format!("≤\u{a0}{}", unit(c.metric, most)),
            (_, Some(least)) => format!("≥\u{a0}{}", unit(c.metric, least)),
            _ => String::new(),
        }),
        figure(Metric::HeadingErrorDeg, Statistic::Median),
        figure(Metric::HeadingErrorDeg, Statistic::P99),
        figure(Metric::SettlingTimeS, Statistic::Median),
    ]
}
