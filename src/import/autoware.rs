//! Autoware's maps: acceleration over pedal and speed. With the torque that is the full pedal they are a Table 1, of which accel and brake map
//! are the two halves.

use crate::import::error::TextFault;
use crate::import::foreign::{CellGrid, CsvLine, Pedal, grid_of_autoware};
use crate::import::full_scale::FullScale;
use crate::import::imported::{ImportedAccelPoint, ImportedAccelTable, ImportedPoint, ImportedTable};
use crate::import::number::WrittenNumber;
use crate::map::Gear;

/// What the corner cell of our own maps begins with.
const CORNER: &str = "pivot-cal torque_nm/";

/// Whether a CSV with this corner cell in a file of this name is a pedal map. Autoware's own say `default` there.
pub(crate) fn says_pedal_map(name: &str, corner: &str) -> bool {
    let name = name.to_ascii_lowercase();
    corner.starts_with(CORNER) || corner == "default" || name.contains("accel_map") || name.contains("brake_map")
}

/// The name of the other pedal's map.
pub(crate) fn other_pedal(name: &str) -> Option<String> {
    let other = if name.contains("accel") { name.replace("accel", "brake") } else { name.replace("brake", "accel") };
    (other != name).then_some(other)
}

/// The table of one map, or of both halves: each with its file's name.
pub(crate) fn read(halves: &[(&str, &[CsvLine])], gear: Gear, full: FullScale) -> Result<ImportedAccelTable, TextFault> {
    let mut points: Vec<ImportedAccelPoint> = Vec::new();
    for (name, cells) in halves {
        for point in half(name, cells, full)? {
            // both halves have the row without pedal
            let is_known = |p: &ImportedAccelPoint| p.torque_nm == point.torque_nm && p.speed_mps == point.speed_mps;
            if !points.iter().any(is_known) {
                points.push(point);
            }
        }
    }
    points.sort_by(|a, b| a.torque_nm.total_cmp(&b.torque_nm).then(a.speed_mps.total_cmp(&b.speed_mps)));
    Ok(ImportedAccelTable { gear, points })
}

fn half(name: &str, cells: &[CsvLine], full: FullScale) -> Result<Vec<ImportedAccelPoint>, TextFault> {
    let (pedal, grid, misread) = grid_of_autoware(name, cells);
    if let Some(first) = misread.first() {
        return Err(TextFault::at(first.line, first.what.clone()));
    }
    let full_nm = full_torque(&grid).or(full.torque_nm).ok_or_else(|| {
        let what = format!("the corner cell is {:?}; pedals need the torque that is the full pedal: --torque-full-scale", grid.corner);
        TextFault::at(1, what)
    })?;
    let sign = if pedal == Pedal::Accel { 1.0 } else { -1.0 };
    let mut points = Vec::new();
    for (row, pedal) in grid.row_breaks.iter().enumerate() {
        for (column, speed) in grid.column_breaks.iter().enumerate() {
            let text = cells.get(row + 1).and_then(|line| line.texts.get(column + 1));
            let (Some(pedal), Some(speed_mps), Some(accel_mps2)) = (pedal, speed, text.and_then(|text| WrittenNumber::parse(text))) else {
                continue;
            };
            points.push(ImportedAccelPoint { torque_nm: sign * pedal * full_nm + 0.0, speed_mps: *speed_mps, accel_mps2 });
        }
    }
    Ok(points)
}

/// `pivot-cal torque_nm/44 UNVERIFIED`.
fn full_torque(grid: &CellGrid) -> Option<f64> {
    grid.corner.strip_prefix(CORNER)?.split_whitespace().next()?.parse().ok().filter(|full: &f64| *full > 0.0)
}

impl ImportedAccelTable {
    /// The same as a table of torques: the torque of each acceleration, at each speed.
    pub(crate) fn inverted(&self) -> ImportedTable {
        let mut points: Vec<ImportedPoint> = self
            .points
            .iter()
            .map(|p| ImportedPoint {
                speed_mps: p.speed_mps,
                accel_mps2: p.accel_mps2.value,
                torque_nm: WrittenNumber { value: p.torque_nm, last_digit: 0.0 },
            })
            .collect();
        points.sort_by(|a, b| a.speed_mps.total_cmp(&b.speed_mps).then(a.accel_mps2.total_cmp(&b.accel_mps2)));
        ImportedTable { gear: self.gear, points }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::import::foreign::cells_of_csv;

    #[test]
    fn two_halves_are_one_table_with_the_shared_row_once() {
        let accel = cells_of_csv("pivot-cal torque_nm/40 UNVERIFIED,0,1\n0,-0.1,-0.25\n0.5,1,0.75\n");
        let brake = cells_of_csv("default,0,1\n0,-0.1,-0.25\n0.25,-1,-1.125\n");
        let full = FullScale { torque_nm: Some(40.0), wheel_radius_m: 0.1 };
        let table = read(&[("accel_map.csv", &accel), ("brake_map.csv", &brake)], Gear::Forward, full).unwrap();
        let points: Vec<_> = table.points.iter().map(|p| (p.torque_nm, p.speed_mps, p.accel_mps2.value)).collect();
        assert_eq!(
            points,
            [(-10.0, 0.0, -1.0), (-10.0, 1.0, -1.125), (0.0, 0.0, -0.1), (0.0, 1.0, -0.25), (20.0, 0.0, 1.0), (20.0, 1.0, 0.75)]
        );
        let torques: Vec<_> = table.inverted().points.iter().map(|p| p.torque_nm.value).collect();
        assert_eq!(torques, [-10.0, 0.0, 20.0, -10.0, 0.0, 20.0]);
        let unknown = FullScale { torque_nm: None, ..full };
        assert!(read(&[("brake_map.csv", &brake)], Gear::Forward, unknown).unwrap_err().what.contains("--torque-full-scale"));
    }
}
