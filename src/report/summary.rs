//! The head of the page: the verdict, its three main figures, and warnings.

use crate::map::{AccelMap, Check, CheckOutcome, DelayEstimate, SampleVerdict};
use crate::report::ReportFiles;
use crate::report::html::TableColumn::{Number, Text};
use crate::report::html::table;
use crate::report::svg::num;
use crate::verify::{Class, MapVerdict, Metric, Statistic, Status, Worst};
use maud::{Markup, html};

/// A figure of the verdict: name, value, meaning, and whether it is within its limit (`None`: it has none here).
struct Figure {
    title: &'static str,
    value: Markup,
    detail: String,
    good: Option<bool>,
}

impl Figure {
    fn absent(title: &'static str, detail: &str) -> Self {
        Self { title, value: html! { "none" }, detail: detail.to_owned(), good: None }
    }
}

/// The banner, the figures, the warnings, the facts.
pub(crate) fn summary(inputs: &ReportFiles) -> Markup {
    html! {
        section id="verdict" {
            (banner(inputs))
            div.figures {
                @for figure in [unseen_runs(inputs), round_trip(inputs), closed_loop(inputs)] { (card(&figure)) }
            }
            (checks(inputs))
            (warnings(inputs))
            (facts(inputs))
        }
    }
}

fn banner(inputs: &ReportFiles) -> Markup {
    let (status, cause) = inputs.judgement();
    let (class, mark, verdict, meaning) = match status {
        Status::Pass => ("pass", "✓", "Pass", "Table 2 keeps every limit in closed loop. It may be deployed on this vehicle."),
        Status::Fail => ("fail", "✕", "Fail", "Table 2 breaks a limit. It must not be deployed; what failed is listed below."),
        Status::Rejected => ("fail", "✕", "Rejected", "The campaign or its fit is not sound. These tables must not be deployed."),
        Status::NotJudged | Status::NotTested => {
            ("open", "?", "Not judged", "These tables were not judged. They must not be deployed before they are.")
        }
    };
    html! {
        div class={ "verdict " (class) } {
            span.mark aria-hidden="true" { (mark) }
            div { strong { (verdict) } span.cause { (cause) } br; span { (meaning) } }
        }
    }
}

/// The checks: those that are not passed first, as sentences, then all of them as a table.
fn checks(inputs: &ReportFiles) -> Markup {
    let accepted = inputs.verdict.as_ref().filter(|_| inputs.verdict_is_current).map_or(&[][..], |v| &v.accepted);
    let word = |check: &Check| match check.outcome {
        CheckOutcome::Passed => "passed",
        CheckOutcome::Warning => "warning",
        CheckOutcome::Objection if accepted.contains(&check.name) => "objection, overruled by hand",
        CheckOutcome::Objection => "objection",
    };
    let mut broken: Vec<&Check> = inputs.checks.iter().filter(|c| c.outcome != CheckOutcome::Passed).collect();
    broken.sort_by_key(|c| std::cmp::Reverse(c.outcome));
    let number = |value: f64| num(value, if value.abs() < 1.0 { 3 } else { 1 });
    let row = |check: &Check| {
        let outcome = word(check).to_owned();
        vec![check.name.clone(), outcome, number(check.figure), number(check.limit), check.unit.clone(), check.meaning.clone()]
    };
    let columns = [Text("check"), Text("outcome"), Number("figure"), Number("limit"), Text("unit"), Text("meaning")];
    html! {
        @if !broken.is_empty() {
            div.notes {
                h3 { "Checks that are not passed" }
                ul { @for check in broken { li { strong { (word(check)) " " (check.name) } ": " (check.text()) } } }
            }
        }
        @if !inputs.checks.is_empty() {
            details {
                summary { "All " (inputs.checks.len()) " checks on the campaign and the fit" }
                (table("", &columns, &inputs.checks.iter().map(row).collect::<Vec<_>>()))
            }
        }
    }
}

