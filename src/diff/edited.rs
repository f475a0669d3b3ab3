//! The cells of a map that a person changed, by how many reported errors.
//!
//! In: Table 2 as it was made, and the file that came back. Out: [`EditedMap`]. A torque that differs by no more than the worth of its last digit
//! is the same. Other breaks are no change: each point of the file is compared with the look-up of the map there.

use crate::diff::sheet::{DiffSide, Sheet};
use crate::import::{ImportedMap, ImportedPoint, ImportedTable};
use crate::map::{Gear, lookup};
use serde::Serialize;

/// A file against the map that it came from.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct EditedMap {
    /// The map.
    pub(crate) map: String,
    /// The file.
    pub(crate) file: String,
    /// Its format.
    pub(crate) format: &'static str,
    /// Cells of the file that were compared.
    pub(crate) compared: usize,
    /// Cells of the file outside the map's axes.
    pub(crate) outside: usize,
    /// Gears of the file that the map lacks, and of the map that the file lacks.
    pub(crate) notes: Vec<String>,
    /// The changed cells, most reported errors first.
    pub(crate) cells: Vec<EditedCell>,
}

/// A changed cell.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub(crate) struct EditedCell {
    /// Gear.
    pub(crate) gear: Gear,
    /// Speed [m/s].
    pub(crate) speed_mps: f64,
    /// Desired acceleration [m/s²].
    pub(crate) accel_mps2: f64,
    /// Torque of the map [N·m].
    pub(crate) measured_nm: f64,
    /// Torque of the file [N·m].
    pub(crate) edited_nm: f64,
    /// Standard error of the map's torque [N·m]; absent where it is not known.
    pub(crate) std_err_nm: Option<f64>,
    /// The change over the standard error.
    pub(crate) errors: Option<f64>,
}

/// Share of the last digit that rounding to it costs, and of a look-up's rounding [N·m].
const ROUNDED: f64 = 0.5 + 1e-6;
const LOOK_UP_NM: f64 = 1e-9;
/// Last digit of a break in the formats that are written.
const BREAK_DIGIT: f64 = 1e-6;

/// Compares the file that came back with the map.
pub(crate) fn edited(map: &DiffSide, file: &str, imported: &ImportedMap) -> EditedMap {
    let at_test_angle = |sheet: &&Sheet| map.vehicle.test_angle().is_same_deg(sheet.wheel_angle_deg);
    let mut found = EditedMap {
        map: map.name.clone(),
        file: file.to_owned(),
        format: imported.format,
        compared: 0,
        outside: 0,
        notes: Vec::new(),
        cells: Vec::new(),
    };
    for table in &imported.tables {
        let Some(sheet) = map.sheets.iter().filter(at_test_angle).find(|s| s.gear == table.gear) else {
            found.notes.push(format!("{} gear is in {file} only", table.gear));
            continue;
        };
        add(&mut found, sheet, table);
    }
    for sheet in map.sheets.iter().filter(at_test_angle).filter(|s| imported.tables.iter().all(|t| t.gear != s.gear)) {
        found.notes.push(format!("{} gear is in {} only", sheet.gear, map.name));
    }
    let size = |cell: &EditedCell| (cell.errors.unwrap_or(f64::INFINITY).abs(), (cell.edited_nm - cell.measured_nm).abs());
    found.cells.sort_by(|a, b| {
        let (a, b) = (size(a), size(b));
        b.0.total_cmp(&a.0).then(b.1.total_cmp(&a.1))
    });
    found
}

fn add(found: &mut EditedMap, sheet: &Sheet, table: &ImportedTable) {
    for ImportedPoint { speed_mps, accel_mps2, torque_nm } in &table.points {
        // units of the user leave a rounding on the breaks
        let (speed, accel) = (nearest(&sheet.rows, *speed_mps), nearest(&sheet.columns, *accel_mps2));
        let Some(measured_nm) = lookup::bilinear(&sheet.rows, &sheet.columns, &sheet.values, speed, accel) else {
            found.outside += 1;
            continue;
        };
        found.compared += 1;
        let change = torque_nm.value - measured_nm;
        // what rounding of the point's own place changes: where a file has points between the breaks, as at zero torque
        let beside = |by: f64| lookup::bilinear(&sheet.rows, &sheet.columns, &sheet.values, speed, accel + by).unwrap_or(measured_nm);
        let of_place_nm = [-BREAK_DIGIT, BREAK_DIGIT].map(|by| (beside(by) - measured_nm).abs()).into_iter().fold(0.0, f64::max);
        if change.abs() <= ROUNDED * torque_nm.last_digit + of_place_nm + LOOK_UP_NM {
            continue;
        }
        let std_err_nm = sheet.at(speed, accel).map(|(_, error)| error).filter(|error| *error > 0.0);
        found.cells.push(EditedCell {
            gear: table.gear,
            speed_mps: speed,
            accel_mps2: accel,
            measured_nm,
            edited_nm: torque_nm.value,
            std_err_nm,
            errors: std_err_nm.map(|error| change / error),
        });
    }
}

/// The break that `value` is, within the rounding of its digits; otherwise the value itself.
fn nearest(breaks: &[f64], value: f64) -> f64 {
    breaks.iter().copied().find(|b| (b - value).abs() < BREAK_DIGIT).unwrap_or(value)
}
