//! The maps under test: `table2.csv`, the file that is deployed, with the JSON files that belong to it.

use crate::import::ImportedMap;
use crate::map::{
    FolderView, Gear, LateralTableFile, MapFolder, Matrix, Mismatch, PerGear, Table1File, Table2File, TorqueMap, TorqueTable, sha256_hex,
};
use crate::verify::{Error, Result};
use std::path::Path;

/// Table 2 of a gear at a wheel angle, from its CSV.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct AngleMap {
    /// Gear.
    pub gear: Gear,
    /// Wheel angle [°], left positive.
    pub wheel_angle_deg: f64,
    /// The table.
    pub table: TorqueTable,
}

/// The maps that are verified, and Table 1 with the plant.
#[derive(Debug, Clone, PartialEq)]
pub struct Maps {
    /// Table 1 with its plant.
    pub table1: Table1File,
    /// The content of `table2.json`.
    pub table2: Table2File,
    /// Table 2 of forward gear, from its CSV.
    pub forward: TorqueTable,
    /// Table 2 of reverse gear, from its CSV; absent when reverse gear was not tested.
    pub reverse: Option<TorqueTable>,
    /// Table 2 of every wheel angle, the test angle included, if `table2.json` has several; otherwise empty.
    pub(crate) angles: Vec<AngleMap>,
    /// SHA-256 of the CSV files that were read, those of the test angle first, forward before reverse.
    pub csv_sha256: Vec<String>,
    /// Mismatches that were accepted.
    pub forced: Vec<String>,
    /// The lateral compensation table, when the folder has one.
    pub(crate) lateral: Option<LateralTableFile>,
}

impl Maps {
    /// Reads `table1.json`, `table2.json` and the CSV files beside them from `folder`.
    ///
    /// # Errors
    /// A file that is missing or cannot be read; a CSV or a `table1.json` that is not the one `table2.json` was written with, unless
    /// `force` accepts that.
    pub fn read(folder: &Path, force: bool) -> Result<Self> {
        Self::read_from(&folder.into(), force)
    }

    /// The same for a folder whose files may not be written yet.
    ///
    /// # Errors
    /// As [`Maps::read`].
    pub(crate) fn read_from(view: &FolderView, force: bool) -> Result<Self> {
        let folder = &view.path;
        let (files, mismatches) = MapFolder::read(view)?;
        let lateral = files.lateral()?;
        let mut forced = Vec::new();
        let (lateral, of_lateral) = lateral.map_or((None, None), |(table, mismatch)| (Some(table), mismatch));
        // the CSV files of Table 1 are not used here
        for mismatch in mismatches.into_iter().filter(|m| m.by() != "table1.json" || m.file() == "table2.json").chain(of_lateral) {
            forced.push(let_pass(folder, mismatch, force)?);
        }
        let MapFolder { table1, table2, csvs, .. } = files;
        let Some((table2, _)) = table2 else {
            return Err(Error::Read { path: folder.join("table2.json"), source: std::io::ErrorKind::NotFound.into() });
        };
        let at = |name: &str, source| Error::File { path: folder.join(name), source };
        let read = |map: &TorqueMap| -> Result<(String, TorqueTable)> {
            let path = folder.join(&map.csv.file);
            // a file that cannot be read is a mismatch that is never accepted
            let csv = csvs.iter().find(|csv| csv.name == map.csv.file).ok_or(std::io::ErrorKind::NotFound.into());
            let text = csv.and_then(|csv| Ok((csv, csv.text()?)));
            let (csv, text) = text.map_err(|source| Error::Read { path, source })?;
            let table = Matrix::from_csv(text).and_then(TorqueTable::from_matrix).map_err(|e| at(&csv.name, e))?;
            Ok((csv.sha256.clone(), table))
        };
        let mut csv_sha256 = Vec::new();
        let mut at_test_angle = PerGear::try_from_fn(|gear| -> Result<Option<TorqueTable>> {
            let Some(map) = table2.map_at_test_angle(gear) else { return Ok(None) };
            let (sha256, table) = read(map)?;
            csv_sha256.push(sha256);
            Ok(Some(table))
        })?;
        let forward = at_test_angle.forward.take().ok_or_else(|| Self::no_forward(&table2))?;
        let mut angles = Vec::new();
        for map in table2.maps.iter().filter(|_| table2.has_several_angles()) {
            let (sha256, table) = read(map)?;
            if !csv_sha256.contains(&sha256) {
                csv_sha256.push(sha256);
            }
            angles.push(AngleMap { gear: map.gear, wheel_angle_deg: map.wheel_angle_deg, table });
        }
        Ok(Self { table1, table2, forward, reverse: at_test_angle.reverse, angles, csv_sha256, forced, lateral })
    }

