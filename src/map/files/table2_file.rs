//! `table2.json`: Table 2 with everything that is not in its CSV.

use crate::map::files::format::{TABLE2_FORMAT, parse_file};
use crate::map::files::identified_drive::IdentifiedDrive;
use crate::map::files::log_ref::LogRef;
use crate::map::files::named;
use crate::map::files::shape::ArrayField;
use crate::map::files::status::ZeroRow;
use crate::map::files::table1_file::{CsvRef, Units};
use crate::map::{ACCEL_AXIS, AngleFamily, Axis, CellStatus, Gear, RawUnits, Result, SPEED_AXIS, TorqueTable, Vehicle, WheelAngle};
use serde::{Deserialize, Serialize};

/// `table2.json`: one [`TorqueMap`] per gear and wheel angle, and where they come from.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Table2File {
    /// Always `pivot-cal/table2`.
    pub format: String,
    /// Version of this layout.
    pub format_version: u32,
    /// Version of the program that wrote the file.
    pub tool_version: String,
    /// Identifier of the generation, that of the Table 1 behind the file; empty in files of versions before it.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub generation: String,
    /// Why the map must not be deployed; only in a file of `export --unverified`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unverified: Option<String>,
    /// Units of every number whose name does not give them.
    pub units: Units,
    /// The vehicle.
    pub vehicle: Vehicle,
    /// The logs behind Table 1.
    pub logs: Vec<LogRef>,
    /// The `table1.json` that was inverted.
    pub table1: CsvRef,
    /// Settings of the inversion, as used.
    pub settings: serde_json::Value,
    /// Dead time of the drive [s].
    pub dead_time_s: f64,
    /// Time constant of the drive's lag [s].
    pub lag_s: f64,
    /// The drive, where it is more than a first-order lag; the lag is then that of the nearest one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub drive: Option<IdentifiedDrive>,
    /// Raw units in which breaks and torques are whole counts of 16 bits; absent if they are any numbers.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub raw: Option<RawUnits>,
    /// The tables.
    pub maps: Vec<TorqueMap>,
    /// The common part of a gear's maps at several wheel angles; none with one angle.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub families: Vec<AngleFamily>,
}

/// Table 2 of one gear and wheel angle. Rows are speeds, columns desired accelerations.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TorqueMap {
    /// Gear, in whose frame all numbers are.
    pub gear: Gear,
    /// Wheel angle [°], left positive.
    pub wheel_angle_deg: f64,
    /// The CSV with the same numbers.
    pub csv: CsvRef,
    /// Speed breaks [m/s].
    pub speed_mps: Vec<f64>,
    /// Breaks of the desired acceleration [m/s²].
    pub accel_mps2: Vec<f64>,
    /// Torque [N·m].
    pub torque_nm: Vec<Vec<f64>>,
    /// Standard error of the torque [N·m], with the distance of the node from the exact inverse at its place; null where the cell is unreachable.
    pub std_err_nm: Vec<Vec<Option<f64>>>,
    /// Source of the value.
    pub status: Vec<Vec<CellStatus>>,
    /// Per speed break the lowest and highest acceleration [m/s²] that the torque limits allow.
    pub reachable_accel_mps2: Vec<[f64; 2]>,
    /// Torques at which a resting wheel stays at rest.
    pub dead_band: DeadBand,
    /// How the row at speed 0 was made.
    #[serde(with = "named")]
    pub zero_row: ZeroRow,
    /// The error by the grid: A(v, Table 2(v, a)) − a over the measured range.
    pub round_trip: RoundTripErrors,
}

/// Torques [N·m] at which a resting wheel stays at rest, gear frame.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct DeadBand {
    /// Lower end, negative.
    pub low_nm: f64,
    /// Upper end: the breakaway torque.
    pub high_nm: f64,
    /// Standard error of the upper end; absent when only bounds are known.
    pub std_err_nm: Option<f64>,
}

/// A(v, Table 2(v, a)) − a [m/s²].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RoundTripErrors {
    /// Root mean square at the nodes.
    pub node_rms_mps2: f64,
    /// Largest at the nodes.
    pub node_max_mps2: f64,
    /// Where the largest one at the nodes is.
    pub node_max_at: GridPoint,
    /// Root mean square over a dense grid between the nodes.
    pub between_rms_mps2: f64,
    /// Largest between the nodes.
    pub between_max_mps2: f64,
    /// Where the largest one between the nodes is.
    pub between_max_at: GridPoint,
}

/// A point of Table 2, at a node or between nodes.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct GridPoint {
    /// Speed [m/s].
    pub speed_mps: f64,
    /// Desired acceleration [m/s²].
    pub accel_mps2: f64,
}

