//! The head of the page: the verdict, the three figures behind it, and what a reader should know.

use crate::map::SampleVerdict;
use crate::report::svg::{escaped, num};
use crate::report::{Inputs, Judgement};
use crate::verify::{Class, Metric, Statistic, Status, Verdict};
use std::fmt::Write as _;

/// A figure behind the verdict: what it is, the figure, what it means, and whether it is good (`None`: cannot be told).
struct Figure {
    title: &'static str,
    value: String,
    detail: String,
    good: Option<bool>,
}

/// The banner, the figures, the warnings, the facts.
pub(crate) fn summary(inputs: &Inputs) -> String {
    let (class, mark, verdict, meaning) = match inputs.judgement() {
        Judgement::Pass => ("pass", "✓", "Pass", "Table 2 keeps every limit in closed loop. It may be deployed on this vehicle."),
        Judgement::Fail => ("fail", "✕", "Fail", "Table 2 breaks a limit. It must not be deployed; what failed is listed below."),
        Judgement::NotJudged => ("open", "?", "Not judged", "No verdict covers these tables. They must not be deployed before one does."),
    };
    let mut html = format!(
        "<section id=\"verdict\"><div class=\"verdict {class}\"><span class=\"mark\" aria-hidden=\"true\">{mark}</span>\
         <div><strong>{verdict}</strong><span>{meaning}</span></div></div>\n<div class=\"figures\">\n"
    );
    for figure in [unseen_runs(inputs), round_trip(inputs), closed_loop(inputs)] {
        let (class, word) = match figure.good {
            Some(true) => ("good", "within its limit"),
            Some(false) => ("bad", "over its limit"),
            None => ("", ""),
        };
        let _ = writeln!(
            html,
            "<div class=\"figure {class}\"><h3>{}</h3><p class=\"value\">{}</p><p>{}</p><p class=\"word\">{word}</p></div>",
            figure.title, figure.value, figure.detail
        );
    }
    html.push_str("</div>\n");
    html.push_str(&warnings(inputs));
    html.push_str(&facts(inputs));
    html.push_str("</section>\n");
    html
}

fn unseen_runs(inputs: &Inputs) -> Figure {
    let held_out = &inputs.table1.report.diagnostics["held_out"];
    let (rmse, r_squared) = (held_out["rmse"].as_f64(), held_out["r_squared"].as_f64());
    let runs = inputs.table1.report.runs.iter().filter(|r| r.used_s > 0.0).count();
    Figure {
        title: "Table 1 on runs it has not seen",
        value: rmse.map_or("none".to_owned(), |v| format!("{} <small>m/s</small>", num(v, 3))),
        detail: r_squared.map_or("too few runs to hold any out".to_owned(), |r| {
            format!("error of the simulated speed, each of {runs} runs left out of its own fit; R² {}", num(r, 4))
        }),
        good: None,
    }
}

fn round_trip(inputs: &Inputs) -> Figure {
    let title = "Table 2 against Table 1";
    let current = inputs.verdict.as_ref().filter(|_| inputs.verdict_is_current);
    let worst = current.and_then(|v| {
        let used = |w: &crate::verify::Worst| w.error_mps2.abs() / w.limit_mps2;
        v.round_trip.iter().filter_map(|t| t.worst).max_by(|a, b| used(a).total_cmp(&used(b)))
    });
    let (Some(verdict), Some(worst)) = (current, worst) else {
        let largest = inputs.table2.iter().flat_map(|t| &t.maps).map(|m| m.round_trip.between_max_mps2).fold(f64::NAN, f64::max);
        let detail = "largest error of the round trip speed, acceleration → torque → acceleration".to_owned();
        let value = if largest.is_finite() { format!("{} <small>m/s²</small>", num(largest, 3)) } else { "none".to_owned() };
        return Figure { title, value, detail, good: None };
    };
    let places: usize = verdict.round_trip.iter().map(|t| t.places).sum();
    Figure {
        title,
        value: format!("{} <small>m/s²</small>", small(worst.error_mps2.abs())),
        detail: format!("worst error of the round trip over {places} places; limit {} m/s² there", num(worst.limit_mps2, 3)),
        good: Some(verdict.round_trip.iter().all(|t| t.pass)),
    }
}

/// To three decimals, and no zero where there is something.
fn small(value: f64) -> String {
    if value > 0.0 && value < 5e-4 { "&lt; 0.001".to_owned() } else { num(value, 3) }
}

/// The worst 99th percentile of the final heading error over the turns, with its limit [°].
fn worst_heading(verdict: &Verdict) -> Option<(f64, Option<f64>)> {
    let turns = verdict.scenarios.iter().filter(|s| s.class == Class::Turn && s.status != Status::NotTested);
    let values = turns.filter_map(|s| s.metrics.iter().find(|m| m.metric == Metric::HeadingErrorDeg)?.figure(Statistic::P99));
    let worst = values.max_by(f64::total_cmp)?;
    let limit = verdict
        .limits
        .iter()
        .find(|l| l.class == Class::Turn && l.metric == Metric::HeadingErrorDeg && l.statistic == Statistic::P99)
        .and_then(|l| l.at_most);
    Some((worst, limit))
}

