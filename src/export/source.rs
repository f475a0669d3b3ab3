//! The map to export, whose files were found to belong together.

use crate::export::{Error, Result};
use crate::map::{AccelTable, CsvRef, Gear, Matrix, SAME_ANGLE_DEG, Table1File, Table2File, TorqueMap, TorqueTable, sha256_hex};
use std::path::Path;

/// A map whose hashes match.
#[derive(Debug, Clone, PartialEq)]
pub struct Source {
    /// What `table2.json` says, of the maps at one wheel angle, its test angle.
    pub table2: Table2File,
    /// Its text, byte for byte.
    pub table2_json: String,
    /// Wheel angles [°] of which `table2.json` holds maps, too.
    pub other_angles_deg: Vec<f64>,
    /// Table 2 per gear at the test angle, forward first. Never empty.
    pub torque: Vec<(Gear, TorqueTable)>,
    /// Table 1 per gear at the test angle, forward first.
    pub accel: Vec<(Gear, AccelTable)>,
}

impl Source {
    /// Reads `table1.json`, `table2.json` and the CSV files that they describe from `folder`.
    ///
    /// # Errors
    /// A file that is missing or cannot be read; a CSV or a `table1.json` whose hash is not the one told; a JSON whose numbers are not
    /// those of its CSV; no map at the test angle.
    pub fn read(folder: &Path) -> Result<Self> {
        Self::read_at(folder, None)
    }

    /// The same for the maps at a wheel angle [°], by default the test angle.
    ///
    /// # Errors
    /// As [`Source::read`].
    pub fn read_at(folder: &Path, wheel_angle_deg: Option<f64>) -> Result<Self> {
        let text = |name: &str| {
            let path = folder.join(name);
            std::fs::read_to_string(&path).map_err(|source| Error::Read { path, source })
        };
        let at = |name: &str, source| Error::File { path: folder.join(name), source };
        let (json1, json2) = (text("table1.json")?, text("table2.json")?);
        let mut table2 = Table2File::from_json(&json2).map_err(|e| at("table2.json", e))?;
        expect_hash(folder, "table1.json", json1.as_bytes(), "table2.json", &table2.table1.sha256)?;
        let table1 = Table1File::from_json(&json1).map_err(|e| at("table1.json", e))?;
        let matrix = |csv: &CsvRef, by: &str| -> Result<Matrix> {
            let bytes = text(&csv.file)?;
            expect_hash(folder, &csv.file, bytes.as_bytes(), by, &csv.sha256)?;
            Matrix::from_csv(&bytes).map_err(|e| at(&csv.file, e))
        };
        let differs = |json: &str, csv: &CsvRef| Error::Differs { path: folder.join(json), csv: folder.join(&csv.file) };
        let angle_deg = wheel_angle_deg.unwrap_or(table2.vehicle.test_angle_deg);
        let (mut torque, mut accel) = (Vec::new(), Vec::new());
        for gear in Gear::ALL {
            if let Some(map) = table2.map(gear, angle_deg, SAME_ANGLE_DEG) {
                let table = map.table().map_err(|e| at("table2.json", e))?;
                if matrix(&map.csv, "table2.json")? != table.to_matrix() {
                    return Err(differs("table2.json", &map.csv));
                }
                torque.push((gear, table));
            }
            if let Some(map) = table1.map(gear, angle_deg, SAME_ANGLE_DEG) {
                let table = map.table().map_err(|e| at("table1.json", e))?;
                if matrix(&map.csv, "table1.json")? != table.to_matrix() {
                    return Err(differs("table1.json", &map.csv));
                }
                accel.push((gear, table));
            }
        }
        let mut other_angles_deg: Vec<f64> = table2.maps.iter().map(|m| m.wheel_angle_deg).collect();
        other_angles_deg.sort_unstable_by(f64::total_cmp);
        other_angles_deg.dedup();
        if torque.is_empty() {
            let found = other_angles_deg.iter().map(|a| format!("{a}°")).collect::<Vec<_>>().join(", ");
            return Err(Error::NoMap { path: folder.join("table2.json"), angle_deg, found });
        }
        other_angles_deg.retain(|a| (a - angle_deg).abs() > SAME_ANGLE_DEG);
        table2.vehicle.test_angle_deg = angle_deg;
        table2.maps.retain(|m| (m.wheel_angle_deg - angle_deg).abs() <= SAME_ANGLE_DEG);
        Ok(Self { table2, table2_json: json2, torque, accel, other_angles_deg })
    }

    /// The torque that is 100 % of a pedal [N·m]: the vehicle's limit, or without one the largest torque in Table 2.
    pub fn full_torque_nm(&self) -> f64 {
        self.table2.vehicle.torque_limit_nm.unwrap_or_else(|| {
            let values = self.torque.iter().flat_map(|(_, table)| table.values());
            values.fold(0.0, |largest, value| value.abs().max(largest))
        })
    }

    /// What `table2.json` tells of the map of `gear` at the test angle.
    pub fn map(&self, gear: Gear) -> Option<&TorqueMap> {
        self.table2.map(gear, self.table2.vehicle.test_angle_deg, SAME_ANGLE_DEG)
    }

    /// Torques [N·m] at which a resting wheel stays at rest in `gear`, low and high.
    pub fn dead_band_nm(&self, gear: Gear) -> Option<[f64; 2]> {
        self.map(gear).map(|map| [map.dead_band.low_nm, map.dead_band.high_nm])
    }
}

fn expect_hash(folder: &Path, name: &str, bytes: &[u8], by: &str, expected: &str) -> Result<()> {
    let found = sha256_hex(bytes);
    if found == expected {
        return Ok(());
    }
    Err(Error::Hash { path: folder.join(name), by: folder.join(by), found, expected: expected.to_owned() })
}
