//! The format of a file by its content, and the file read.

use crate::check::foreign::{cells_of_csv, points_of_apollo};
use crate::import::error::TextFault;
use crate::import::full_scale::FullScale;
use crate::import::imported::{ImportedMap, ImportedPoint, ImportedTable};
use crate::import::number::WrittenNumber;
use crate::import::{Error, Result, c_source, cdfx, csv, dcm};
use crate::map::{Gear, Table2File, read_whole_text, sha256_hex};
use crate::text::shown;
use std::path::Path;

/// Reads the Table 2 of a file. A file of one gear is that of reverse gear if its name has `reverse`.
///
/// # Errors
/// A file that cannot be read, holds no Table 2, or has units that it does not explain.
pub(crate) fn read_map(path: &Path, full: FullScale) -> Result<ImportedMap> {
    let text = read_whole_text(path).map_err(|source| Error::Read { path: path.to_owned(), source })?;
    let text = text.trim_start_matches('\u{feff}');
    let name = path.file_name().map(shown).unwrap_or_default();
    let gear = if name.to_ascii_lowercase().contains("reverse") { Gear::Reverse } else { Gear::Forward };
    let (format, tables) = tables_of(path, text, gear, full)?;
    for (k, table) in tables.iter().enumerate() {
        if tables[..k].iter().any(|other| other.gear == table.gear) {
            let what = format!("it holds two maps of {} gear", table.gear);
            return Err(Error::Content { path: path.to_owned(), format, what });
        }
        table.table().map_err(|source| Error::File { path: path.to_owned(), source })?;
    }
    Ok(ImportedMap { format, sha256: sha256_hex(text.as_bytes()), tables })
}

fn tables_of(path: &Path, text: &str, gear: Gear, full: FullScale) -> Result<(&'static str, Vec<ImportedTable>)> {
    let fault = |format: &'static str| {
        move |fault: TextFault| match fault.line {
            0 => Error::Content { path: path.to_owned(), format, what: fault.what },
            line => Error::Line { path: path.to_owned(), line, what: fault.what },
        }
    };
    let has_line = |start: &str| text.lines().any(|line| line.trim_start().starts_with(start));
    if text.trim_start().starts_with('{') {
        return Ok(("table2.json", of_json(text).map_err(|source| Error::File { path: path.to_owned(), source })?));
    }
    if has_line("KONSERVIERUNG_FORMAT") || has_line("KENNFELD ") {
        return Ok(("DCM", dcm::read(text, full).map_err(fault("DCM"))?));
    }
    if text.contains("<MSRSW") {
        return Ok(("CDFX", cdfx::read(text, full).map_err(fault("CDFX"))?));
    }
    if text.contains("calibration") && text.contains('{') && text.contains("speed:") {
        return Ok(("Apollo", vec![of_apollo(text, gear, full).map_err(fault("Apollo"))?]));
    }
    if text.contains("static const ") {
        return Ok(("C", c_source::read(text).map_err(fault("C"))?));
    }
    Ok(("CSV", vec![csv::read(&cells_of_csv(text), gear, full).map_err(fault("CSV"))?]))
}

fn of_json(text: &str) -> crate::map::Result<Vec<ImportedTable>> {
    let file = Table2File::from_json(text)?;
    let at_test_angle = file.maps.iter().filter(|m| m.angle().is_same(file.vehicle.test_angle()));
    let table = |map: &crate::map::TorqueMap| {
        let values: Vec<WrittenNumber> =
            map.torque_nm.iter().flatten().map(|value| WrittenNumber { value: *value, last_digit: 0.0 }).collect();
        ImportedTable::of_matrix(map.gear, &map.speed_mps, &map.accel_mps2, &values)
    };
    Ok(at_test_angle.map(table).collect())
}

/// Decimals of a command in our export of Apollo's table.
const APOLLO_DIGIT: f64 = 1e-6;

fn of_apollo(text: &str, gear: Gear, full: FullScale) -> std::result::Result<ImportedTable, TextFault> {
    let (points, misread) = points_of_apollo(text);
    if let Some(first) = misread.first() {
        return Err(TextFault::at(first.line, first.what.clone()));
    }
    // # forward gear; command = 100 * torque / 44 N.m
    let named =
        text.lines().find_map(|line| line.split_once("command = 100 * torque / ")?.1.split_whitespace().next()?.parse::<f64>().ok());
    let full_nm =
        named.or(full.torque_nm).ok_or_else(|| TextFault::whole("commands in % need the torque that is 100 %: --torque-full-scale"))?;
    let point = |p: &crate::check::foreign::CommandPoint| ImportedPoint {
        speed_mps: p.speed,
        accel_mps2: p.accel,
        torque_nm: WrittenNumber { value: p.command, last_digit: APOLLO_DIGIT }.scaled(full_nm / 100.0, 0.0),
    };
    Ok(ImportedTable { gear, points: points.points.iter().map(point).collect() })
}
