//! Residuals: the part of the recorded acceleration that the table does not explain, per cell and over time.

use crate::map::{AccelMap, ResidualCells, ResidualTimes};
use crate::report::ReportFiles;
use crate::report::chart::{Chart, Panel};
use crate::report::heat::{Heat, Quantity};
use crate::report::scale::Colours;
use crate::report::section::{Figures, Section};
use crate::report::tables::{SIZE, SPEED, TORQUE};
use maud::html;

const MEAN: Quantity = Quantity { name: "mean residual", unit: "m/s²", digits: 3 };
const RMS: Quantity = Quantity { name: "root mean square", unit: "m/s²", digits: 3 };
const WINDOWS: Quantity = Quantity { name: "windows", unit: "", digits: 0 };
/// Number of logs drawn over time.
const MOST_LOGS: usize = 8;

/// The residuals as a section.
pub(crate) fn residuals(inputs: &ReportFiles) -> Section {
    let mut figures = Figures::default();
    let maps = &inputs.table1.maps;
    let noise = &inputs.table1.noise;
    let most = (3.0 * noise.disturbance_mps2.hypot(noise.run_offset_mps2)).max(0.03);
    let body = html! {
        @if let Some(traces) = &inputs.fit_traces {
            p {
                "Recorded minus modelled acceleration over windows of 0.1 s. Neighbouring cells of one colour show a \
                 shape that the surface does not contain; a drift over time is an effect of battery, floor or temperature."
            }
            div.row {
                @for cells in &traces.residual_cells {
                    @if let Some(map) = maps.iter().find(|m| m.gear == cells.gear) { (figures.heat(&over_cells(map, cells, most))) }
                }
            }
            @if !traces.residual_times.is_empty() { (figures.chart(&over_time(&traces.residual_times))) }
            @if traces.residual_times.len() > MOST_LOGS {
                p { "The first " (MOST_LOGS) " of " (traces.residual_times.len()) " logs are drawn." }
            }
        } @else {
            p.absent { "The residuals are not here: fit_traces.json is missing or belongs to another fit." }
        }
    };
    Section { id: "residuals", title: "Residuals", body, figures }
}

/// The mean residual per cell; full colour at `most` [m/s²].
fn over_cells<'a>(map: &'a AccelMap, cells: &'a ResidualCells, most: f64) -> Heat<'a> {
    let mean = move |i: usize, j: usize| cells.mean_mps2.get(j).and_then(|r| r.get(i)).copied().flatten();
    Heat {
        id: format!("residuals-{}", cells.gear),
        title: format!("Mean residual, {} gear", cells.gear),
        x: (SPEED, &map.speed_mps),
        y: (TORQUE, &map.torque_nm),
        value: (MEAN, Box::new(mean)),
        beside: vec![
            (RMS, Box::new(move |i, j| cells.rms_mps2.get(j).and_then(|r| r.get(i)).copied().flatten())),
            (WINDOWS, Box::new(move |i, j| cells.count.get(j).and_then(|r| r.get(i)).map(|c| f64::from(*c)))),
        ],
        status: None,
        colours: Colours::Diverging,
        range: Some((-most, most)),
        legend: true,
        curve: None,
        dot: None,
        size: SIZE,
    }
}

/// The residual over time, per log.
fn over_time(logs: &[ResidualTimes]) -> Chart {
    let panel = |log: &ResidualTimes| Panel {
        title: format!("{}: residual [m/s²]", log.log),
        dots: log.t_s.iter().zip(&log.residual_mps2).map(|(t, r)| (*t, *r, "af", 1.3)).collect(),
        with_zero: true,
        ..Panel::default()
    };
    Chart {
        id: "residuals-time".to_owned(),
        label: "Residual acceleration over time, per log".to_owned(),
        x_title: "time in the log [s]",
        width: 1010.0,
        panel: 130.0,
        panels: logs.iter().take(MOST_LOGS).map(panel).collect(),
    }
}
