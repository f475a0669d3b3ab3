//! Rules of Autoware's, Apollo's and long-form maps.

use crate::check::grid_rules::{GridAxis, JudgedGrid, Meaning, misread};
use crate::check::point_rules::{SignRule, judge};
use crate::check::{CheckReport, CheckSettings, Map, Rule, RuleBreach, Severity};
use crate::import::foreign::{
    CellGrid, CommandPoints, CsvLine, Pedal, cells_of_csv, grid_of_autoware, points_of_apollo, points_of_long_csv,
};

impl Map<'_> {
    pub(crate) fn apollo(&self, text: &str) -> CheckReport {
        let (points, unread) = points_of_apollo(text);
        self.points("Apollo calibration table", &points, misread(&unread).collect(), SignRule::Strict)
    }

    pub(crate) fn long_form(&self, cells: &[CsvLine]) -> CheckReport {
        let (points, unread) = points_of_long_csv(cells);
        self.points("long-form CSV", &points, misread(&unread).collect(), SignRule::Physical)
    }

    fn points(&self, format: &str, points: &CommandPoints, mut findings: Vec<RuleBreach>, sign: SignRule) -> CheckReport {
        let judged = judge(points, sign, &mut findings);
        findings.push(not_ours());
        let size = format!("{} entries at {} speeds", points.points.len(), points.rows().len());
        CheckReport::new(self.path.clone(), format, size, findings, &judged)
    }

    pub(crate) fn autoware(&self, cells: &[CsvLine], settings: CheckSettings) -> CheckReport {
        let (pedal, grid, unread) = grid_of_autoware(&self.name, cells);
        let mut findings: Vec<_> = misread(&unread).collect();
        let meaning = Meaning {
            rows: "pedal",
            columns: "speed",
            along: GridAxis::Rows,
            rising: pedal == Pedal::Accel,
            plateau: Severity::Error, // the loader refuses it
        };
        let judged = JudgedGrid { grid: &grid, meaning, of: String::new(), limited: None };
        judged.axes(&mut findings);
        let places = judged.monotone(|_, _| false, &mut findings);
        judged.jumps(settings, &mut findings);
        // a map whose columns go below 0 is not over speed (Autoware's steer map has the same form)
        if grid.column_breaks.first().copied().flatten().is_some_and(|first| first < 0.0) {
            let what = "the columns are not speeds from 0 up: checked as a plain matrix, without the rules for signs";
            findings.push(RuleBreach::whole(Rule::Sign, Severity::Note, what));
        } else {
            judged.speed_from_zero(GridAxis::Columns, Severity::Note, &mut findings);
            signs(&judged, &grid, pedal, &mut findings);
        }
        if pedal == Pedal::Accel {
            self.row_shared_with_brake(&judged, &mut findings);
        }
        findings.push(not_ours());
        let (rows, columns) = grid.shape();
        let format = if pedal == Pedal::Accel { "Autoware map (accel pedal)" } else { "Autoware map (brake pedal)" };
        let judged = [(Rule::NotMonotone, places, "steps"), (Rule::Plateau, places, "steps"), (Rule::Sign, rows * columns, "cells")];
        CheckReport::new(self.path.clone(), format, format!("{rows} pedal positions × {columns} speeds"), findings, &judged)
    }
}

impl Map<'_> {
    /// The row without pedal of an accel map and of the brake map beside it: if they differ, accelerations between them belong to none or
    /// to both.
    fn row_shared_with_brake(&self, judged: &JudgedGrid, findings: &mut Vec<RuleBreach>) {
        let name = self.name.replace("accel", "brake");
        let brake = (name != self.name).then(|| (self.beside)(&name)).flatten();
        let Some(brake) = brake.and_then(|bytes| String::from_utf8(bytes).ok()) else { return };
        let (_, brake, _) = grid_of_autoware(&name, &cells_of_csv(&brake));
        let first = |grid: &CellGrid| grid.row_breaks.first().copied().flatten();
        if brake.column_breaks != judged.grid.column_breaks || first(&brake) != first(judged.grid) {
            return;
        }
        for j in 0..brake.column_breaks.len() {
            if let (Some(accel), Some(other)) = (judged.grid.at(0, j), brake.at(0, j))
                && accel != other
            {
                let what = format!("{accel} without pedal, but {other} in {name}: the first rows of the two maps differ");
                findings.push(judged.cell(Rule::RangeGap, Severity::Note, 0, j, what));
            }
        }
    }
}

/// Without pedal a wheel slows down, unless the vehicle creeps. With a pedal below 0, as some maps write the brake, it never speeds up.
fn signs(judged: &JudgedGrid, grid: &CellGrid, pedal: Pedal, findings: &mut Vec<RuleBreach>) {
    let (rows, columns) = grid.shape();
    let first = grid.row_breaks.first().copied().flatten();
    if let Some(first) = first.filter(|first| *first > 0.0) {
        let what = format!("the pedal begins at {first}: the map says nothing below it");
        findings.push(RuleBreach::at(Rule::RangeGap, Severity::Warning, format!("pedal 0 to {first}"), what));
    }
    for (i, j) in (0..rows).flat_map(|i| (0..columns).map(move |j| (i, j))) {
        let (Some(command), Some(accel)) = (grid.row_breaks[i], grid.at(i, j)) else { continue };
        if command == 0.0 && accel > 0.0 {
            let what = format!("{accel} without pedal: the vehicle creeps");
            findings.push(judged.cell(Rule::CoastPositive, Severity::Note, i, j, what));
        } else if command < 0.0 && accel > 0.0 && pedal == Pedal::Accel {
            findings.push(judged.cell(Rule::Sign, Severity::Error, i, j, format!("{accel} for a braking command of {command}")));
        }
    }
}

fn not_ours() -> RuleBreach {
    RuleBreach::whole(Rule::DeadBand, Severity::Note, "this format has neither a dead band nor a hash: not judged")
}
