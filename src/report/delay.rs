//! Delay likelihood: uncertainty of dead time and lag, and other possible pairs.

use crate::map::{Actuator, DeadTimeLikelihood, DelayEstimate, DelayLikelihood, DelayStatus};
use crate::report::ReportFiles;
use crate::report::chart::{Chart, Line, Panel};
use crate::report::heat::{Heat, Quantity};
use crate::report::html::{
    TableColumn::{Number, Text},
    num_or_dash, table,
};
use crate::report::scale::Colours;
use crate::report::section::{Figures, Section};
use crate::report::svg::num;
use crate::report::tables::SIZE;
use maud::{Markup, html};

const DEAD_TIME: Quantity = Quantity { name: "dead time", unit: "ms", digits: 1 };
const LAG: Quantity = Quantity { name: "lag", unit: "ms", digits: 1 };
const DEVIANCE: Quantity = Quantity { name: "√(−2 ln ratio)", unit: "σ", digits: 1 };
/// The joint 95 % region of two parameters: χ² with two degrees of freedom.
const JOINT_95: f64 = 5.991;
/// The colours end at this many standard deviations [σ].
const MOST_SIGMA: f64 = 12.0;
/// Number of logs whose dead time is drawn.
const MOST_LOGS: usize = 8;

/// The delays as a section.
pub(crate) fn delay(inputs: &ReportFiles) -> Section {
    let mut figures = Figures::default();
    let actuator = &inputs.table1.actuator;
    let body = html! {
        (estimates(actuator))
        @if !actuator.input.is_plain_command() { p { "The fit's input is the " (actuator.input) "." } }
        @for (label, text) in actuator.drive_lines() { p { @if !label.is_empty() { (label) ": " } (text) "." } }
        @if let Some(likelihood) = inputs.fit_traces.as_ref().and_then(|t| t.delay.as_ref()) {
            p { (meaning(likelihood, actuator)) }
            div.row {
                (joint(&mut figures, likelihood, actuator))
                (whole_range(&mut figures, likelihood))
            }
            @if likelihood.per_log.len() > MOST_LOGS {
                p { "The first " (MOST_LOGS) " of " (likelihood.per_log.len()) " logs are drawn." }
            }
        } @else {
            p.absent { "The likelihood is not here: fit_traces.json is missing or belongs to another fit." }
        }
    };
    Section { id: "delay", title: "Delay likelihood", body, figures }
}

/// Every delay with its standard error.
fn estimates(actuator: &Actuator) -> Markup {
    let row = |name: String, d: &DelayEstimate| {
        vec![name, num(1e3 * d.value_s, 1), num_or_dash(d.std_err_s.map(|e| 1e3 * e), 1), d.status.to_string()]
    };
    let mut rows = vec![row("dead time, all logs".to_owned(), &actuator.dead_time), row("lag, all logs".to_owned(), &actuator.lag)];
    for log in &actuator.per_log {
        rows.push(row(format!("dead time, {}", log.file), &log.dead_time));
        rows.push(row(format!("clock offset, {}", log.file), &log.clock_offset));
    }
    table("narrow", &[Text("delay"), Number("ms"), Number("± ms"), Text("status")], &rows)
}

/// Explanation of the figures.
fn meaning(likelihood: &DelayLikelihood, actuator: &Actuator) -> Markup {
    let shows_feedback = actuator.per_log.iter().any(|log| log.clock_offset.status != DelayStatus::NotSeparable);
    html! {
        "Each place shows by how many standard deviations another pair of delays explains the recorded speed worse. The surface may adapt in its main directions."
        @if likelihood.lag_s.len() > 1 {
            " The line bounds the joint 95 % region, the dot is the estimate. A second dark place would be a second solution."
            @if shows_feedback && actuator.lag.status != DelayStatus::Given { " The dot also holds the lag that the torque feedback shows." }
        } @else {
            " No lag is varied: the feedback includes it."
        }
    }
}

/// Standard deviations of a deviance.
fn sigma(deviance: f64) -> f64 {
    deviance.max(0.0).sqrt()
}

/// Dead time and lag together, if both were varied.
fn joint(figures: &mut Figures, likelihood: &DelayLikelihood, actuator: &Actuator) -> Markup {
    let centre_s = actuator.dead_time.value_s;
    let dead_ms: Vec<f64> = likelihood.dead_time_shift_s.iter().map(|s| rounded(1e3 * (centre_s + s))).collect();
    let lag_ms: Vec<f64> = likelihood.lag_s.iter().map(|l| rounded(1e3 * l)).collect();
    let rows = &likelihood.deviance;
    let complete = rows.len() == lag_ms.len() && rows.iter().all(|r| r.len() == dead_ms.len());
    if dead_ms.len() < 2 || lag_ms.len() < 2 || !complete {
        return html! {};
    }
    let outline = outline(rows, &dead_ms, &lag_ms);
    figures.heat(&Heat {
        id: "delay".to_owned(),
        title: "Dead time and lag, all logs shifted equally".to_owned(),
        x: (DEAD_TIME, &dead_ms),
        y: (LAG, &lag_ms),
        value: (DEVIANCE, Box::new(move |i, j| Some(sigma(*rows.get(j)?.get(i)?)))),
        beside: Vec::new(),
        status: None,
        colours: Colours::Viridis,
        range: Some((0.0, MOST_SIGMA)),
        legend: true,
        curve: (outline.len() > 2).then_some(("95 %", outline)),
        dot: Some((1e3 * centre_s, 1e3 * actuator.lag.value_s)),
        size: SIZE,
    })
}