fn closed_loop(inputs: &Inputs) -> Figure {
    let title = "The vehicle in closed loop";
    let Some(verdict) = inputs.verdict.as_ref().filter(|_| inputs.verdict_is_current) else {
        return Figure { title, value: "none".to_owned(), detail: "run pivot-cal verify".to_owned(), good: None };
    };
    let tested: Vec<_> = verdict.scenarios.iter().filter(|s| s.class.is_pivot() && s.status != Status::NotTested).collect();
    let passed = tested.iter().filter(|s| s.status == Status::Pass).count();
    if tested.is_empty() {
        return Figure { title, value: "none".to_owned(), detail: "no pivot was driven: run pivot-cal verify".to_owned(), good: None };
    }
    let heading = worst_heading(verdict).map_or(String::new(), |(worst, limit)| {
        let limit = limit.map_or(String::new(), |l| format!(", limit {}°", num(l, 1)));
        format!("; heading error {}° at the 99th percentile of the worst turn{limit}", num(worst, 2))
    });
    Figure {
        title,
        value: format!("{passed} <small>of {} scenarios</small>", tested.len()),
        detail: format!("each on the nominal plant and {} perturbed ones{heading}", verdict.draws),
        good: Some(passed == tested.len() && !tested.is_empty()),
    }
}

fn warnings(inputs: &Inputs) -> String {
    let mut all: Vec<&String> = inputs.notes.iter().collect();
    if let Some(verdict) = &inputs.verdict {
        all.extend(verdict.notes.iter().chain(&verdict.forced));
    }
    all.extend(&inputs.table1.report.notes);
    all.dedup();
    if all.is_empty() {
        return String::new();
    }
    let mut html = "<div class=\"notes\"><h3>To know before deploying</h3><ul>\n".to_owned();
    for note in all {
        let _ = writeln!(html, "<li>{}</li>", escaped(note));
    }
    html.push_str("</ul></div>\n");
    html
}

fn facts(inputs: &Inputs) -> String {
    let file = &inputs.table1;
    let report = &file.report;
    let used = report.ledger.iter().find(|r| r.verdict == SampleVerdict::Used).map_or(0.0, |r| r.seconds);
    let total: f64 = report.ledger.iter().map(|r| r.seconds).sum();
    let delay = |d: &crate::map::DelayEstimate| {
        let error = d.std_err_s.map_or(String::new(), |e| format!(" ± {}", num(1e3 * e, 1)));
        format!("{}{error} ms, {}", num(1e3 * d.value_s, 1), d.status)
    };
    let breakaway: Vec<String> = file
        .maps
        .iter()
        .map(|m| {
            let error = m.breakaway.std_err_nm.map_or(String::new(), |e| format!(" ± {}", num(e, 2)));
            format!("{} {}{error} N·m", m.gear, num(m.breakaway.torque_nm, 2))
        })
        .collect();
    let facts = [
        ("Data used", format!("{} s of {} s, {} runs", num(used, 1), num(total, 1), report.runs.iter().filter(|r| r.used_s > 0.0).count())),
        ("Coverage", format!("{} % of the cells measured", num(100.0 * report.coverage, 0))),
        ("Residual", format!("{} m/s² root mean square", num(report.residual_rms_mps2, 4))),
        ("Dead time", delay(&file.actuator.dead_time)),
        ("Lag", delay(&file.actuator.lag)),
        ("Breakaway", breakaway.join(", ")),
        ("Surface", surface(&report.diagnostics["model_choice"])),
    ];
    let mut html = "<dl class=\"facts\">".to_owned();
    for (name, value) in facts {
        let _ = write!(html, "<div><dt>{name}</dt><dd>{value}</dd></div>");
    }
    html.push_str("</dl>\n");
    html
}

/// How much of the surface runs left out asked for, beside the physics form.
fn surface(choice: &serde_json::Value) -> String {
    if choice.is_null() {
        return "physics form and all of a free surface: too few runs to leave any out".to_owned();
    }
    let (Some(share), Some(z)) = (choice["surface_share"].as_f64(), choice["in_std_errs"].as_f64()) else { return "not told".to_owned() };
    let taken = if share > 0.0 {
        format!("physics form and {} % of a free surface", num(100.0 * share, 0))
    } else {
        "physics form alone".to_owned()
    };
    let word = if z < 0.0 { "worse" } else { "better" };
    format!("{taken}; the whole surface tells runs left out {word} by {} standard errors", num(z.abs(), 1))
}
