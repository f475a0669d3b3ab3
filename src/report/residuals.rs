//! Residuals: where and when the table does not explain the recorded acceleration.

use crate::report::Inputs;
use crate::report::chart::{Chart, Panel};
use crate::report::heat::{Heat, Quantity};
use crate::report::scale::Colours;
use crate::report::section::Section;
use crate::report::tables::{SIZE, SPEED, TORQUE};

const MEAN: Quantity = Quantity { name: "mean residual", unit: "m/s²", digits: 3 };
const RMS: Quantity = Quantity { name: "root mean square", unit: "m/s²", digits: 3 };
const WINDOWS: Quantity = Quantity { name: "windows", unit: "", digits: 0 };
/// Logs drawn over time.
const MOST_LOGS: usize = 8;

/// The residuals as a section.
pub(crate) fn residuals(inputs: &Inputs) -> Section {
    let mut section = Section::new("residuals", "Residuals");
    let Some(traces) = &inputs.fit_traces else {
        section.absent("The residuals are not here: fit_traces.json is missing or belongs to another fit.");
        return section;
    };
    section.paragraph(
        "Recorded minus modelled acceleration over windows of 0.1 s. A patch of one colour is a shape that the surface misses; a drift over \
         time is a battery, a floor or a temperature.",
    );
    let disturbance = inputs.table1.noise.disturbance_mps2.hypot(inputs.table1.noise.run_offset_mps2);
    let most = (3.0 * disturbance).max(0.03);
    section.open_row();
    for cells in &traces.residual_cells {
        let Some(map) = inputs.table1.maps.iter().find(|m| m.gear == cells.gear) else { continue };
        let mean = move |i: usize, j: usize| cells.mean_mps2.get(j).and_then(|r| r.get(i)).copied().flatten();
        section.heat(&Heat {
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
        });
    }
    section.close_row();
    let panels: Vec<Panel> = traces
        .residual_times
        .iter()
        .take(MOST_LOGS)
        .map(|log| Panel {
            title: format!("{}: residual [m/s²]", log.log),
            dots: log.t_s.iter().zip(&log.residual_mps2).map(|(t, r)| (*t, *r, "af", 1.3)).collect(),
            with_zero: true,
            ..Panel::default()
        })
        .collect();
    if !panels.is_empty() {
        let chart = Chart {
            id: "residuals-time".to_owned(),
            label: "Residual acceleration over time, per log".to_owned(),
            x_title: "time in the log [s]",
            width: 1010.0,
            panel: 130.0,
            panels,
        };
        section.chart(&chart);
    }
    if traces.residual_times.len() > MOST_LOGS {
        section.paragraph(&format!("The first {MOST_LOGS} of {} logs are drawn.", traces.residual_times.len()));
    }
    section
}
