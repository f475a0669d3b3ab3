//! One side of a comparison: the tables of a file with their standard errors, in one layout whichever table it is.

use crate::diff::{Error, Result};
use crate::map::{CellStatus, Gear, LogRef, MapFolder, Mismatch, TABLE2_FORMAT, Table1File, Table2File, Vehicle, lookup, read_whole_text};
use crate::text::shown;
use serde::Serialize;
use std::path::Path;

/// Which table is compared.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Table {
    /// Acceleration [m/s²] over torque (rows) and speed (columns).
    Table1,
    /// Torque [N·m] over speed (rows) and desired acceleration (columns).
    Table2,
}

impl Table {
    /// Unit of the values.
    pub(crate) fn unit(self) -> &'static str {
        if self == Self::Table1 { "m/s²" } else { "N·m" }
    }

    /// Names of the row and the column axis with units.
    pub(crate) fn axes(self) -> [&'static str; 2] {
        match self {
            Self::Table1 => ["torque [N·m]", "speed [m/s]"],
            Self::Table2 => ["speed [m/s]", "acceleration [m/s²]"],
        }
    }
}

/// A file that is compared.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct DiffSide {
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

impl DiffSide {
    /// Reads a `table1.json` or `table2.json`, or the `table2.json` of a folder.
    ///
    /// # Errors
    /// A file that is missing, is no map, or whose arrays do not fit its axes.
    pub(crate) fn read(path: &Path) -> Result<Self> {
        let path = if path.is_dir() {
            if let Ok((_, mismatches)) = MapFolder::read(&path.into())
                && let Some(Mismatch::Hash { file, .. } | Mismatch::Generation { file, .. }) = mismatches.first()
            {
                return Err(Error::Mixed { path: path.to_owned(), file: file.clone() });
            }
            path.join("table2.json")
        } else {
            path.to_owned()
        };
        let text = read_whole_text(&path).map_err(|source| Error::Read { path: path.clone(), source })?;
        // any other file is read as Table 1, whose reader reports its fault
        let second = serde_json::from_str::<serde_json::Value>(&text).is_ok_and(|json| json["format"] == TABLE2_FORMAT);
        Self::of_text(&path, &text, second)
    }

    fn of_text(path: &Path, text: &str, second: bool) -> Result<Self> {
        let name = shown(path);
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
                let errors = m.std_err_nm.concat();
                sheet.with_known(&m.status, |k| errors[k].is_some())
            });
            return Ok(Self { name, table: Table::Table2, vehicle: file.vehicle, logs: file.logs, sheets: sheets.collect() });
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
            sheet.with_known(&m.status, |_| true)
        });
        Ok(Self { name, table: Table::Table1, vehicle: file.vehicle, logs: file.logs, sheets: sheets.collect() })
    }
}

impl Sheet {
    /// Fills `known`: the cells that were measured or interpolated and whose standard error is given.
    fn with_known(mut self, status: &[Vec<CellStatus>], has_error: impl Fn(usize) -> bool) -> Self {
        let sound = |s: &CellStatus| matches!(s, CellStatus::Measured | CellStatus::Interpolated);
        self.known = status.iter().flatten().enumerate().map(|(k, s)| if sound(s) && has_error(k) { 1.0 } else { 0.0 }).collect();
        self
    }

    /// Value and standard error at a place by bilinear interpolation; `None` outside the axes, and where a cell around it is unknown. The
    /// interpolated standard error is an upper bound: that of neighbours whose errors are fully correlated.
    pub(crate) fn at(&self, row: f64, column: f64) -> Option<(f64, f64)> {
        let read = |field: &[f64]| lookup::bilinear(&self.rows, &self.columns, field, row, column);
        // the weights of unknown neighbours matter; a node of the grid has one neighbour only
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
        let sheet = sheet().with_known(&status(CellStatus::Extrapolated), |_| true);
        let (value, error) = sheet.at(0.5, 0.25).unwrap();
        assert!((value - 5.5).abs() < 1e-12 && (error - 0.2).abs() < 1e-12, "{value} ± {error}");
        assert_eq!(sheet.at(0.5, 1.5), None, "a neighbour is extrapolated");
        assert_eq!(sheet.at(1.0, 1.0), Some((12.0, 0.3)), "a node needs no neighbour");
        assert_eq!(sheet.at(0.5, 2.5), None, "beyond the axis");
    }

    #[test]
    fn a_cell_without_a_standard_error_is_not_known() {
        let sheet = sheet().with_known(&status(CellStatus::Measured), |k| k != 0);
        assert_eq!(sheet.at(0.0, 0.0), None);
        assert!(sheet.at(1.0, 2.0).is_some());
    }
}
