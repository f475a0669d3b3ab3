//! The cells of a map that a person changed, by how many reported errors.
//!
//! In: Table 2 as it was made, and the file that came back; of a Table 1, as Autoware's maps are, Table 1. Out: [`EditedMap`]. A torque that differs by no more than the worth of its last digit
//! is the same. Other breaks are no change: each point of the file is compared with the look-up of the map there.

use crate::diff::sheet::{DiffSide, Sheet};
use crate::import::{ImportedAccelTable, ImportedMap, ImportedPoint, ImportedTable, WrittenNumber};
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
    /// The changed cells of a Table 2, most reported errors first.
    pub(crate) cells: Vec<EditedCell>,
    /// The changed cells of a Table 1, most reported errors first.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(crate) accel_cells: Vec<EditedAccelCell>,
}

/// A changed cell of a Table 1.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub(crate) struct EditedAccelCell {
    /// Gear.
    pub(crate) gear: Gear,
    /// Torque [N·m].
    pub(crate) torque_nm: f64,
    /// Speed [m/s].
    pub(crate) speed_mps: f64,
    /// Acceleration of the map [m/s²].
    pub(crate) measured_mps2: f64,
    /// Acceleration of the file [m/s²].
    pub(crate) edited_mps2: f64,
    /// Standard error of the map's acceleration [m/s²]; absent where it is not known.
    pub(crate) std_err_mps2: Option<f64>,
    /// The change over the standard error.
    pub(crate) errors: Option<f64>,
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

/// Share of the last digit that rounding to it costs, and the rounding of a look-up [N·m or m/s²].
const ROUNDED: f64 = 0.5 + 1e-6;
const LOOK_UP: f64 = 1e-9;
/// Last digit of a break in the formats that are written.
const BREAK_DIGIT: f64 = 1e-6;

/// Compares the file that came back with the map: a Table 1 with a Table 1, any other with a Table 2.
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
        accel_cells: Vec::new(),
    };
    let sheet_of = |gear: Gear| map.sheets.iter().filter(at_test_angle).find(|s| s.gear == gear);
    for table in &imported.tables {
        let Some(sheet) = sheet_of(table.gear) else {
            found.notes.push(format!("{} gear is in {file} only", table.gear));
            continue;
        };
        match imported.accel_tables.iter().find(|accel| accel.gear == table.gear) {
            Some(accel) => add_accels(&mut found, sheet, accel),
            None => add(&mut found, sheet, table),
        }
    }
    for sheet in map.sheets.iter().filter(at_test_angle).filter(|s| imported.tables.iter().all(|t| t.gear != s.gear)) {
        found.notes.push(format!("{} gear is in {} only", sheet.gear, map.name));
    }
    let largest_first = |a: (Option<f64>, f64), b: (Option<f64>, f64)| {
        let size = |errors: Option<f64>| errors.unwrap_or(f64::INFINITY).abs();
        size(b.0).total_cmp(&size(a.0)).then(b.1.abs().total_cmp(&a.1.abs()))
    };
    found.cells.sort_by(|a, b| largest_first((a.errors, a.edited_nm - a.measured_nm), (b.errors, b.edited_nm - b.measured_nm)));
    let by_accel = |a: &EditedAccelCell, b: &EditedAccelCell| {
        largest_first((a.errors, a.edited_mps2 - a.measured_mps2), (b.errors, b.edited_mps2 - b.measured_mps2))
    };
    found.accel_cells.sort_by(by_accel);
    found
}

fn add(found: &mut EditedMap, sheet: &Sheet, table: &ImportedTable) {
    for ImportedPoint { speed_mps, accel_mps2, torque_nm } in &table.points {
        let Some(change) = change(found, sheet, [*speed_mps, *accel_mps2], *torque_nm) else { continue };
        found.cells.push(EditedCell {
            gear: table.gear,
            speed_mps: change.row,
            accel_mps2: change.column,
            measured_nm: change.measured,
            edited_nm: torque_nm.value,
            std_err_nm: change.std_err,
            errors: change.errors,
        });
    }
}

fn add_accels(found: &mut EditedMap, sheet: &Sheet, table: &ImportedAccelTable) {
    for point in &table.points {
        let Some(change) = change(found, sheet, [point.torque_nm, point.speed_mps], point.accel_mps2) else { continue };
        found.accel_cells.push(EditedAccelCell {
            gear: table.gear,
            torque_nm: change.row,
            speed_mps: change.column,
            measured_mps2: change.measured,
            edited_mps2: point.accel_mps2.value,
            std_err_mps2: change.std_err,
            errors: change.errors,
        });
    }
}

/// What a person changed at a place.
struct EditedPlace {
    row: f64,
    column: f64,
    measured: f64,
    std_err: Option<f64>,
    errors: Option<f64>,
}

/// Compares a value of the file with the map; `None` where it is the same or lies outside.
fn change(found: &mut EditedMap, sheet: &Sheet, [row, column]: [f64; 2], written: WrittenNumber) -> Option<EditedPlace> {
    // units of the user leave a rounding on the breaks
    let (row, column) = (nearest(&sheet.rows, row), nearest(&sheet.columns, column));
    let read = |column: f64| lookup::bilinear(&sheet.rows, &sheet.columns, &sheet.values, row, column);
    let Some(measured) = read(column) else {
        found.outside += 1;
        return None;
    };
    found.compared += 1;
    let change = written.value - measured;
    // what rounding of the point's own place changes: where a file has points between the breaks, as at zero torque
    let beside = |by: f64| read(column + by).unwrap_or(measured);
    let of_place = [-BREAK_DIGIT, BREAK_DIGIT].map(|by| (beside(by) - measured).abs()).into_iter().fold(0.0, f64::max);
    if change.abs() <= ROUNDED * written.last_digit + of_place + LOOK_UP {
        return None;
    }
    let std_err = sheet.at(row, column).map(|(_, error)| error).filter(|error| *error > 0.0);
    Some(EditedPlace { row, column, measured, std_err, errors: std_err.map(|error| change / error) })
}

/// The break that `value` is, within the rounding of its digits; otherwise the value itself.
fn nearest(breaks: &[f64], value: f64) -> f64 {
    breaks.iter().copied().find(|b| (b - value).abs() < BREAK_DIGIT).unwrap_or(value)
}
