//! The comparison itself.

use crate::diff::comparison::{DiffSettings, DiffVerdict, MapComparison, MapDiff, Significant};
use crate::diff::sheet::{DiffSide, Sheet, Table};
use crate::diff::significance::{threshold, two_sided_p};
use crate::map::WheelAngle;

/// Lengths of a vehicle that differ by a smaller share are equal.
const SAME_LENGTH: f64 = 1e-3;
/// Least standard error of a difference, in the values' unit: files hold six decimals, so a smaller one is rounding.
const LEAST_STD_ERR: f64 = 1e-6;

/// Compares `b` with `a`.
pub(crate) fn compare(a: &DiffSide, b: &DiffSide, settings: &DiffSettings) -> MapComparison {
    let reasons = differences(a, b);
    let mut comparison = MapComparison {
        a: a.name.clone(),
        b: b.name.clone(),
        table: a.table,
        verdict: DiffVerdict::Incompatible,
        matters: 0,
        reasons,
        notes: notes(a, b),
        settings: *settings,
        threshold_p: None,
        maps: Vec::new(),
    };
    if !comparison.reasons.is_empty() {
        return comparison;
    }
    let mut found: Vec<(MapDiff, Vec<Significant>)> = Vec::new();
    for sheet in &a.sheets {
        if let Some(other) = matching(sheet, &b.sheets) {
            found.push(differ(sheet, other, a.table));
        }
    }
    let p_values: Vec<f64> = found.iter().flat_map(|(_, cells)| cells.iter().map(|c| c.p)).collect();
    if p_values.is_empty() {
        comparison.reasons.push("no cell is known in both: their axes do not overlap, or what overlaps is extrapolated".to_owned());
        return comparison;
    }
    comparison.threshold_p = threshold(&p_values, settings.false_discovery_rate);
    for (mut map, cells) in found {
        let mut largest: Vec<_> = cells.into_iter().filter(|c| comparison.threshold_p.is_some_and(|t| c.p <= t)).collect();
        largest.sort_by(|x, y| y.z.abs().total_cmp(&x.z.abs()).then(x.row.total_cmp(&y.row)).then(x.column.total_cmp(&y.column)));
        map.significant = largest.len();
        map.matters = largest.iter().filter(|c| c.accel_mps2.abs() > settings.matters_mps2).count();
        map.largest = largest;
        comparison.matters += map.matters;
        comparison.maps.push(map);
    }
    comparison.verdict = if comparison.threshold_p.is_some() { DiffVerdict::Changed } else { DiffVerdict::Same };
    comparison
}

fn matching<'a>(sheet: &Sheet, others: &'a [Sheet]) -> Option<&'a Sheet> {
    others.iter().find(|o| o.gear == sheet.gear && WheelAngle::from_deg(o.wheel_angle_deg).is_same_deg(sheet.wheel_angle_deg))
}

/// Why the two cannot be compared.
fn differences(a: &DiffSide, b: &DiffSide) -> Vec<String> {
    let mut reasons = Vec::new();
    if a.table != b.table {
        reasons.push(format!("{} is {:?}, {} is {:?}", a.name, a.table, b.name, b.table));
    }
    let (va, vb) = (a.vehicle, b.vehicle);
    for (what, x, y) in [("wheelbase", va.wheelbase_m, vb.wheelbase_m), ("wheel radius", va.wheel_radius_m, vb.wheel_radius_m)] {
        if (x - y).abs() > SAME_LENGTH * x.abs() {
            reasons.push(format!("another vehicle: {what} {x} m and {y} m"));
        }
    }
    if reasons.is_empty() && !a.sheets.iter().any(|sheet| matching(sheet, &b.sheets).is_some()) {
        let maps = |side: &DiffSide| {
            side.sheets.iter().map(|s| format!("{} gear at {}°", s.gear, s.wheel_angle_deg)).collect::<Vec<_>>().join(", ")
        };
        reasons.push(format!("no gear and wheel angle in common: {} and {}", maps(a), maps(b)));
    }
    reasons
}

fn notes(a: &DiffSide, b: &DiffSide) -> Vec<String> {
    let mut notes = Vec::new();
    let shared = a.logs.iter().filter(|log| b.logs.iter().any(|other| other.sha256 == log.sha256)).count();
    if shared > 0 {
        notes.push(format!(
            "both maps were made from the same {shared} log(s): the errors of those logs are in both, so that the standard errors of the changes are too large"
        ));
    }
    if a.vehicle.torque_limit_nm != b.vehicle.torque_limit_nm {
        let shown = |limit: Option<f64>| limit.map_or("none".to_owned(), |l| format!("{l} N·m"));
        notes.push(format!("torque limit {} and {}", shown(a.vehicle.torque_limit_nm), shown(b.vehicle.torque_limit_nm)));
    }
    for (side, other) in [(a, b), (b, a)] {
        for sheet in side.sheets.iter().filter(|sheet| matching(sheet, &other.sheets).is_none()) {
            notes.push(format!("{} gear at {}° is in {} only", sheet.gear, sheet.wheel_angle_deg, side.name));
        }
    }
    notes
}

