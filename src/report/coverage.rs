//! Coverage: standard error and status of each cell.

use crate::map::{AccelMap, CellStatus};
use crate::report::ReportFiles;
use crate::report::heat::{Heat, Quantity};
use crate::report::html::{
    TableColumn::{Number, Text},
    table,
};
use crate::report::scale::Colours;
use crate::report::section::{Figures, Section};
use crate::report::svg::num;
use crate::report::tables::{ACCEL_ERROR, SAMPLES, SIZE, SPEED, TORQUE};
use maud::html;
use std::fmt::Write as _;

const CONFIDENCE: Quantity = Quantity { name: "confidence", unit: "", digits: 2 };
/// Largest number of characters of a line of cells in the terminal.
const MOST_COLUMNS: usize = 64;

/// Coverage as a section.
pub(crate) fn coverage(inputs: &ReportFiles) -> Section {
    let mut figures = Figures::default();
    let columns = [
        Text("gear"),
        Number("cells"),
        Number("measured"),
        Number("interpolated"),
        Number("extrapolated"),
        Number("median standard error m/s²"),
        Number("samples"),
    ];
    let rows: Vec<Vec<String>> = inputs.table1.maps.iter().map(shares).collect();
    let body = html! {
        p {
            "Confidence falls from 1 with the standard error and is one half at 0.1 m/s²; where nothing was measured nearby it is at most one \
             half. Measured cells are plain, interpolated ones dotted, extrapolated ones hatched."
        }
        div.row {
            @for map in &inputs.table1.maps { (figures.heat(&confidence(map))) }
        }
        (table("", &columns, &rows))
    };
    Section { id: "coverage", title: "Coverage and confidence", body, figures }
}

fn confidence(map: &AccelMap) -> Heat<'_> {
    Heat {
        id: format!("coverage-{}", map.gear),
        title: format!("Confidence, {} gear", map.gear),
        x: (SPEED, &map.speed_mps),
        y: (TORQUE, &map.torque_nm),
        value: (CONFIDENCE, Box::new(move |i, j| Some(map.confidence[j][i]))),
        beside: vec![
            (ACCEL_ERROR, Box::new(move |i, j| Some(map.std_err_mps2[j][i]))),
            (SAMPLES, Box::new(move |i, j| Some(map.count[j][i] as f64))),
        ],
        status: Some(Box::new(move |i, j| map.status[j][i])),
        colours: Colours::Blues,
        range: Some((0.0, 1.0)),
        legend: true,
        curve: None,
        dot: None,
        size: SIZE,
    }
}

/// A row of the table: numbers of measured, interpolated and extrapolated cells of a gear.
fn shares(map: &AccelMap) -> Vec<String> {
    let all: Vec<CellStatus> = map.status.iter().flatten().copied().collect();
    let share = |status| {
        let count = all.iter().filter(|s| **s == status).count();
        format!("{} %", num(100.0 * count as f64 / all.len().max(1) as f64, 0))
    };
    let errors: Vec<f64> = map.std_err_mps2.iter().flatten().copied().collect();
    vec![
        map.gear.to_string(),
        all.len().to_string(),
        share(CellStatus::Measured),
        share(CellStatus::Interpolated),
        share(CellStatus::Extrapolated),
        num(crate::signal::median(&errors), 3),
        map.count.iter().flatten().sum::<u64>().to_string(),
    ]
}

/// The coverage of one gear in plain characters, for a terminal: highest torque first, speed to the right; `#` measured, `+` interpolated,
/// `.` extrapolated. Wide tables are thinned out to 64 columns.
pub(crate) fn coverage_text(map: &AccelMap) -> String {
    let stride = map.speed_mps.len().div_ceil(MOST_COLUMNS).max(1);
    let mut text = format!("coverage, {} gear (# measured, + interpolated, . extrapolated)\n", map.gear);
    let rows: Vec<usize> = (0..map.torque_nm.len()).rev().collect();
    for i in rows.iter().step_by(rows.len().div_ceil(40).max(1)) {
        let cells: String = map.status[*i]
            .iter()
            .step_by(stride)
            .map(|s| match s {
                CellStatus::Measured => '#',
                CellStatus::Interpolated => '+',
                CellStatus::Extrapolated | CellStatus::Unreachable => '.',
            })
            .collect();
        let _ = writeln!(text, "{:8.1} N.m |{cells}|", map.torque_nm[*i]);
    }
    let (first, last) = (map.speed_mps[0], map.speed_mps[map.speed_mps.len() - 1]);
    let width = map.speed_mps.len().div_ceil(stride);
    let _ = write!(text, "{:13}{first:<4.1}{last:>w$.2} m/s", "", w = width.max(6) - 2);
    text
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::report::known::known;

    #[test]
    fn the_terminal_shows_one_character_per_cell_and_the_highest_torque_first() {
        let map = &mut known().0.maps[0];
        let last = map.status.len() - 1;
        map.status[last][0] = CellStatus::Extrapolated;
        map.status[last][1] = CellStatus::Interpolated;
        let text = coverage_text(map);
        let first = text.lines().nth(1).unwrap();
        assert!(first.contains("|.+#"), "{first}");
        assert!(text.is_ascii(), "plain characters only");
        assert_eq!(text.lines().count(), map.torque_nm.len().min(40) + 2);
    }
}
