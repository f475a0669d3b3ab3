//! Manoeuvres: each as a picture with its values; for the lateral compensation, the error before and after.

use crate::manoeuvre::{ErrorTrace, ManoeuvreTrace, ManoeuvreTraces};
use crate::report::ReportFiles;
use crate::report::chart::{Chart, Line, Panel};
use crate::report::html::TableColumn::{Number, Text};
use crate::report::html::{TableColumn, table};
use crate::report::overhead::overhead;
use crate::report::section::{Figures, Section};
use crate::report::slug::slug;
use crate::report::svg::num;
use crate::verify::{Class, LimitCheck, Metric, ScenarioVerdict, Status};
use maud::{Markup, html};

/// The manoeuvres as a section.
pub(crate) fn manoeuvres(inputs: &ReportFiles) -> Section {
    let mut figures = Figures::default();
    let body = html! {
        @if let Some(traces) = &inputs.manoeuvres {
            p {
                "Paths driven on a physical vehicle: the torque map at its wheel angle, the vehicle's exact inverse elsewhere. Pictures and \
                 first figures are the nominal run; in brackets the largest over " (traces.draws) " perturbed vehicles."
            }
            @for scene in traces.manoeuvres.iter().filter_map(|m| m.verdict.scene.as_ref()) {
                p { "Scene of the user's: " b { (scene.scene().name()) } ", SHA-256 " code { (scene.sha256()) } "." }
            }
            @if let Some(about) = traces.manoeuvres.iter().find_map(|m| m.verdict.about.as_ref()) {
                p { "A pass here proves " (about) "." }
            }
            (polylines(&mut figures, &of(Class::Polyline, traces)))
            (compensation(&mut figures, &of(Class::Compensation, traces)))
            (from_above(&mut figures, "Parking", "", &of(Class::Parking, traces)))
            (from_above(&mut figures, "U-turn", "; the field's border must not be crossed", &of(Class::UTurn, traces)))
            h3 { "Limits" }
            (limits(traces))
        } @else {
            p.absent { "No manoeuvre was driven with this Table 2: run pivot-cal verify --scenario manoeuvres, and then report again." }
        }
    };
    Section { id: "manoeuvres", title: "Manoeuvres", body, figures }
}

fn of(class: Class, traces: &ManoeuvreTraces) -> Vec<&ManoeuvreTrace> {
    traces.manoeuvres.iter().filter(|m| m.verdict.class == class).collect()
}

/// The same segments driven by every tracking law.
fn polylines(figures: &mut Figures, all: &[&ManoeuvreTrace]) -> Markup {
    if all.is_empty() {
        return html! {};
    }
    let (given, own): (Vec<&ManoeuvreTrace>, Vec<&ManoeuvreTrace>) = all.iter().partition(|trace| trace.verdict.scene.is_some());
    let metrics = [Metric::CornerErrorM, Metric::SegmentErrorM, Metric::SegmentRmsM, Metric::TimeS];
    html! {
        h3 { "Polyline with turns on the spot" }
        p { "Corners are turned on the spot about the rear axle's middle. Below: the lateral error of each tracking law while it drives." }
        @if let Some(first) = own.first() {
            (figures.svg(overhead(first, "manoeuvre-polyline", &format!("the segments, driven by {}", law(first)), 1010.0)))
        }
        @for trace in given {
            @let number = figures.pictures.len() + 1;
            @let title = format!("{}, driven by {}", trace.verdict.name, law(trace));
            (figures.svg(overhead(trace, &format!("manoeuvre-{}", slug(&trace.verdict.name, number)), &title, 1010.0)))
        }
        (figures.chart(&polyline_errors(all)))
        (results(all, &metrics))
    }
}

fn polyline_errors(all: &[&ManoeuvreTrace]) -> Chart {
    let line = |e: &ErrorTrace| Line { name: "", class: "a", points: e.t_s.iter().copied().zip(millimetres(e)).collect() };
    let panel = |trace: &&ManoeuvreTrace| Panel {
        title: match &trace.verdict.scene {
            Some(scene) => format!("{}, {}: lateral error [mm]", scene.scene().name(), law(trace)),
            None => format!("{}: lateral error [mm]", law(trace)),
        },
        lines: trace.errors.iter().map(line).collect(),
        with_zero: true,
        ..Panel::default()
    };
    Chart {
        id: "manoeuvre-polyline-errors".to_owned(),
        label: "Lateral error of each tracking law over time".to_owned(),
        x_title: "time [s]; means of 0.1 s, as the controller sees them",
        width: 1010.0,
        panel: 64.0,
        panels: all.iter().map(panel).collect(),
    }
}