impl Table2File {
    /// Reads the JSON text.
    ///
    /// # Errors
    /// Not JSON, another format, an unknown version, a missing or misplaced field, a text that is not allowed, an array whose size is not
    /// that of its axes, or tables that [`TorqueTable::new`] refuses.
    pub fn from_json(text: &str) -> Result<Self> {
        let file: Self = parse_file(text, TABLE2_FORMAT)?;
        file.vehicle.checked()?;
        file.maps.iter().enumerate().try_for_each(|(k, map)| map.check(&format!("maps[{k}]")))?;
        file.families.iter().try_for_each(AngleFamily::check)?;
        Ok(file)
    }

    /// The JSON text, indented, with arrays of numbers on one line and a final line end.
    ///
    /// # Errors
    /// None in practice; serialisation is fallible by its signature.
    pub fn to_json(&self) -> Result<String> {
        crate::map::files::json_text::to_text(self)
    }

    /// The map of a gear at a wheel angle.
    pub fn map(&self, gear: Gear, angle: WheelAngle) -> Option<&TorqueMap> {
        self.maps.iter().find(|m| m.gear == gear && m.angle().is_same(angle))
    }

    /// The map of a gear at the test angle.
    pub fn map_at_test_angle(&self, gear: Gear) -> Option<&TorqueMap> {
        self.map(gear, self.vehicle.test_angle())
    }

    /// Whether the maps belong to more than one wheel angle.
    pub fn has_several_angles(&self) -> bool {
        WheelAngle::several(self.maps.iter().map(|m| m.wheel_angle_deg))
    }
}

impl TorqueMap {
    /// The wheel angle of the map.
    pub fn angle(&self) -> WheelAngle {
        WheelAngle::from_deg(self.wheel_angle_deg)
    }

    /// Every array against the axes; `place` is the map in errors.
    fn check(&self, place: &str) -> Result<()> {
        self.table()?;
        let field = |name| ArrayField { map: place, name };
        let (rows, columns) = (self.speed_mps.len(), self.accel_mps2.len());
        field("torque_nm").expect_numbers(rows, columns, &self.torque_nm)?;
        field("std_err_nm").expect_cells(rows, columns, &self.std_err_nm)?;
        field("status").expect_cells(rows, columns, &self.status)?;
        field("reachable_accel_mps2").expect_len("", rows, self.reachable_accel_mps2.len())?;
        field("wheel_angle_deg").expect_finite("", self.wheel_angle_deg)?;
        field("dead_band.low_nm").expect_finite("", self.dead_band.low_nm)?;
        field("dead_band.high_nm").expect_finite("", self.dead_band.high_nm)
    }

    /// The table itself.
    ///
    /// # Errors
    /// As [`Axis::new`] and [`TorqueTable::new`].
    pub fn table(&self) -> Result<TorqueTable> {
        let speed = Axis::new(SPEED_AXIS, self.speed_mps.clone())?;
        let accel = Axis::new(ACCEL_AXIS, self.accel_mps2.clone())?;
        TorqueTable::new(speed, accel, self.torque_nm.concat())
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use serde_json::Value;

    fn error_after(change: impl Fn(&mut Value)) -> String {
        let mut json: Value = serde_json::from_str(include_str!("../../../maps/table2.json")).unwrap();
        change(&mut json);
        Table2File::from_json(&json.to_string()).unwrap_err().to_string()
    }

    #[test]
    fn every_array_of_a_map_must_have_the_size_of_its_axes() {
        for field in ["std_err_nm", "status"] {
            let short_row = error_after(|json| drop(json["maps"][0][field][2].as_array_mut().unwrap().pop()));
            assert!(short_row.starts_with(&format!("maps[0].{field}[2] has ")), "{short_row}");
        }
        for field in ["std_err_nm", "status", "reachable_accel_mps2"] {
            let missing_row = error_after(|json| drop(json["maps"][1][field].as_array_mut().unwrap().pop()));
            assert!(missing_row.starts_with(&format!("maps[1].{field} has ")), "{missing_row}");
        }
        assert!(error_after(|json| drop(json["maps"][0]["torque_nm"].as_array_mut().unwrap().pop())).starts_with("Table 2 has "));
    }

    #[test]
    fn a_row_at_speed_0_of_another_kind_is_refused() {
        let error = error_after(|json| json["maps"][0]["zero_row"] = "still".into());
        assert!(error.contains("zero_row is \"still\"; allowed: moving, hold"), "{error}");
    }

    #[test]
    fn a_file_that_is_read_and_written_keeps_its_bytes() {
        let text = include_str!("../../../maps/table2.json");
        assert!(Table2File::from_json(text).unwrap().to_json().unwrap() == text);
    }
}
