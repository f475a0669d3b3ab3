//! A map that was read: its points per gear, and the table that they form.

use crate::import::number::WrittenNumber;
use crate::map::{ACCEL_AXIS, Axis, Gear, SPEED_AXIS, TorqueTable};

/// A point of a map in SI units, gear frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ImportedPoint {
    /// Speed [m/s].
    pub(crate) speed_mps: f64,
    /// Desired acceleration [m/s²].
    pub(crate) accel_mps2: f64,
    /// Torque [N·m], with the worth of its last digit.
    pub(crate) torque_nm: WrittenNumber,
}

/// The points of one gear, by speed, each row by acceleration.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct ImportedTable {
    /// Gear.
    pub(crate) gear: Gear,
    /// The points.
    pub(crate) points: Vec<ImportedPoint>,
}

/// A point of a Table 1 in SI units, gear frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ImportedAccelPoint {
    /// Torque [N·m].
    pub(crate) torque_nm: f64,
    /// Speed [m/s].
    pub(crate) speed_mps: f64,
    /// Acceleration [m/s²], with the worth of its last digit.
    pub(crate) accel_mps2: WrittenNumber,
}

/// The points of one gear, by torque, each row by speed.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct ImportedAccelTable {
    /// Gear.
    pub(crate) gear: Gear,
    /// The points.
    pub(crate) points: Vec<ImportedAccelPoint>,
}

/// A map that was read.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct ImportedMap {
    /// Name of the format.
    pub(crate) format: &'static str,
    /// SHA-256 of the file.
    pub(crate) sha256: String,
    /// Its tables, forward first; of a Table 1 their inverses.
    pub(crate) tables: Vec<ImportedTable>,
    /// Its tables if they are Table 1s, as Autoware's.
    pub(crate) accel_tables: Vec<ImportedAccelTable>,
}

/// Breaks that differ by less are one [m/s or m/s²].
const SAME_BREAK: f64 = 1e-9;

impl ImportedTable {
    /// From a matrix: a row of torques per speed.
    pub(crate) fn of_matrix(gear: Gear, speeds: &[f64], accels: &[f64], torques: &[WrittenNumber]) -> Self {
        let places = speeds.iter().flat_map(|v| accels.iter().map(move |a| (*v, *a)));
        let points =
            places.zip(torques).map(|((speed_mps, accel_mps2), torque_nm)| ImportedPoint { speed_mps, accel_mps2, torque_nm: *torque_nm });
        Self { gear, points: points.collect() }
    }

    /// The table on all speeds and accelerations of the points; a row that lacks an acceleration is interpolated, and level beyond its ends.
    ///
    /// # Errors
    /// Points that form no table.
    pub(crate) fn table(&self) -> crate::map::Result<TorqueTable> {
        let breaks = |of: fn(&ImportedPoint) -> f64| {
            let mut breaks: Vec<f64> = self.points.iter().map(of).collect();
            breaks.sort_by(f64::total_cmp);
            breaks.dedup_by(|b, a| *b - *a < SAME_BREAK);
            breaks
        };
        let (speeds, accels) = (breaks(|p| p.speed_mps), breaks(|p| p.accel_mps2));
        let mut values = Vec::new();
        for speed in &speeds {
            let mut row: Vec<&ImportedPoint> = self.points.iter().filter(|p| (p.speed_mps - speed).abs() < SAME_BREAK).collect();
            row.sort_by(|a, b| a.accel_mps2.total_cmp(&b.accel_mps2));
            values.extend(accels.iter().map(|a| interpolated(&row, *a)));
        }
        TorqueTable::new(Axis::new(SPEED_AXIS, speeds)?, Axis::new(ACCEL_AXIS, accels)?, values)
    }
}

fn interpolated(row: &[&ImportedPoint], accel_mps2: f64) -> f64 {
    let k = row.partition_point(|p| p.accel_mps2 < accel_mps2 - SAME_BREAK);
    match (k.checked_sub(1).and_then(|k| row.get(k)), row.get(k)) {
        (_, Some(here)) if (here.accel_mps2 - accel_mps2).abs() < SAME_BREAK => here.torque_nm.value,
        (Some(before), Some(after)) => {
            let share = (accel_mps2 - before.accel_mps2) / (after.accel_mps2 - before.accel_mps2);
            before.torque_nm.value + share * (after.torque_nm.value - before.torque_nm.value)
        }
        (Some(end), None) | (None, Some(end)) => end.torque_nm.value,
        (None, None) => 0.0,
    }
}