/// The dead time alone, per log.
fn whole_range(figures: &mut Figures, likelihood: &DelayLikelihood) -> Markup {
    let panel = |log: &DeadTimeLikelihood| Panel {
        title: format!("{}: found {} ms [σ]", log.log, num(1e3 * log.found_s, 1)),
        lines: vec![Line {
            name: "",
            class: "a",
            points: log.dead_time_s.iter().zip(&log.deviance).map(|(d, v)| (1e3 * d, sigma(*v))).collect(),
        }],
        dots: vec![(1e3 * log.found_s, 0.0, "kf", 3.5)],
        with_zero: true,
        ..Panel::default()
    };
    let panels: Vec<Panel> = likelihood.per_log.iter().take(MOST_LOGS).map(panel).collect();
    if panels.is_empty() {
        return html! {};
    }
    figures.chart(&Chart {
        id: "delay-range".to_owned(),
        label: "Likelihood of the dead time over its whole range, per log".to_owned(),
        x_title: "dead time [ms]",
        width: 440.0,
        panel: if panels.len() == 1 { 300.0 } else { 110.0 },
        panels,
    })
}

fn rounded(value: f64) -> f64 {
    (value * 100.0).round() / 100.0
}

/// The 95 % region around the best pair: in each direction the place where the deviance exceeds its bound.
fn outline(deviance: &[Vec<f64>], x: &[f64], y: &[f64]) -> Vec<(f64, f64)> {
    let at = |px: f64, py: f64| crate::map::lookup::bilinear(y, x, &deviance.concat(), py, px);
    let mut best = (f64::INFINITY, 0, 0);
    for (j, row) in deviance.iter().enumerate() {
        for (i, v) in row.iter().enumerate() {
            if *v < best.0 {
                best = (*v, i, j);
            }
        }
    }
    let (Some(cx), Some(cy)) = (x.get(best.1), y.get(best.2)) else { return Vec::new() };
    let reach = (x[x.len() - 1] - x[0]).max(y[y.len() - 1] - y[0]);
    let mut points = Vec::new();
    for k in 0..=72 {
        let angle = f64::from(k) * std::f64::consts::TAU / 72.0;
        let along = |r: f64| (cx + r * angle.cos(), cy + r * angle.sin());
        let crossing = (1..=400).map(|s| f64::from(s) / 400.0 * reach).find(|r| {
            let (px, py) = along(*r);
            at(px, py).is_some_and(|v| v >= JOINT_95)
        });
        points.extend(crossing.map(along));
    }
    points
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_region_of_a_parabola_is_an_ellipse_around_its_lowest_point() {
        // σ of 2 ms along x and of 4 ms along y, lowest at (30, 50)
        let x: Vec<f64> = (0..=60).map(f64::from).collect();
        let y: Vec<f64> = (0..=100).map(f64::from).collect();
        let squared = |v: f64, centre: f64, sigma: f64| ((v - centre) / sigma).powi(2);
        let deviance: Vec<Vec<f64>> =
            y.iter().map(|y| x.iter().map(|x| squared(*x, 30.0, 2.0) + squared(*y, 50.0, 4.0)).collect()).collect();
        let found = outline(&deviance, &x, &y);
        assert_eq!(found.len(), 73, "one place in every direction");
        let radius = JOINT_95.sqrt();
        for (px, py) in found {
            let apart = ((px - 30.0) / 2.0).hypot((py - 50.0) / 4.0);
            // the step along a direction is 0.25 ms, at most 0.125 σ; the interpolation between nodes adds at most a quarter of (1/2)² + (1/4)²
            assert!((apart - radius).abs() < 0.15, "({px}, {py})");
        }
    }

    #[test]
    fn a_region_that_leaves_the_range_is_open_there() {
        let x: Vec<f64> = (0..=60).map(f64::from).collect();
        let deviance: Vec<Vec<f64>> = (0..=4).map(|_| x.iter().map(|x| ((x - 30.0) / 2.0).powi(2)).collect()).collect();
        let found = outline(&deviance, &x, &[0.0, 1.0, 2.0, 3.0, 4.0]);
        assert!(!found.is_empty() && found.len() < 73, "{}", found.len());
        assert!(outline(&[], &[0.0, 1.0], &[0.0, 1.0]).is_empty());
    }
}
