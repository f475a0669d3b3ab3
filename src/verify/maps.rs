//! The maps under test: `table2.csv` itself, the artefact that is deployed, with the JSON files that belong to it.

use crate::map::{Gear, LateralTableFile, Matrix, SAME_ANGLE_DEG, Table1File, Table2File, TorqueMap, TorqueTable, sha256_hex};
use crate::verify::{Error, Result};
use std::path::Path;

/// Table 2 of a gear at a wheel angle, as its CSV says.
#[derive(Debug, Clone, PartialEq)]
pub struct AngleMap {
    /// Gear.
    pub gear: Gear,
    /// Wheel angle [°], left positive.
    pub wheel_angle_deg: f64,
    /// The table.
    pub table: TorqueTable,
}

/// What is verified, and against which plant.
#[derive(Debug, Clone, PartialEq)]
pub struct Maps {
    /// Table 1 with its plant.
    pub table1: Table1File,
    /// What `table2.json` says.
    pub table2: Table2File,
    /// Table 2 of forward gear, as its CSV says.
    pub forward: TorqueTable,
    /// Table 2 of reverse gear, as its CSV says; absent when reverse gear was not tested.
    pub reverse: Option<TorqueTable>,
    /// Table 2 of every wheel angle, the test angle's among them, where `table2.json` has several; else empty.
    pub angles: Vec<AngleMap>,
    /// SHA-256 of the CSV files that were read, those of the test angle first, forward before reverse.
    pub csv_sha256: Vec<String>,
    /// What does not fit together and was let pass.
    pub forced: Vec<String>,
    /// The lateral compensation table, when the folder has one.
    pub lateral: Option<LateralTableFile>,
}

impl Maps {
    /// Reads `table1.json`, `table2.json` and the CSV files beside them from `folder`.
    ///
    /// # Errors
    /// A file that is missing or cannot be read; a CSV, or a `table1.json`, that is not the one `table2.json` was written with, unless
    /// `force` lets that pass.
    pub fn read(folder: &Path, force: bool) -> Result<Self> {
        let text = |name: &str| {
            let path = folder.join(name);
            std::fs::read_to_string(&path).map_err(|source| Error::Read { path, source })
        };
        let at = |name: &str, source| Error::File { path: folder.join(name), source };
        let (json1, json2) = (text("table1.json")?, text("table2.json")?);
        let table1 = Table1File::from_json(&json1).map_err(|e| at("table1.json", e))?;
        let table2 = Table2File::from_json(&json2).map_err(|e| at("table2.json", e))?;
        let mut forced = Vec::new();
        let mut check = |name: &str, bytes: &[u8], expected: &str| {
            let found = sha256_hex(bytes);
            if found == expected {
                return Ok(found);
            }
            if !force {
                let (path, by) = (folder.join(name), folder.join("table2.json"));
                return Err(Error::Hash { path, by, found, expected: expected.to_owned() });
            }
            forced.push(format!("{name} is not the file that table2.json describes"));
            Ok(found)
        };
        check("table1.json", json1.as_bytes(), &table2.table1.sha256)?;
        let mut csv_sha256 = Vec::new();
        let mut read = |gear: Gear| -> Result<Option<TorqueTable>> {
            let Some(map) = table2.map(gear, table2.vehicle.test_angle_deg, SAME_ANGLE_DEG) else { return Ok(None) };
            let name = &map.csv.file;
            let csv = text(name)?;
            csv_sha256.push(check(name, csv.as_bytes(), &map.csv.sha256)?);
            let table = Matrix::from_csv(&csv).and_then(TorqueTable::from_matrix).map_err(|e| at(name, e))?;
            Ok(Some(table))
        };
        let forward = read(Gear::Forward)?;
        let reverse = read(Gear::Reverse)?;
        let forward = forward.ok_or_else(|| Self::no_forward(&table2))?;
        let mut angles = Vec::new();
        for map in table2.maps.iter().filter(|_| has_several_angles(&table2)) {
            let name = &map.csv.file;
            let csv = text(name)?;
            let found = check(name, csv.as_bytes(), &map.csv.sha256)?;
            if !csv_sha256.contains(&found) {
                csv_sha256.push(found);
            }
            let table = Matrix::from_csv(&csv).and_then(TorqueTable::from_matrix).map_err(|e| at(name, e))?;
            angles.push(AngleMap { gear: map.gear, wheel_angle_deg: map.wheel_angle_deg, table });
        }
        forced.dedup();
        let path = folder.join("lateral_table.json");
        let lateral = if path.exists() {
            let json = text("lateral_table.json")?;
            let file = LateralTableFile::from_json(&json).map_err(|e| at("lateral_table.json", e))?;
            check_lateral(folder, &file, force, &mut forced)?;
            Some(file)
        } else {
            None
        };
        Ok(Self { table1, table2, forward, reverse, angles, csv_sha256, forced, lateral })
    }