fn card(figure: &Figure) -> Markup {
    let (class, word) = match figure.good {
        Some(true) => ("good", "within its limit"),
        Some(false) => ("bad", "over its limit"),
        None => ("", ""),
    };
    html! {
        div class={ "figure " (class) } {
            h3 { (figure.title) }
            p.value { (figure.value) }
            p { (figure.detail) }
            p.word { (word) }
        }
    }
}

/// A number with a small unit behind it.
fn value(number: &str, unit: &str) -> Markup {
    html! { (number) " " small { (unit) } }
}

fn unseen_runs(inputs: &ReportFiles) -> Figure {
    let held_out = &inputs.table1.report.diagnostics["held_out"];
    let (rmse, r_squared) = (held_out["rmse"].as_f64(), held_out["r_squared"].as_f64());
    let runs = inputs.table1.report.used_runs();
    Figure {
        title: "Table 1 on runs that it was not fitted to",
        value: rmse.map_or_else(|| html! { "none" }, |v| value(&num(v, 3), "m/s")),
        detail: r_squared.map_or("too few runs to hold any out".to_owned(), |r| {
            format!("error of the simulated speed, each of {runs} runs left out of its own fit; R² {}", num(r, 4))
        }),
        good: None,
    }
}

fn round_trip(inputs: &ReportFiles) -> Figure {
    let title = "Table 2 against Table 1";
    let current = inputs.verdict.as_ref().filter(|_| inputs.verdict_is_current);
    let worst = current.and_then(|v| {
        let used = |w: &Worst| w.error_mps2.abs() / w.limit_mps2;
        v.round_trip.iter().filter_map(|t| t.worst).max_by(|a, b| used(a).total_cmp(&used(b)))
    });
    let (Some(verdict), Some(worst)) = (current, worst) else {
        let largest = inputs.table2.iter().flat_map(|t| &t.maps).map(|m| m.round_trip.between_max_mps2).fold(f64::NAN, f64::max);
        let absent = Figure::absent(title, "largest error of the round trip speed, acceleration → torque → acceleration");
        return if largest.is_finite() { Figure { value: value(&num(largest, 3), "m/s²"), ..absent } } else { absent };
    };
    let places: usize = verdict.round_trip.iter().map(|t| t.places).sum();
    Figure {
        title,
        value: value(&small(worst.error_mps2.abs()), "m/s²"),
        detail: format!("worst error of the round trip over {places} places; limit {} m/s² there", num(worst.limit_mps2, 3)),
        good: Some(verdict.round_trip.iter().all(|t| t.pass)),
    }
}

/// To three decimals; a small value is not shown as zero.
fn small(value: f64) -> String {
    if value > 0.0 && value < 5e-4 { "< 0.001".to_owned() } else { num(value, 3) }
}

