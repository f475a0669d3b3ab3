//! One side of a comparison: the tables of a file with their standard errors, in one layout whichever table it is.

use crate::diff::{Error, Result};
use crate::map::{CellStatus, Gear, LogRef, TABLE2_FORMAT, Table1File, Table2File, Vehicle, lookup};
use serde::Serialize;
use std::path::{Path, PathBuf};

/// Which table is compared.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Table {
    /// Acceleration [m/s²] over torque (rows) and speed (columns).
    Table1,
    /// Torque [N·m] over speed (rows) and desired acceleration (columns).
    Table2,
}

impl Table {
    /// Unit of the values.
    pub fn unit(self) -> &'static str {
        if self == Self::Table1 { "m/s²" } else { "N·m" }
    }

    /// Names of the row and the column axis with units.
    pub fn axes(self) -> [&'static str; 2] {
        match self {
            Self::Table1 => ["torque [N·m]", "speed [m/s]"],
            Self::Table2 => ["speed [m/s]", "acceleration [m/s²]"],
        }
    }
}

/// A file that is compared.
#[derive(Debug, Clone, PartialEq)]
pub struct Side {
    /// Its path, as given.
    pub name: String,
    /// Which table it is.
    pub table: Table,
    /// The vehicle.
    pub vehicle: Vehicle,
    /// The logs behind it.
    pub logs: Vec<LogRef>,
    pub(crate) sheets: Vec<Sheet>,
}

/// One table with its standard errors. Row-major.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Sheet {
    pub(crate) gear: Gear,
    pub(crate) wheel_angle_deg: f64,
    pub(crate) rows: Vec<f64>,
    pub(crate) columns: Vec<f64>,
    pub(crate) values: Vec<f64>,
    /// Standard error; 0 where it is not known.
    pub(crate) std_err: Vec<f64>,
    /// 1 where the cell was measured or interpolated, 0 where it is extrapolated, unreachable or without a standard error.
    pub(crate) known: Vec<f64>,
}

impl Side {
    /// Reads a `table1.json` or `table2.json`, or the `table2.json` of a folder.
    ///
    /// # Errors
    /// A file that is missing, is no map, or whose matrices do not fit together.
    pub fn read(path: &Path) -> Result<Self> {
        let path = if path.is_dir() { path.join("table2.json") } else { path.to_owned() };
        let text = std::fs::read_to_string(&path).map_err(|source| Error::Read { path: path.clone(), source })?;
        // a file that is neither is read as Table 1, whose reader tells what is wrong with it
        let second = serde_json::from_str::<serde_json::Value>(&text).is_ok_and(|json| json["format"] == TABLE2_FORMAT);
        Self::of_text(&path, &text, second)
    }

    fn of_text(path: &Path, text: &str, second: bool) -> Result<Self> {
        let name = path.display().to_string();
        let wrong = |source| Error::File { path: path.to_owned(), source };
        if second {
            let file = Table2File::from_json(text).map_err(wrong)?;
            let sheets = file.maps.iter().map(|m| {
                let sheet = Sheet {
                    gear: m.gear,
                    wheel_angle_deg: m.wheel_angle_deg,
                    rows: m.speed_mps.clone(),
                    columns: m.accel_mps2.clone(),
                    values: m.torque_nm.concat(),
                    std_err: m.std_err_nm.concat().into_iter().map(Option::unwrap_or_default).collect(),
                    known: Vec::new(),
                };
                let has_error: Vec<_> = m.std_err_nm.concat().iter().map(Option::is_some).collect();
                sheet.checked(path, m.std_err_nm.len(), &m.status, &has_error)
            });
            let sheets = sheets.collect::<Result<_>>()?;
            return Ok(Self { name, table: Table::Table2, vehicle: file.vehicle, logs: file.logs, sheets });
        }
        let file = Table1File::from_json(text).map_err(wrong)?;
        let sheets = file.maps.iter().map(|m| {
            let sheet = Sheet {
                gear: m.gear,
                wheel_angle_deg: m.wheel_angle_deg,
                rows: m.torque_nm.clone(),
                columns: m.speed_mps.clone(),
                values: m.accel_mps2.concat(),
                std_err: m.std_err_mps2.concat(),
                known: Vec::new(),
            };
            let has_error = vec![true; sheet.std_err.len()];
            sheet.checked(path, m.std_err_mps2.len(), &m.status, &has_error)
        });
        let sheets = sheets.collect::<Result<_>>()?;
        Ok(Self { name, table: Table::Table1, vehicle: file.vehicle, logs: file.logs, sheets })
    }
}