    /// Takes over files that are already in memory, the CSV being what `table2` holds.
    ///
    /// # Errors
    /// No forward map, or a table that is not sound.
    pub fn new(table1: Table1File, table2: Table2File) -> Result<Self> {
        let angle_deg = table2.vehicle.test_angle_deg;
        let map = |gear| table2.map(gear, angle_deg, SAME_ANGLE_DEG);
        let forward = map(Gear::Forward).ok_or_else(|| Self::no_forward(&table2))?.table()?;
        let reverse = map(Gear::Reverse).map(TorqueMap::table).transpose()?;
        let csv_sha256 = Gear::ALL.into_iter().filter_map(map).map(|m| m.csv.sha256.clone()).collect();
        let several = table2.maps.iter().filter(|_| has_several_angles(&table2));
        let one = |m: &TorqueMap| Ok(AngleMap { gear: m.gear, wheel_angle_deg: m.wheel_angle_deg, table: m.table()? });
        let angles = several.map(one).collect::<Result<_>>()?;
        Ok(Self { table1, table2, forward, reverse, angles, csv_sha256, forced: Vec::new(), lateral: None })
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

    /// Table 2 of `gear`, as its CSV says.
    pub fn table(&self, gear: Gear) -> Option<&TorqueTable> {
        match gear {
            Gear::Forward => Some(&self.forward),
            Gear::Reverse => self.reverse.as_ref(),
        }
    }

    /// Largest torque that the controller may ask for [N·m]: the vehicle's limit, or the largest value of the tables.
    pub fn torque_limit_nm(&self) -> f64 {
        self.table2.vehicle.torque_limit_nm.unwrap_or_else(|| {
            let values = self.forward.values().iter().chain(self.reverse.iter().flat_map(TorqueTable::values));
            values.fold(0.0, |largest, v| v.abs().max(largest))
        })
    }
}

/// Whether a file holds maps of more than the one wheel angle.
fn has_several_angles(table2: &Table2File) -> bool {
    table2.maps.iter().any(|m| (m.wheel_angle_deg - table2.maps[0].wheel_angle_deg).abs() > SAME_ANGLE_DEG)
}

/// `lateral_table.csv` has to be the one that `lateral_table.json` describes.
fn check_lateral(folder: &Path, file: &LateralTableFile, force: bool, forced: &mut Vec<String>) -> Result<()> {
    let path = folder.join(&file.csv.file);
    let bytes = std::fs::read(&path).map_err(|source| Error::Read { path: path.clone(), source })?;
    let found = sha256_hex(&bytes);
    if found == file.csv.sha256 {
        return Ok(());
    }
    if !force {
        return Err(Error::Hash { path, by: folder.join("lateral_table.json"), found, expected: file.csv.sha256.clone() });
    }
    forced.push(format!("{} is not the file that lateral_table.json describes", file.csv.file));
    Ok(())
}