/// The tracking law, from the end of the manoeuvre's description.
fn law(trace: &ManoeuvreTrace) -> &str {
    trace.verdict.what.rsplit(" tracked by ").next().unwrap_or(&trace.verdict.name)
}

fn millimetres(trace: &ErrorTrace) -> impl Iterator<Item = f64> {
    trace.error_m.iter().map(|e| 1e3 * e)
}

/// Each drive without and with the lateral table.
fn compensation(figures: &mut Figures, all: &[&ManoeuvreTrace]) -> Markup {
    if all.is_empty() {
        return html! {};
    }
    let metrics = [Metric::LateralBeforeM, Metric::LateralAfterM, Metric::LateralRatio, Metric::HeadingRateRatio];
    html! {
        h3 { "Lateral error, before and after compensation" }
        p {
            "Navigation and steering have small mounting errors. The same drive on the same noise, without compensation and with the table \
             of lateral_table.json; the error is the true one, means of 0.2 s."
        }
        (figures.chart(&compensation_errors(all)))
        (results(all, &metrics))
    }
}

fn compensation_errors(all: &[&ManoeuvreTrace]) -> Chart {
    let over = |e: &ErrorTrace, values: &[f64]| e.way_m.iter().copied().zip(values.iter().copied()).collect();
    let mut panels = Vec::new();
    for trace in all {
        let lines = trace.errors.iter().map(|e| {
            let (name, class) = if e.compensated { ("after", "a") } else { ("before", "b d") };
            Line { name, class, points: over(e, &millimetres(e).collect::<Vec<_>>()) }
        });
        let name = &trace.verdict.name;
        panels.push(Panel {
            title: format!("{name}: true lateral error [mm]"),
            lines: lines.collect(),
            with_zero: true,
            ..Panel::default()
        });
        let angles = trace.errors.iter().filter(|e| e.compensated);
        panels.push(Panel {
            title: format!("{name}: compensation in force [°]"),
            lines: angles.map(|e| Line { name: "", class: "a", points: over(e, &e.compensation_deg) }).collect(),
            with_zero: true,
            ..Panel::default()
        });
    }
    Chart {
        id: "manoeuvre-lateral".to_owned(),
        label: "Lateral error before and after compensation, and the compensation, over the distance".to_owned(),
        x_title: "distance [m]",
        width: 1010.0,
        panel: 100.0,
        panels,
    }
}

/// Manoeuvres among obstacles, two pictures side by side; `border` describes further limits.
fn from_above(figures: &mut Figures, title: &str, border: &str, all: &[&ManoeuvreTrace]) -> Markup {
    if all.is_empty() {
        return html! {};
    }
    let metrics = [Metric::FinalPositionM, Metric::HeadingErrorDeg, Metric::ClearanceM, Metric::SegmentErrorM, Metric::TimeS];
    html! {
        h3 { (title) }
        p { "Grey: what must not be touched" (border) ". The outlines are those of the planned path." }
        @for pair in all.chunks(2) {
            div.row {
                @for trace in pair {
                    @let number = figures.pictures.len() + 1;
                    (figures.svg(overhead(trace, &format!("manoeuvre-{}", slug(&trace.verdict.name, number)), &trace.verdict.name, 490.0)))
                }
            }
        }
        (results(all, &metrics))
    }
}

/// Nominal values, and the largest over the draws in brackets; the table of limits shows the smallest clearance.
fn results(all: &[&ManoeuvreTrace], metrics: &[Metric]) -> Markup {
    let unit = |m: Metric| match m.unit() {
        "m" => " mm".to_owned(),
        "" | "×" => String::new(),
        unit => format!(" {unit}"),
    };
    let titles: Vec<String> = metrics.iter().map(|m| format!("{}{}", m.title(), unit(*m))).collect();
    let columns: Vec<TableColumn> = std::iter::once(Text("manoeuvre")).chain(titles.iter().map(|title| Number(title))).collect();
    let row = |trace: &&ManoeuvreTrace| {
        let verdict = &trace.verdict;
        std::iter::once(verdict.name.clone()).chain(metrics.iter().map(|metric| result(verdict, *metric))).collect()
    };
    table("", &columns, &all.iter().map(row).collect::<Vec<Vec<String>>>())
}