    /// From files that are already in memory; `table2` holds the CSV values.
    ///
    /// # Errors
    /// No forward map, or a table that is not sound.
    pub fn new(table1: Table1File, table2: Table2File) -> Result<Self> {
        let map = |gear| table2.map_at_test_angle(gear);
        let forward = map(Gear::Forward).ok_or_else(|| Self::no_forward(&table2))?.table()?;
        let reverse = map(Gear::Reverse).map(TorqueMap::table).transpose()?;
        let csv_sha256 = Gear::ALL.into_iter().filter_map(map).map(|m| m.csv.sha256.clone()).collect();
        let several = table2.maps.iter().filter(|_| table2.has_several_angles());
        let one = |m: &TorqueMap| Ok(AngleMap { gear: m.gear, wheel_angle_deg: m.wheel_angle_deg, table: m.table()? });
        let angles = several.map(one).collect::<Result<_>>()?;
        Ok(Self { table1, table2, forward, reverse, angles, csv_sha256, forced: Vec::new(), lateral: None })
    }

    /// The same maps with another wheel angle as the test angle: the pivots of its maps, on its plant.
    ///
    /// # Errors
    /// No forward map at this angle in either table; the error lists those that there are.
    pub(crate) fn at_angle(&self, wheel_angle_deg: f64) -> Result<Self> {
        let mut maps = self.clone();
        maps.table1.vehicle.test_angle_deg = wheel_angle_deg;
        maps.table2.vehicle.test_angle_deg = wheel_angle_deg;
        // with one angle there is no list, and it is the only one that can be asked for
        if !self.angles.is_empty() || !self.table2.vehicle.test_angle().is_same_deg(wheel_angle_deg) {
            let is_there = |m: &&AngleMap| maps.table2.vehicle.test_angle().is_same_deg(m.wheel_angle_deg);
            let of_gear = |gear| self.angles.iter().filter(is_there).find(|m| m.gear == gear).map(|m| m.table.clone());
            let (forward, reverse) = (of_gear(Gear::Forward), of_gear(Gear::Reverse));
            (maps.forward, maps.reverse) = (forward.ok_or_else(|| Self::no_forward(&maps.table2))?, reverse);
        }
        Ok(maps)
    }

    /// The same with the tables of a file that came back from a controller or a tool; they are judged on the measured plant.
    ///
    /// # Errors
    /// A file without a forward map, or whose points form no table.
    pub(crate) fn with_tables(mut self, imported: &ImportedMap) -> Result<Self> {
        let table = |gear| imported.tables.iter().find(|t| t.gear == gear).map(|t| t.table().map_err(Error::Map)).transpose();
        self.forward = table(Gear::Forward)?.ok_or_else(|| Self::no_forward(&self.table2))?;
        self.reverse = table(Gear::Reverse)?;
        (self.csv_sha256, self.angles) = (vec![imported.sha256.clone()], Vec::new());
        Ok(self)
    }

    /// SHA-256 of the lateral table, if the folder has one.
    pub(crate) fn lateral_sha256(&self) -> Option<String> {
        Some(sha256_hex(self.lateral.as_ref()?.to_json().ok()?.as_bytes()))
    }

    fn no_forward(table2: &Table2File) -> Error {
        let found: Vec<_> = table2.maps.iter().map(|m| format!("{} at {}°", m.gear, m.wheel_angle_deg)).collect();
        Error::NoMap {
            gear: Gear::Forward,
            angle_deg: table2.vehicle.test_angle_deg,
            table: "table2.json",
            found: if found.is_empty() { "none".to_owned() } else { found.join(", ") },
        }
    }

    /// Table 2 of `gear`, from its CSV.
    pub fn table(&self, gear: Gear) -> Option<&TorqueTable> {
        match gear {
            Gear::Forward => Some(&self.forward),
            Gear::Reverse => self.reverse.as_ref(),
        }
    }

    /// Largest torque that the controller may command [N·m]: the vehicle's limit, or the largest value of the tables.
    pub fn torque_limit_nm(&self) -> f64 {
        let tables = std::iter::once(&self.forward).chain(&self.reverse);
        self.table2.vehicle.torque_limit_or_largest_nm(tables.flat_map(TorqueTable::values).copied())
    }
}

/// A mismatch as a note if `force` is set, otherwise as an error. A file that cannot be read is always an error.
fn let_pass(folder: &Path, mismatch: Mismatch, force: bool) -> Result<String> {
    match mismatch {
        Mismatch::Hash { file, by, .. } | Mismatch::Generation { file, by, .. } if force => {
            Ok(format!("{file} is not the file that {by} describes"))
        }
        Mismatch::Hash { file, by, found, expected } => Err(Error::Hash { path: folder.join(file), by: folder.join(by), found, expected }),
        Mismatch::Generation { file, by, found, expected } => {
            Err(Error::Generation { path: folder.join(file), by: folder.join(by), generations: format!("{found}, {expected}") })
        }
        Mismatch::Unreadable { file, source, .. } => Err(Error::Read { path: folder.join(file), source }),
    }
}
