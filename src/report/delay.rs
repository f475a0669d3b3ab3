//! Delay likelihood: how sure dead time and lag are, and whether another pair would do.

use crate::map::DelayEstimate;
use crate::report::Inputs;
use crate::report::chart::{Chart, Line, Panel};
use crate::report::heat::{Heat, Quantity};
use crate::report::scale::Colours;
use crate::report::section::Section;
use crate::report::svg::{escaped, num};
use crate::report::tables::SIZE;

const DEAD_TIME: Quantity = Quantity { name: "dead time", unit: "ms", digits: 1 };
const LAG: Quantity = Quantity { name: "lag", unit: "ms", digits: 1 };
const DEVIANCE: Quantity = Quantity { name: "√(−2 ln ratio)", unit: "σ", digits: 1 };
/// The joint 95 % region of two parameters: χ² with two degrees of freedom.
const JOINT_95: f64 = 5.991;
/// Deviations beyond this many standard deviations look alike [σ].
const MOST_SIGMA: f64 = 12.0;

/// The delays as a section.
pub(crate) fn delay(inputs: &Inputs) -> Section {
    let mut section = Section::new("delay", "Delay likelihood");
    let actuator = &inputs.table1.actuator;
    let told = |d: &DelayEstimate| vec![num(1e3 * d.value_s, 1), d.std_err_s.map_or("–".into(), |e| num(1e3 * e, 1)), d.status.to_string()];
    let mut rows = vec![
        [vec!["dead time, all logs".to_owned()], told(&actuator.dead_time)].concat(),
        [vec!["lag, all logs".to_owned()], told(&actuator.lag)].concat(),
    ];
    for log in &actuator.per_log {
        rows.push([vec![format!("dead time, {}", escaped(&log.file))], told(&log.dead_time)].concat());
        rows.push([vec![format!("clock offset, {}", escaped(&log.file))], told(&log.clock_offset)].concat());
    }
    section.table("narrow", &["delay|", "ms", "± ms", "status|"], &rows);
    if !actuator.input.is_plain_command() {
        section.paragraph(&format!("The fit's input is the {}.", actuator.input));
    }
    let Some(likelihood) = inputs.fit_traces.as_ref().and_then(|t| t.delay.as_ref()) else {
        section.absent("The likelihood is not here: fit_traces.json is missing or belongs to another fit.");
        return section;
    };
    let with_lag = likelihood.lag_s.len() > 1;
    section.paragraph(&format!(
        "How many standard deviations worse other delays explain the recorded speed, the surface being free to give way in its main \
         directions.{}",
        if with_lag {
            " The line bounds the joint 95 % region, the dot is the estimate. A second dark place would be a second answer."
        } else {
            " No lag is tried: the feedback holds it."
        }
    ));
    let centre_s = actuator.dead_time.value_s;
    let dead_ms: Vec<f64> = likelihood.dead_time_shift_s.iter().map(|s| rounded(1e3 * (centre_s + s))).collect();
    let lag_ms: Vec<f64> = likelihood.lag_s.iter().map(|l| rounded(1e3 * l)).collect();
    let sigma = |v: f64| v.max(0.0).sqrt();
    section.open_row();
    let rows = &likelihood.deviance;
    if dead_ms.len() > 1 && lag_ms.len() > 1 && rows.len() == lag_ms.len() && rows.iter().all(|r| r.len() == dead_ms.len()) {
        let outline = outline(&likelihood.deviance, &dead_ms, &lag_ms);
        section.heat(&Heat {
            id: "delay".to_owned(),
            title: "Dead time and lag, all logs shifted alike".to_owned(),
            x: (DEAD_TIME, &dead_ms),
            y: (LAG, &lag_ms),
            value: (DEVIANCE, Box::new(move |i, j| Some(sigma(*likelihood.deviance.get(j)?.get(i)?)))),
            beside: Vec::new(),
            status: None,
            colours: Colours::Viridis,
            range: Some((0.0, MOST_SIGMA)),
            legend: true,
            curve: (outline.len() > 2).then_some(("95 %", outline)),
            dot: Some((1e3 * centre_s, 1e3 * actuator.lag.value_s)),
            size: SIZE,
        });
    }
    let panels = likelihood
        .per_log
        .iter()
        .take(8)
        .map(|log| Panel {
            title: format!("{}: found {} ms [σ]", log.log, num(1e3 * log.found_s, 1)),
            lines: vec![Line {
                name: "",
                class: "a",
                points: log.dead_time_s.iter().zip(&log.deviance).map(|(d, v)| (1e3 * d, sigma(*v))).collect(),
            }],
            dots: vec![(1e3 * log.found_s, 0.0, "kf", 3.5)],
            with_zero: true,
            ..Panel::default()
        })
        .collect::<Vec<Panel>>();
    if !panels.is_empty() {
        let panel = if panels.len() == 1 { 300.0 } else { 110.0 };
        section.chart(&Chart {
            id: "delay-range".to_owned(),
            label: "Likelihood of the dead time over its whole range, per log".to_owned(),
            x_title: "dead time [ms]",
            width: 440.0,
            panel,
            panels,
        });
    }
    section.close_row();
    if likelihood.per_log.len() > 8 {
        section.paragraph(&format!("The first 8 of {} logs are drawn.", likelihood.per_log.len()));
    }
    section
}

fn rounded(value: f64) -> f64 {
    (value * 100.0).round() / 100.0
}

/// The 95 % region around the best pair: per direction from it the place where the deviance passes its bound.
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
