//! Matrix and long CSV, with the separators, decimal commas and byte-order marks of spreadsheets.

use crate::import::error::TextFault;
use crate::import::foreign::{CellGrid, CsvLine, points_of_long_csv, says_long_form};
use crate::import::full_scale::FullScale;
use crate::import::imported::{ImportedPoint, ImportedTable};
use crate::import::number::WrittenNumber;
use crate::import::unit_names;
use crate::map::Gear;

/// The table of a text; the gear is that of the file's name.
pub(crate) fn read(cells: &[CsvLine], gear: Gear, full: FullScale) -> Result<ImportedTable, TextFault> {
    let Some(header) = cells.first() else { return Err(TextFault::whole("the file is empty")) };
    if says_long_form(header) { long(cells, header, gear, full) } else { matrix(cells, header, gear, full) }
}

fn long(cells: &[CsvLine], header: &CsvLine, gear: Gear, full: FullScale) -> Result<ImportedTable, TextFault> {
    let (points, misread) = points_of_long_csv(cells);
    if let Some(first) = misread.first() {
        return Err(TextFault::at(first.line, first.what.clone()));
    }
    let speed_name = header.texts.iter().find(|name| ["speed", "vel", "v"].iter().any(|n| name.to_ascii_lowercase().starts_with(n)));
    let speed = conversion(speed_name.map_or("", String::as_str), |unit| unit_names::speed(unit, full))
        .map_err(|what| TextFault::at(header.line, what))?;
    let torque = conversion(&points.command, |unit| unit_names::torque(unit, full)).map_err(|what| TextFault::at(header.line, what))?;
    let text = |line: u64, value: f64| {
        let cells = cells.iter().find(|c| c.line == line);
        let written =
            cells.and_then(|c| c.texts.iter().filter_map(|t| WrittenNumber::parse(t)).find(|w| w.value.to_bits() == value.to_bits()));
        written.unwrap_or(WrittenNumber { value, last_digit: 0.0 })
    };
    let point = |p: &crate::import::foreign::CommandPoint| ImportedPoint {
        speed_mps: speed.0 * p.speed + speed.1,
        accel_mps2: p.accel,
        torque_nm: text(p.line, p.command).scaled(torque.0, torque.1),
    };
    Ok(ImportedTable { gear, points: points.points.iter().map(point).collect() })
}

fn matrix(cells: &[CsvLine], header: &CsvLine, gear: Gear, full: FullScale) -> Result<ImportedTable, TextFault> {
    let (grid, misread) = CellGrid::of_cells(cells);
    if let Some(first) = misread.first() {
        return Err(TextFault::at(first.line, first.what.clone()));
    }
    let (rows, columns) = grid.corner.split_once('\\').unwrap_or((&grid.corner, ""));
    let wrong = |what: String| TextFault::at(header.line, what);
    if !rows.trim().to_ascii_lowercase().starts_with("speed") {
        return Err(wrong(format!(
            "the corner cell is {:?}; a Table 2 has speeds in its first column, and its corner cell says so: speed_mps\\accel_mps2",
            grid.corner
        )));
    }
    if !columns.is_empty() && !columns.trim().to_ascii_lowercase().starts_with("acc") {
        return Err(wrong(format!("the columns are {columns:?}; those of a Table 2 are accelerations")));
    }
    let speed = conversion(rows, |unit| unit_names::speed(unit, full)).map_err(wrong)?;
    let speeds: Vec<f64> = grid.row_breaks.iter().flatten().map(|v| speed.0 * v + speed.1).collect();
    let accels: Vec<f64> = grid.column_breaks.iter().flatten().copied().collect();
    let values =
        cells.iter().skip(1).flat_map(|line| line.texts.iter().skip(1)).filter_map(|text| WrittenNumber::parse(text)).collect::<Vec<_>>();
    Ok(ImportedTable::of_matrix(gear, &speeds, &accels, &values))
}

/// The conversion of a column by the unit in its name; SI without one.
fn conversion(name: &str, by_unit: impl Fn(&str) -> Result<unit_names::Conversion, String>) -> Result<unit_names::Conversion, String> {
    let unit = unit_names::of_column(name);
    if unit.is_empty() { Ok(unit_names::SI) } else { by_unit(&unit) }
}
