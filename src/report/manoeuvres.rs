//! Manoeuvres: each as a picture with its figures; of the lateral compensation the error before and after.

use crate::manoeuvre::{ErrorTrace, ManoeuvreTrace, ManoeuvreTraces};
use crate::report::Inputs;
use crate::report::chart::{Chart, Line, Panel};
use crate::report::overhead::overhead;
use crate::report::section::Section;
use crate::report::svg::{escaped, num};
use crate::verify::{Class, LimitCheck, Metric, Status};

/// The manoeuvres as a section.
pub(crate) fn manoeuvres(inputs: &Inputs) -> Section {
    let mut section = Section::new("manoeuvres", "Manoeuvres");
    let Some(traces) = &inputs.manoeuvres else {
        section.absent("No manoeuvre was driven with this Table 2: run pivot-cal verify --scenario manoeuvres, and then report again.");
        return section;
    };
    section.paragraph(&format!(
        "Paths driven on a physical vehicle: the torque map at its wheel angle, the vehicle's exact inverse elsewhere. Pictures and first figures are \
         the nominal run; in brackets the largest over {} perturbed vehicles.",
        traces.draws
    ));
    let of = |class: Class| traces.manoeuvres.iter().filter(move |m| m.verdict.class == class);
    let polylines: Vec<&ManoeuvreTrace> = of(Class::Polyline).collect();
    if let Some(first) = polylines.first() {
        polyline(&mut section, first, &polylines);
    }
    let compensated: Vec<&ManoeuvreTrace> = of(Class::Compensation).collect();
    if !compensated.is_empty() {
        compensation(&mut section, &compensated);
    }
    for (class, title, text) in [
        (Class::Parking, "Parking", "Grey: what must not be touched. The outlines are those of the planned path."),
        (
            Class::UTurn,
            "U-turn",
            "Grey: what must not be touched; the field's border must not be crossed. The outlines are those of the planned path.",
        ),
    ] {
        let all: Vec<&ManoeuvreTrace> = of(class).collect();
        if all.is_empty() {
            continue;
        }
        section.heading(title);
        section.paragraph(text);
        for pair in all.chunks(2) {
            section.open_row();
            for trace in pair {
                section.svg(overhead(trace, &format!("manoeuvre-{}", trace.verdict.name), &trace.verdict.name, 490.0));
            }
            section.close_row();
        }
        let metrics = [Metric::FinalPositionM, Metric::HeadingErrorDeg, Metric::ClearanceM, Metric::SegmentErrorM, Metric::TimeS];
        figures(&mut section, &all, &metrics);
    }
    table(&mut section, traces);
    section
}

fn polyline(section: &mut Section, first: &ManoeuvreTrace, all: &[&ManoeuvreTrace]) {
    section.heading("Polyline with turns on the spot");
    section.paragraph(
        "Corners are turned on the spot about the rear axle's middle. Below: the lateral error of each tracking law while it drives.",
    );
    section.svg(overhead(first, "manoeuvre-polyline", &format!("the segments, driven by {}", law(first)), 1010.0));
    let panel = |trace: &&ManoeuvreTrace| Panel {
        title: format!("{}: lateral error [mm]", law(trace)),
        lines: trace
            .errors
            .iter()
            .map(|e| Line { name: "", class: "a", points: e.t_s.iter().copied().zip(millimetres(e)).collect() })
            .collect(),
        with_zero: true,
        ..Panel::default()
    };
    section.chart(&Chart {
        id: "manoeuvre-polyline-errors".to_owned(),
        label: "Lateral error of each tracking law over time".to_owned(),
        x_title: "time [s]; means of 0.1 s, as the controller sees them",
        width: 1010.0,
        panel: 64.0,
        panels: all.iter().map(panel).collect(),
    });
    figures(section, all, &[Metric::CornerErrorM, Metric::SegmentErrorM, Metric::SegmentRmsM, Metric::TimeS]);
}

/// The tracking law, as the manoeuvre's description ends with it.
fn law(trace: &ManoeuvreTrace) -> &str {
    trace.verdict.what.rsplit(" tracked by ").next().unwrap_or(&trace.verdict.name)
}

fn millimetres(trace: &ErrorTrace) -> impl Iterator<Item = f64> {
    trace.error_m.iter().map(|e| 1e3 * e)
}