impl Sheet {
    /// Checks that standard errors and status have the values' shape, and fills `known`.
    fn checked(mut self, path: &Path, std_err_rows: usize, status: &[Vec<CellStatus>], has_error: &[bool]) -> Result<Self> {
        let (rows, columns) = (self.rows.len(), self.columns.len());
        let gear = self.gear;
        let shape = |field, found_rows| {
            let path: PathBuf = path.to_owned();
            Error::Shape { path, gear, field, found_rows, rows, columns }
        };
        if self.std_err.len() != rows * columns || std_err_rows != rows {
            return Err(shape("standard errors", std_err_rows));
        }
        if status.len() != rows || status.iter().any(|row| row.len() != columns) {
            return Err(shape("status", status.len()));
        }
        let sound = |s: &CellStatus| matches!(s, CellStatus::Measured | CellStatus::Interpolated);
        self.known = status.iter().flatten().zip(has_error).map(|(s, has_error)| if sound(s) && *has_error { 1.0 } else { 0.0 }).collect();
        Ok(self)
    }

    /// Value and standard error at a place by bilinear interpolation; `None` outside the axes, and where a cell around is not known. The
    /// interpolated standard error is an upper bound: that of neighbours whose errors are fully correlated.
    pub(crate) fn at(&self, row: f64, column: f64) -> Option<(f64, f64)> {
        let read = |field: &[f64]| lookup::bilinear(&self.rows, &self.columns, field, row, column);
        // weights of unknown neighbours count; a node of the grid has one neighbour only
        let known = read(&self.known)? > 1.0 - 1e-9;
        known.then_some(())?;
        Some((read(&self.values)?, read(&self.std_err)?))
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn sheet() -> Sheet {
        Sheet {
            gear: Gear::Forward,
            wheel_angle_deg: 90.0,
            rows: vec![0.0, 1.0],
            columns: vec![0.0, 1.0, 2.0],
            values: vec![0.0, 2.0, 4.0, 10.0, 12.0, 14.0],
            std_err: vec![0.1, 0.1, 0.1, 0.3, 0.3, 0.3],
            known: Vec::new(),
        }
    }

    fn status(last: CellStatus) -> [Vec<CellStatus>; 2] {
        [vec![CellStatus::Measured; 3], vec![CellStatus::Interpolated, CellStatus::Measured, last]]
    }

    #[test]
    fn a_place_between_nodes_is_read_where_all_of_its_neighbours_are_known() {
        let file = Path::new("table2.json");
        let sheet = sheet().checked(file, 2, &status(CellStatus::Extrapolated), &[true; 6]).unwrap();
        let (value, error) = sheet.at(0.5, 0.25).unwrap();
        assert!((value - 5.5).abs() < 1e-12 && (error - 0.2).abs() < 1e-12, "{value} ± {error}");
        assert_eq!(sheet.at(0.5, 1.5), None, "a neighbour is extrapolated");
        assert_eq!(sheet.at(1.0, 1.0), Some((12.0, 0.3)), "a node needs no neighbour");
        assert_eq!(sheet.at(0.5, 2.5), None, "beyond the axis");
    }

    #[test]
    fn a_cell_without_a_standard_error_is_not_known() {
        let mut has_error = [true; 6];
        has_error[0] = false;
        let sheet = sheet().checked(Path::new("table2.json"), 2, &status(CellStatus::Measured), &has_error).unwrap();
        assert_eq!(sheet.at(0.0, 0.0), None);
        assert!(sheet.at(1.0, 2.0).is_some());
    }

    #[test]
    fn standard_errors_and_status_of_another_shape_are_refused_with_their_name() {
        let file = Path::new("table2.json");
        let error = sheet().checked(file, 3, &status(CellStatus::Measured), &[true; 6]).unwrap_err().to_string();
        assert!(error.contains("standard errors of 3 rows, not 2 × 3"), "{error}");
        let error = sheet().checked(file, 2, &status(CellStatus::Measured)[..1], &[true; 6]).unwrap_err().to_string();
        assert!(error.contains("status of 1 rows"), "{error}");
    }
}