/// Change per cell of `a`, and every compared cell.
fn differ(a: &Sheet, b: &Sheet, table: Table) -> (MapDiff, Vec<Significant>) {
    let width = a.columns.len();
    let empty = || vec![vec![None; width]; a.rows.len()];
    let (mut change, mut std_err, mut z, mut cells) = (empty(), empty(), empty(), Vec::new());
    for (i, &row) in a.rows.iter().enumerate() {
        for (j, &column) in a.columns.iter().enumerate() {
            let (Some((x, x_err)), Some((y, y_err))) = (a.at(row, column), b.at(row, column)) else { continue };
            let delta = y - x;
            let error = x_err.hypot(y_err).max(LEAST_STD_ERR);
            let score = delta / error;
            (change[i][j], std_err[i][j], z[i][j]) = (Some(delta), Some(error), Some(score));
            let accel_mps2 = if table == Table::Table1 { delta } else { delta / slope(a, i, j) };
            cells.push(Significant { row, column, a: x, b: y, change: delta, std_err: error, z: score, p: two_sided_p(score), accel_mps2 });
        }
    }
    let rms = |of: fn(&Significant) -> f64| (cells.iter().map(|c| of(c).powi(2)).sum::<f64>() / (cells.len().max(1) as f64)).sqrt();
    let map = MapDiff {
        gear: a.gear,
        wheel_angle_deg: a.wheel_angle_deg,
        interpolated: a.rows != b.rows || a.columns != b.columns,
        compared: cells.len(),
        left_out: a.values.len() - cells.len(),
        significant: 0,
        matters: 0,
        rms_change: rms(|c| c.change),
        rms_z: rms(|c| c.z),
        largest: Vec::new(),
        rows: a.rows.clone(),
        columns: a.columns.clone(),
        change,
        std_err,
        z,
    };
    (map, cells)
}

/// Torque per acceleration around cell (i, j) of a Table 2, from its neighbours; infinite on a plateau, where a change of torque is worth
/// no acceleration.
fn slope(sheet: &Sheet, i: usize, j: usize) -> f64 {
    let (low, high) = (j.saturating_sub(1), (j + 1).min(sheet.columns.len() - 1));
    let value = |k: usize| sheet.values[i * sheet.columns.len() + k];
    let slope = (value(high) - value(low)) / (sheet.columns[high] - sheet.columns[low]);
    if slope > 0.0 { slope } else { f64::INFINITY }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::Gear;

    /// Two speeds by three accelerations, each torque with a standard error of 0.3 N·m.
    fn sheet(values: [f64; 6]) -> Sheet {
        Sheet {
            gear: Gear::Forward,
            wheel_angle_deg: 90.0,
            rows: vec![0.0, 1.0],
            columns: vec![-1.0, 0.0, 1.0],
            values: values.to_vec(),
            std_err: vec![0.3; 6],
            known: vec![1.0; 6],
        }
    }

    const TORQUES: [f64; 6] = [-10.0, 0.0, 20.0, -8.0, 2.0, 2.0];

    #[test]
    fn torque_per_acceleration_comes_from_the_neighbours_and_is_infinite_on_a_plateau() {
        let mut sheet = sheet(TORQUES);
        assert_eq!(slope(&sheet, 0, 0), 10.0);
        assert_eq!(slope(&sheet, 0, 1), 15.0);
        assert_eq!(slope(&sheet, 0, 2), 20.0);
        assert_eq!(slope(&sheet, 1, 2), f64::INFINITY);
        sheet.columns[2] = 3.0;
        assert_eq!(slope(&sheet, 0, 1), 7.5);
    }

    #[test]
    fn a_change_is_judged_against_the_standard_errors_of_both_maps_and_worth_an_acceleration() {
        let a = sheet(TORQUES);
        let mut b = a.clone();
        b.values[1] += 3.0;
        b.std_err[1] = 0.4;
        let (map, cells) = differ(&a, &b, Table::Table2);
        let changed = cells[1];
        assert!((changed.std_err - 0.5).abs() < 1e-12 && (changed.z - 6.0).abs() < 1e-12, "{changed:?}");
        assert!((changed.accel_mps2 - 3.0 / 15.0).abs() < 1e-12, "{changed:?}");
        assert!((map.rms_change - (9.0f64 / 6.0).sqrt()).abs() < 1e-12);
        assert_eq!((map.compared, map.left_out, map.interpolated), (6, 0, false));
        let (_, cells) = differ(&a, &b, Table::Table1);
        assert_eq!(cells[1].accel_mps2, 3.0, "a change of Table 1 is an acceleration itself");
    }

    #[test]
    fn a_cell_that_is_not_known_in_both_is_left_out() {
        let (mut a, mut b) = (sheet(TORQUES), sheet(TORQUES));
        a.known[0] = 0.0;
        b.known[5] = 0.0;
        let (map, cells) = differ(&a, &b, Table::Table2);
        assert_eq!((map.compared, map.left_out, cells.len()), (4, 2, 4));
        assert!(map.z[0][0].is_none() && map.z[1][2].is_none() && map.z[0][1].is_some());
    }
}
