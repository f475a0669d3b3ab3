//! The map to export, from files that belong together.

use crate::export::lateral_source::LateralSource;
use crate::export::{Error, Proof, Result};
use crate::map::{
    AccelTable, CsvRef, Gear, MapFolder, Matrix, Mismatch, StoredFile, Table1File, Table2File, TorqueMap, TorqueTable, WheelAngle,
};
use std::path::Path;

/// A map whose hashes match.
#[derive(Debug, Clone, PartialEq)]
pub struct MapSource {
    /// The `table2.json`, with the maps at one wheel angle, its test angle.
    pub table2: Table2File,
    /// Its text, byte for byte.
    pub table2_json: String,
    /// The `table1.json` from which it was made.
    pub table1: Table1File,
    /// Wheel angles [°] whose maps `table2.json` also holds.
    pub other_angles_deg: Vec<f64>,
    /// Table 2 per gear at the test angle, forward first. Never empty.
    pub torque: Vec<(Gear, TorqueTable)>,
    /// Table 1 per gear at the test angle, forward first.
    pub accel: Vec<(Gear, AccelTable)>,
    /// Whether the map may be deployed.
    pub proof: Proof,
    /// The lateral compensation, if the folder has its table.
    pub(crate) lateral: Option<LateralSource>,
}

impl MapSource {
    /// Reads `table1.json`, `table2.json` and the CSV files that they describe from `folder`.
    ///
    /// A map without a verdict is not an error: see [`MapSource::proof`].
    ///
    /// # Errors
    /// A file that is missing or cannot be read; a CSV or a `table1.json` whose hash differs; a JSON whose numbers are not
    /// those of its CSV; no map at the test angle.
    pub fn read(folder: &Path) -> Result<Self> {
        Self::read_at(folder, None)
    }

    /// The same for the maps at a wheel angle [°], by default the test angle.
    ///
    /// # Errors
    /// As [`MapSource::read`].
    pub fn read_at(folder: &Path, wheel_angle_deg: Option<f64>) -> Result<Self> {
        let (mut files, mut mismatches) = MapFolder::read(&folder.into())?;
        let Some((mut table2, json2)) = files.table2.take() else {
            let absent = mismatches.into_iter().next();
            return Err(absent.map_or_else(|| unread(folder, "table2.json", std::io::ErrorKind::NotFound.into()), |m| mismatch(folder, m)));
        };
        let table1 = &files.table1;
        let at = |name: &str, source| Error::File { path: folder.join(name), source };
        let mut belongs = |name: &str, by: &str| match mismatches.iter().position(|m| m.file() == name && m.by() == by) {
            Some(k) => Err(mismatch(folder, mismatches.remove(k))),
            None => Ok(()),
        };
        belongs("table1.json", "table2.json")?;
        // a CSV must be the one that its JSON describes, and hold the JSON's numbers
        let mut expect = |json: &'static str, csv: &CsvRef, table: Matrix| {
            belongs(&csv.file, json)?;
            let text = files.csv(&csv.file).map_or(Ok(""), StoredFile::text).map_err(|e| unread(folder, &csv.file, e))?;
            let found = Matrix::from_csv(text).map_err(|e| at(&csv.file, e))?;
            if found == table { Ok(()) } else { Err(Error::Differs { path: folder.join(json), csv: folder.join(&csv.file) }) }
        };
        let angle = wheel_angle_deg.map_or(table2.vehicle.test_angle(), WheelAngle::from_deg);
        let (mut torque, mut accel) = (Vec::new(), Vec::new());
        for gear in Gear::ALL {
            if let Some(map) = table2.map(gear, angle) {
                let table = map.table().map_err(|e| at("table2.json", e))?;
                expect("table2.json", &map.csv, table.to_matrix())?;
                torque.push((gear, table));
            }
            if let Some(map) = table1.map(gear, angle) {
                let table = map.table().map_err(|e| at("table1.json", e))?;
                expect("table1.json", &map.csv, table.to_matrix())?;
                accel.push((gear, table));
            }
        }
        let csvs: Vec<CsvRef> = table2.maps.iter().map(|m| m.csv.clone()).collect();
        let proof = Proof::of(&files, &csvs)?;
        let mut other_angles_deg: Vec<f64> = table2.maps.iter().map(|m| m.wheel_angle_deg).collect();
        other_angles_deg.sort_unstable_by(f64::total_cmp);
        other_angles_deg.dedup();
        if torque.is_empty() {
            let found = other_angles_deg.iter().map(|a| format!("{a}°")).collect::<Vec<_>>().join(", ");
            return Err(Error::NoMap { path: folder.join("table2.json"), angle_deg: angle.deg(), found });
        }
        other_angles_deg.retain(|a| !angle.is_same_deg(*a));
        table2.vehicle.test_angle_deg = angle.deg();
        table2.maps.retain(|m| m.angle().is_same(angle));
        let lateral = match files.lateral()? {
            Some((_, Some(wrong))) => return Err(mismatch(folder, wrong)),
            Some((file, None)) => Some(LateralSource::new(file)?),
            None => None,
        };
        let table2_json = json2.text().map_err(|e| unread(folder, "table2.json", e))?.to_owned();
        Ok(Self { table2, table2_json, table1: files.table1.clone(), other_angles_deg, torque, accel, proof, lateral })
    }

    /// The torque that is 100 % of a pedal [N·m]: the vehicle's limit, or without one the largest torque in Table 2.
    pub fn full_torque_nm(&self) -> f64 {
        let values = self.torque.iter().flat_map(|(_, table)| table.values());
        self.table2.vehicle.torque_limit_or_largest_nm(values.copied())
    }

    /// The map of `gear` in `table2.json` at the test angle.
    pub fn map(&self, gear: Gear) -> Option<&TorqueMap> {
        self.table2.map_at_test_angle(gear)
    }

    /// Torques [N·m] at which a resting wheel stays at rest in `gear`, low and high.
    pub fn dead_band_nm(&self, gear: Gear) -> Option<[f64; 2]> {
        self.map(gear).map(|map| [map.dead_band.low_nm, map.dead_band.high_nm])
    }
}

fn mismatch(folder: &Path, mismatch: Mismatch) -> Error {
    match mismatch {
        Mismatch::Hash { file, by, found, expected } => Error::Hash { path: folder.join(file), by: folder.join(by), found, expected },
        Mismatch::Generation { file, by, found, expected } => {
            Error::Generation { path: folder.join(file), by: folder.join(by), generations: format!("{found}, {expected}") }
        }
        Mismatch::Unreadable { file, source, .. } => unread(folder, &file, source),
    }
}

fn unread(folder: &Path, name: &str, source: std::io::Error) -> Error {
    Error::Read { path: folder.join(name), source }
}
