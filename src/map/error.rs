//! Errors of a table or its file.

use crate::text::shown;
use std::path::PathBuf;

/// Result of this room.
pub(crate) type Result<T> = std::result::Result<T, Error>;

/// Errors of a table or its file. Rows and columns in messages count from 1, as in a spreadsheet, with the header included.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
#[allow(missing_docs)] // the fields are what the message says
pub enum Error {
    #[error("axis {axis} has {found} break(s); at least 2 are needed")]
    AxisTooShort { axis: &'static str, found: usize },
    #[error("axis {axis}: break {} is {value}; it must be a finite number", index + 1)]
    AxisNotFinite { axis: &'static str, index: usize, value: f64 },
    #[error("axis {axis}: break {} is {value}, not above the one before it ({previous}); breaks must increase strictly", index + 1)]
    AxisNotIncreasing { axis: &'static str, index: usize, previous: f64, value: f64 },
    #[error("{table} has {found} values; its axes need {rows} × {columns}")]
    WrongShape { table: &'static str, rows: usize, columns: usize, found: usize },
    #[error("{table}: the value in row {}, column {} is {value}; it must be a finite number", row + 2, column + 2)]
    NotFinite { table: &'static str, row: usize, column: usize, value: f64 },
    #[error("{place} has {found} entries; its axis needs {expected}")]
    WrongLength { place: String, expected: usize, found: usize },
    #[error("{place} is {value}; it must be a finite number")]
    NoNumber { place: String, value: f64 },
    #[error("the corner cell is {found:?}; it must be {expected:?} (rows\\columns)")]
    WrongAxes { found: String, expected: String },
    #[error("the file is empty; a table has a header row of column breaks and a row per row break")]
    EmptyCsv,
    #[error("line {line} has {found} cells; the header has {expected}")]
    RaggedCsv { line: u64, found: usize, expected: usize },
    #[error("line {line}, column {column}: {text:?} is not a number")]
    NotANumber { line: u64, column: usize, text: String },
    #[error("not a table that can be read as CSV: {0}")]
    Csv(#[from] csv::Error),
    #[error("{field} is {value}; allowed: {allowed}")]
    BadVehicle { field: &'static str, value: f64, allowed: &'static str },
    #[error("this is not a {expected} file: its \"format\" is {found:?}")]
    WrongFormat { found: String, expected: &'static str },
    #[error(
        "format version {found} is not known to this program, which reads version {known}; use the pivot-cal that wrote the file, or make it again"
    )]
    UnknownVersion { found: u64, known: u32 },
    #[error("families.inertia is {m0} and {m1}; it must be positive straight ahead and at 90°")]
    BadInertia { m0: f64, m1: f64 },
    #[error("the compensation curve: {field} in place {} is {value}; allowed: {allowed}", index + 1)]
    Curve { field: &'static str, index: usize, value: f64, allowed: &'static str },
    #[error("the JSON cannot be read: {0}")]
    Json(#[from] serde_json::Error),
    #[error("{}: another pivot-cal is writing into this folder; wait until it has finished, or give another folder", shown(folder))]
    Busy { folder: PathBuf },
    #[error("{}: {source}", shown(path))]
    Io { path: PathBuf, source: std::io::Error },
}
