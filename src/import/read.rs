//! The format of a file by its content, and the file read.

use crate::import::autoware::{other_pedal, says_pedal_map};
use crate::import::error::TextFault;
use crate::import::foreign::{CsvLine, cells_of_csv, points_of_apollo};
use crate::import::full_scale::FullScale;
use crate::import::imported::{ImportedAccelTable, ImportedMap, ImportedPoint, ImportedTable};
use crate::import::number::WrittenNumber;
use crate::import::{Error, Result, autoware, c_source, cdfx, csv, dcm, rust_source};
use crate::map::{Gear, Table2File, read_whole_text, sha256_hex};
use crate::text::shown;
use std::path::Path;

/// The format of a map.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum MapFormat {
    Json,
    Dcm,
    Cdfx,
    Apollo,
    C,
    Rust,
    Autoware,
    Csv,
}

impl MapFormat {
    /// The format of a text; a pedal map is also known by the name of its file.
    pub(crate) fn of(name: &str, text: &str) -> Self {
        let has_line = |start: &str| text.lines().any(|line| line.trim_start().starts_with(start));
        if text.trim_start().starts_with('{') {
            Self::Json
        } else if has_line("KONSERVIERUNG_FORMAT") || has_line("KENNFELD ") {
            Self::Dcm
        } else if text.contains("<MSRSW") {
            Self::Cdfx
        } else if text.contains("calibration") && text.contains('{') && text.contains("speed:") {
            Self::Apollo
        } else if text.contains(rust_source::TABLE) {
            Self::Rust
        } else if text.contains("static const ") {
            Self::C
        } else {
            let first = text.lines().find(|line| !line.trim().is_empty()).unwrap_or_default();
            let corner = cells_of_csv(first).first().and_then(|line| line.texts.first().cloned()).unwrap_or_default();
            if says_pedal_map(name, &corner) { Self::Autoware } else { Self::Csv }
        }
    }

    /// Its name in messages.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Json => "table2.json",
            Self::Dcm => "DCM",
            Self::Cdfx => "CDFX",
            Self::Apollo => "Apollo",
            Self::C => "C",
            Self::Rust => "Rust",
            Self::Autoware => "Autoware",
            Self::Csv => "CSV",
        }
    }
}

/// Reads the map of a file. A file of one gear is that of reverse gear if its name has `reverse`. Of Autoware's two maps the other is read where
/// it is beside the one that was named.
///
/// # Errors
/// A file that cannot be read, holds no map, or has units that it does not explain.
pub(crate) fn read_map(path: &Path, full: FullScale) -> Result<ImportedMap> {
    let read = |path: &Path| read_whole_text(path).map_err(|source| Error::Read { path: path.to_owned(), source });
    let text = read(path)?;
    let text = text.trim_start_matches('\u{feff}');
    let name = path.file_name().map(shown).unwrap_or_default();
    let gear = if name.to_ascii_lowercase().contains("reverse") { Gear::Reverse } else { Gear::Forward };
    let format = MapFormat::of(&name, text);
    let fault = |fault: TextFault| match fault.line {
        0 => Error::Content { path: path.to_owned(), format: format.name(), what: fault.what },
        line => Error::Line { path: path.to_owned(), line, what: fault.what },
    };
    let mut accel_tables = Vec::new();
    let mut sha256 = sha256_hex(text.as_bytes());
    let tables = match format {
        MapFormat::Json => of_json(text).map_err(|source| Error::File { path: path.to_owned(), source })?,
        MapFormat::Apollo => vec![of_apollo(text, gear, full).map_err(fault)?],
        MapFormat::Csv => vec![csv::read(&cells_of_csv(text), gear, full).map_err(fault)?],
        MapFormat::Autoware => {
            let other = other_pedal(&name).map(|other| path.with_file_name(other)).filter(|other| other.is_file());
            let beside = other.as_deref().map(read).transpose()?;
            if let Some(beside) = &beside {
                sha256 = sha256_hex(format!("{sha256}{}", sha256_hex(beside.as_bytes())).as_bytes());
            }
            let cells = [Some(text), beside.as_deref()].map(|text| text.map(cells_of_csv));
            let names = [Some(name.clone()), other_pedal(&name)];
            let halves: Vec<(&str, &[CsvLine])> =
                names.iter().zip(&cells).filter_map(|(name, cells)| Some((name.as_deref()?, cells.as_deref()?))).collect();
            accel_tables.push(autoware::read(&halves, gear, full).map_err(fault)?);
            accel_tables.iter().map(ImportedAccelTable::inverted).collect()
        }
        source => source_tables(source, text, full).map_err(fault)?,
    };
    for (k, table) in tables.iter().enumerate() {
        if tables[..k].iter().any(|other| other.gear == table.gear) {
            let what = format!("it holds two maps of {} gear", table.gear);
            return Err(Error::Content { path: path.to_owned(), format: format.name(), what });
        }
        table.table().map_err(|source| Error::File { path: path.to_owned(), source })?;
    }
    Ok(ImportedMap { format: format.name(), sha256, tables, accel_tables })
}

/// The tables of a DCM, CDFX, C or Rust file; none of a file in another format.
///
/// # Errors
/// It holds no table, or a number or unit that cannot be read.
pub(crate) fn source_tables(format: MapFormat, text: &str, full: FullScale) -> std::result::Result<Vec<ImportedTable>, TextFault> {
    match format {
        MapFormat::Dcm => dcm::read(text, full),
        MapFormat::Cdfx => cdfx::read(text, full),
        MapFormat::C => c_source::read(text),
        MapFormat::Rust => rust_source::read(text),
        MapFormat::Json | MapFormat::Apollo | MapFormat::Autoware | MapFormat::Csv => Ok(Vec::new()),
    }
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
    let point = |p: &crate::import::foreign::CommandPoint| ImportedPoint {
        speed_mps: p.speed,
        accel_mps2: p.accel,
        torque_nm: WrittenNumber { value: p.command, last_digit: APOLLO_DIGIT }.scaled(full_nm / 100.0, 0.0),
    };
    Ok(ImportedTable { gear, points: points.points.iter().map(point).collect() })
}