/// The worst 99th percentile of the final heading error over the turns, with its limit [°].
fn worst_heading(verdict: &MapVerdict) -> Option<(f64, Option<f64>)> {
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

fn closed_loop(inputs: &ReportFiles) -> Figure {
    let title = "The vehicle in closed loop";
    let Some(verdict) = inputs.verdict.as_ref().filter(|_| inputs.verdict_is_current) else {
        return Figure::absent(title, "run pivot-cal verify");
    };
    let tested: Vec<_> = verdict.scenarios.iter().filter(|s| s.class.is_pivot() && s.status != Status::NotTested).collect();
    let passed = tested.iter().filter(|s| s.status == Status::Pass).count();
    if tested.is_empty() {
        return Figure::absent(title, "no pivot was driven: run pivot-cal verify");
    }
    let heading = worst_heading(verdict).map_or(String::new(), |(worst, limit)| {
        let limit = limit.map_or(String::new(), |l| format!(", limit {}°", num(l, 1)));
        format!("; heading error {}° at the 99th percentile of the worst turn{limit}", num(worst, 2))
    });
    Figure {
        title,
        value: value(&passed.to_string(), &format!("of {} scenarios", tested.len())),
        detail: format!("each on the nominal plant and {} perturbed ones{heading}", verdict.draws),
        good: Some(passed == tested.len()),
    }
}

fn warnings(inputs: &ReportFiles) -> Markup {
    let mut all: Vec<&String> = inputs.notes.iter().collect();
    if let Some(verdict) = &inputs.verdict {
        all.extend(verdict.notes.iter().chain(&verdict.forced));
    }
    all.extend(&inputs.table1.report.notes);
    all.dedup();
    // an objection is among the checks
    all.retain(|note| inputs.checks.iter().all(|check| check.text() != **note));
    html! {
        @if !all.is_empty() {
            div.notes {
                h3 { "Notes before deployment" }
                ul {
                    @for note in all { li { (note) } }
                }
            }
        }
    }
}

fn facts(inputs: &ReportFiles) -> Markup {
    let file = &inputs.table1;
    let report = &file.report;
    let used = report.ledger.iter().find(|r| r.verdict == SampleVerdict::Used).map_or(0.0, |r| r.seconds);
    let total: f64 = report.ledger.iter().map(|r| r.seconds).sum();
    let runs = report.used_runs();
    let facts = [
        ("Data used", format!("{} s of {} s, {runs} runs", num(used, 1), num(total, 1))),
        ("Coverage", format!("{} % of the cells measured", num(100.0 * report.coverage, 0))),
        ("Residual", format!("{} m/s² root mean square", num(report.residual_rms_mps2, 4))),
        ("Dead time", delay(&file.actuator.dead_time)),
        ("Lag", delay(&file.actuator.lag)),
        ("Breakaway", file.maps.iter().map(breakaway).collect::<Vec<String>>().join(", ")),
        ("Surface", surface(&report.diagnostics["model_choice"])),
    ];
    html! {
        dl.facts {
            @for (name, value) in facts { div { dt { (name) } dd { (value) } } }
        }
    }
}

fn delay(delay: &DelayEstimate) -> String {
    let error = delay.std_err_s.map_or(String::new(), |e| format!(" ± {}", num(1e3 * e, 1)));
    format!("{}{error} ms, {}", num(1e3 * delay.value_s, 1), delay.status)
}

fn breakaway(map: &AccelMap) -> String {
    let error = map.breakaway.std_err_nm.map_or(String::new(), |e| format!(" ± {}", num(e, 2)));
    format!("{} {}{error} N·m", map.gear, num(map.breakaway.torque_nm, 2))
}

/// Share of the free surface, beside the physics form, that left-out runs supported.
fn surface(choice: &serde_json::Value) -> String {
    if choice.is_null() {
        return "physics form alone: too few runs to leave any out".to_owned();
    }
    let (Some(share), Some(z)) = (choice["surface_share"].as_f64(), choice["in_std_errs"].as_f64()) else {
        return "not reported".to_owned();
    };
    let taken = if share > 0.0 {
        format!("physics form and {} % of a free surface", num(100.0 * share, 0))
    } else {
        "physics form alone".to_owned()
    };
    let word = if z < 0.0 { "worse" } else { "better" };
    format!("{taken}; the whole surface predicts runs left out {word} by {} standard errors", num(z.abs(), 1))
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn a_small_error_is_not_shown_as_zero_and_its_sign_is_escaped() {
        assert_eq!(value(&small(0.0004), "m/s²").0, "&lt; 0.001 <small>m/s²</small>");
        assert_eq!(small(0.0), "0.000");
        assert_eq!(small(0.0126), "0.013");
    }

    #[test]
    fn the_share_of_the_surface_depends_on_the_left_out_runs() {
        let words = |share: f64, z: f64| surface(&json!({ "surface_share": share, "in_std_errs": z }));
        assert!(
            words(0.0, -2.0).starts_with("physics form alone; ") && words(0.0, -2.0).contains(" worse by 2.0 "),
            "{}",
            words(0.0, -2.0)
        );
        assert!(words(0.25, 3.0).starts_with("physics form and 25 % of a free surface; ") && words(0.25, 3.0).contains(" better by 3.0 "));
        assert!(surface(&json!(null)).contains("too few runs"));
    }
}
