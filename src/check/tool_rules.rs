//! Rules of the tables in DCM, CDFX, C and Rust files: those of our own Table 2, on what the file holds.
//!
//! Where a file has its torques in % of a torque that it does not say, or its speeds in turns of a wheel, the numbers are judged as they are: no
//! rule depends on a unit.

use crate::check::grid_rules::JudgedGrid;
use crate::check::own::{OwnTable, extremes, judge};
use crate::check::{CheckReport, CheckSettings, Map, Rule, RuleBreach, Severity};
use crate::import::foreign::CellGrid;
use crate::import::{FullScale, ImportedTable, MapFormat, source_tables};

/// Units that leave numbers as they are.
const AS_WRITTEN: FullScale = FullScale { torque_nm: Some(100.0), wheel_radius_m: 1.0 };

impl Map<'_> {
    pub(crate) fn tool_file(&self, format: MapFormat, text: &str, settings: CheckSettings) -> CheckReport {
        let name = format!("Table 2 ({})", format.name());
        let tables = match source_tables(format, text, AS_WRITTEN) {
            Ok(tables) => tables,
            Err(fault) => {
                let line = (fault.line > 0).then_some(fault.line);
                let finding = RuleBreach::whole(Rule::Readable, Severity::Error, fault.what).on(line, 0);
                return CheckReport::new(self.path.clone(), &name, String::new(), vec![finding], &[]);
            }
        };
        let (mut findings, mut places, mut sizes) = (Vec::new(), Vec::<(Rule, usize, &'static str)>::new(), Vec::new());
        for table in &tables {
            let grid = grid_of(table);
            let (rows, columns) = grid.shape();
            sizes.push(format!("{} {rows} × {columns}", table.gear));
            if rows < 2 || columns < 2 {
                let what = format!("{rows} × {columns} cells; interpolation needs at least 2 × 2");
                findings.push(RuleBreach::at(Rule::Size, Severity::Error, format!("{} gear", table.gear), what));
            }
            let limited = Some(extremes(&grid));
            let judged = JudgedGrid { grid: &grid, meaning: OwnTable::Two.meaning(), of: format!("{} gear, ", table.gear), limited };
            for (rule, count, unit) in judge(OwnTable::Two, &judged, settings, &mut findings) {
                match places.iter_mut().find(|place| place.0 == rule) {
                    Some(place) => place.1 += count,
                    None => places.push((rule, count, unit)),
                }
            }
        }
        findings.push(RuleBreach::whole(Rule::DeadBand, Severity::Note, "dead band and hash are not judged in this format"));
        CheckReport::new(self.path.clone(), &name, format!("{} (speed × acceleration)", sizes.join(", ")), findings, &places)
    }
}

/// The matrix in the order of the file, so that breaks out of order are seen.
fn grid_of(table: &ImportedTable) -> CellGrid {
    let first = table.points.first().map_or(0.0, |point| point.speed_mps);
    let width = table.points.iter().take_while(|point| point.speed_mps == first).count().max(1);
    let rows: Vec<_> = table.points.chunks(width).collect();
    CellGrid {
        row_breaks: rows.iter().map(|row| row.first().map(|point| point.speed_mps)).collect(),
        column_breaks: rows.first().map_or(Vec::new(), |row| row.iter().map(|point| Some(point.accel_mps2)).collect()),
        values: rows.iter().map(|row| (0..width).map(|k| row.get(k).map(|point| point.torque_nm.value)).collect()).collect(),
        ..CellGrid::default()
    }
}