fn result(verdict: &ScenarioVerdict, metric: Metric) -> String {
    let shown = |v: f64| match metric.unit() {
        "m" => num(1e3 * v, 1),
        "s" => num(v, 1),
        "°" => num(v, 2),
        _ => num(v, 3),
    };
    let found = verdict.metrics.iter().find(|s| s.metric == metric);
    let nominal = found.and_then(|s| s.nominal).map_or("–".to_owned(), shown);
    match found.and_then(|s| s.max).filter(|_| metric != Metric::ClearanceM) {
        Some(most) => format!("{nominal} ({})", shown(most)),
        None => nominal,
    }
}

/// Every limit of every manoeuvre.
fn limits(traces: &ManoeuvreTraces) -> Markup {
    let row = |trace: &ManoeuvreTrace| {
        let verdict = &trace.verdict;
        vec![html! { (verdict.name) }, html! { (verdict.what) }, passed(verdict.status == Status::Pass), kept(&verdict.checks)]
    };
    let rows: Vec<Vec<Markup>> = traces.manoeuvres.iter().map(row).collect();
    table("", &[Text("manoeuvre"), Text("what"), Text("verdict"), Text("limits")], &rows)
}

fn passed(pass: bool) -> Markup {
    html! { @if pass { "pass" } @else { strong { "FAIL" } } }
}

/// Every limit with the reached value; broken limits are highlighted.
fn kept(checks: &[LimitCheck]) -> Markup {
    html! {
        @for (k, check) in checks.iter().enumerate() {
            @if k > 0 { "; " }
            @if check.pass { (reached(check)) } @else { strong { (reached(check)) } }
        }
    }
}

fn reached(check: &LimitCheck) -> String {
    let unit = |v: f64| match check.metric.unit() {
        "" => format!("{}\u{a0}%", num(100.0 * v, 0)),
        "°" => format!("{}°", num(v, 2)),
        "m" => format!("{}\u{a0}mm", num(1e3 * v, 1)),
        unit => format!("{}\u{a0}{unit}", num(v, 3)),
    };
    let limit = match (check.at_most, check.at_least) {
        (Some(most), _) => format!("≤\u{a0}{}", unit(most)),
        (_, Some(least)) => format!("≥\u{a0}{}", unit(least)),
        _ => String::new(),
    };
    let value = check.value.map_or("none".to_owned(), unit);
    format!("{}, {}: {value} ({limit})", check.metric.title(), check.statistic.title())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::verify::{MetricSummary, Statistic};

    fn summary(metric: Metric) -> MetricSummary {
        MetricSummary { metric, nominal: Some(0.0123), mean: None, median: None, p95: None, p99: None, max: Some(0.5) }
    }

    #[test]
    fn the_largest_of_the_draws_follows_the_nominal_figure_except_where_the_smallest_counts() {
        let verdict = ScenarioVerdict {
            name: "parking".to_owned(),
            what: "parking".to_owned(),
            class: Class::Parking,
            status: Status::Pass,
            wheel_angle_deg: None,
            draws: None,
            about: None,
            scene: None,
            notes: Vec::new(),
            metrics: vec![summary(Metric::FinalPositionM), summary(Metric::ClearanceM)],
            checks: Vec::new(),
        };
        assert_eq!(result(&verdict, Metric::FinalPositionM), "12.3 (500.0)");
        assert_eq!(result(&verdict, Metric::ClearanceM), "12.3");
        assert_eq!(result(&verdict, Metric::TimeS), "–");
    }

    #[test]
    fn a_broken_limit_is_highlighted() {
        let check = |pass, value| LimitCheck {
            metric: Metric::FinalPositionM,
            statistic: Statistic::Max,
            value,
            at_most: Some(0.03),
            at_least: None,
            pass,
        };
        assert_eq!(
            kept(&[check(true, Some(0.012)), check(false, None)]).0,
            "final position error, max: 12.0\u{a0}mm (≤\u{a0}30.0\u{a0}mm); \
             <strong>final position error, max: none (≤\u{a0}30.0\u{a0}mm)</strong>"
        );
    }
}