fn compensation(section: &mut Section, all: &[&ManoeuvreTrace]) {
    section.heading("Lateral error, before and after compensation");
    section.paragraph(
        "Navigation and steering are mounted a little off. The same drive on the same noise, without compensation and with the table of lateral_table.json; \
         the error is the true one, means of 0.2 s.",
    );
    let mut panels = Vec::new();
    for trace in all {
        let over = |e: &ErrorTrace, values: &[f64]| e.way_m.iter().copied().zip(values.iter().copied()).collect();
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
    section.chart(&Chart {
        id: "manoeuvre-lateral".to_owned(),
        label: "Lateral error before and after compensation, and the compensation, over the way".to_owned(),
        x_title: "way [m]",
        width: 1010.0,
        panel: 100.0,
        panels,
    });
    figures(section, all, &[Metric::LateralBeforeM, Metric::LateralAfterM, Metric::LateralRatio, Metric::HeadingRateRatio]);
}

/// Nominal figures, and the largest over the draws in brackets; of a clearance the smallest counts, which the gate's table tells.
fn figures(section: &mut Section, all: &[&ManoeuvreTrace], metrics: &[Metric]) {
    let unit = |m: Metric| match m.unit() {
        "m" => " mm".to_owned(),
        "" | "×" => String::new(),
        unit => format!(" {unit}"),
    };
    let header: Vec<String> =
        std::iter::once("manoeuvre|".to_owned()).chain(metrics.iter().map(|m| format!("{}{}", m.title(), unit(*m)))).collect();
    let header: Vec<&str> = header.iter().map(String::as_str).collect();
    let rows: Vec<Vec<String>> = all
        .iter()
        .map(|trace| {
            let cell = |metric: &Metric| {
                let shown = |v: f64| match metric.unit() {
                    "m" => num(1e3 * v, 1),
                    "s" => num(v, 1),
                    "°" => num(v, 2),
                    _ => num(v, 3),
                };
                let found = trace.verdict.metrics.iter().find(|s| s.metric == *metric);
                let nominal = found.and_then(|s| s.nominal).map_or("–".to_owned(), shown);
                match found.and_then(|s| s.max).filter(|_| *metric != Metric::ClearanceM) {
                    Some(most) => format!("{nominal} ({})", shown(most)),
                    None => nominal,
                }
            };
            std::iter::once(escaped(&trace.verdict.name)).chain(metrics.iter().map(cell)).collect()
        })
        .collect();
    section.table("", &header, &rows);
}

/// Every limit of every manoeuvre.
fn table(section: &mut Section, traces: &ManoeuvreTraces) {
    section.heading("Limits");
    let unit = |m: Metric, v: f64| match m.unit() {
        "" => format!("{}\u{a0}%", num(100.0 * v, 0)),
        "°" => format!("{}°", num(v, 2)),
        "m" => format!("{}\u{a0}mm", num(1e3 * v, 1)),
        unit => format!("{}\u{a0}{unit}", num(v, 3)),
    };
    let limit = |c: &LimitCheck| match (c.at_most, c.at_least) {
        (Some(most), _) => format!("≤\u{a0}{}", unit(c.metric, most)),
        (_, Some(least)) => format!("≥\u{a0}{}", unit(c.metric, least)),
        _ => String::new(),
    };
    let rows: Vec<Vec<String>> = traces
        .manoeuvres
        .iter()
        .map(|trace| {
            let verdict = &trace.verdict;
            let status = if verdict.status == Status::Pass { "pass" } else { "<strong>FAIL</strong>" };
            let kept: Vec<String> = verdict
                .checks
                .iter()
                .map(|c| {
                    let value = c.value.map_or("none".to_owned(), |v| unit(c.metric, v));
                    let (open, close) = if c.pass { ("", "") } else { ("<strong>", "</strong>") };
                    format!("{open}{}, {}: {value} ({}){close}", c.metric.title(), c.statistic.title(), limit(c))
                })
                .collect();
            vec![escaped(&verdict.name), escaped(&verdict.what), status.to_owned(), kept.join("; ")]
        })
        .collect();
    section.table("", &["manoeuvre|", "what|", "verdict|", "limits|"], &rows);
}
