//! The round trip of the CSV against Table 1. It also checks cells that no pivot visits.
//!
//! Δa = A(v, T₂(v, a)) − a must stay within 0.15 m/s² + 3 standard errors of Table 1, and its mean over a row of Table 2 above 0 m/s within
//! 0.05 m/s² + 3: interpolation moves single cells, but not a whole row in the same way. It is checked at each measured cell of Table 1,
//! (v, τ) with a = A(v, τ), and at each node of Table 2, (v, a), whose true torque lies among measured cells. Beyond its torques the
//! surface continues linearly, so that a torque which the drive cannot give is detected too. Places beyond a limit of the drive that the fit
//! found are unreachable, and are not checked. The speed axis must start at 0.

use crate::map::{AccelMap, AccelTable, CellStatus, Gear, Table1File, TorqueTable, WheelAngle, ZeroRow, lookup};
use crate::verify::Maps;
use crate::verify::exact_map::torque_for;
use serde::{Deserialize, Serialize};

/// The gate's limit of |Δa|.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RoundTripLimit {
    /// Constant part [m/s²].
    pub at_most_mps2: f64,
    /// Constant part for the mean over a row of Table 2 [m/s²].
    pub row_mean_at_most_mps2: f64,
    /// Number of standard errors of Table 1 that is added to both.
    pub standard_errors: f64,
    /// Reason.
    #[serde(default)]
    pub reason: String,
}

/// The round trip of one gear.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RoundTripVerdict {
    /// Gear.
    pub gear: Gear,
    /// Wheel angle of the map [°], if it is not the test angle.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub wheel_angle_deg: Option<f64>,
    /// Places checked.
    pub places: usize,
    /// Measured cells of Table 1 whose acceleration lies beyond Table 2's axes and therefore cannot be requested.
    pub beyond_axes: usize,
    /// Places over their limit.
    pub failed: usize,
    /// Speeds [m/s] of the rows whose mean Δa is over its limit.
    pub failed_rows_mps: Vec<f64>,
    /// Whether the speed axis starts at 0, where every pivot starts.
    pub starts_at_zero: bool,
    /// Root mean square of Δa [m/s²].
    pub rms_mps2: f64,
    /// The place that is furthest over its limit, or nearest to it.
    pub worst: Option<Worst>,
    /// Whether there is a place, and every place is within its limit.
    pub pass: bool,
}

/// The worst place.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Worst {
    /// Speed [m/s].
    pub speed_mps: f64,
    /// Requested acceleration [m/s²].
    pub accel_mps2: f64,
    /// Torque that Table 2 gives [N·m].
    pub torque_nm: f64,
    /// True torque [N·m].
    pub right_torque_nm: f64,
    /// Δa [m/s²].
    pub error_mps2: f64,
    /// Limit of |Δa| there [m/s²].
    pub limit_mps2: f64,
}

impl RoundTripVerdict {
    /// Name of the map: `forward gear`, or `forward gear at 30°`.
    pub fn name(&self) -> String {
        self.wheel_angle_deg.map_or_else(|| format!("{} gear", self.gear), |angle| format!("{} gear at {angle}°", self.gear))
    }
}

/// The round trip of every gear that Table 2 has at the test angle, then of the maps at other wheel angles.
///
/// # Errors
/// A surface of Table 1 that is not sound.
pub(crate) fn round_trip(maps: &Maps, limit: &RoundTripLimit) -> crate::verify::Result<Vec<RoundTripVerdict>> {
    let test_angle = maps.table2.vehicle.test_angle();
    let mut all = Vec::new();
    for gear in Gear::ALL {
        let (Some(table2), Some(map1)) = (maps.table(gear), maps.table1.map_at_test_angle(gear)) else { continue };
        let holds = maps.table2.map_at_test_angle(gear).is_some_and(|m| m.zero_row != ZeroRow::Moving);
        all.push(of_gear(gear, table2, (&maps.table1, map1), &map1.surface.table()?, holds, limit));
    }
    for map in maps.angles.iter().filter(|m| !test_angle.is_same_deg(m.wheel_angle_deg)) {
        let Some(map1) = maps.table1.map(map.gear, WheelAngle::from_deg(map.wheel_angle_deg)) else { continue };
        let holds = maps.table2.map(map.gear, map1.angle()).is_some_and(|m| m.zero_row != ZeroRow::Moving);
        let trip = of_gear(map.gear, &map.table, (&maps.table1, map1), &map1.surface.table()?, holds, limit);
        all.push(RoundTripVerdict { wheel_angle_deg: Some(map.wheel_angle_deg), ..trip });
    }
    Ok(all)
}

fn of_gear(
    gear: Gear,
    table2: &TorqueTable,
    (table1, map1): (&Table1File, &AccelMap),
    surface: &AccelTable,
    holds: bool,
    limit: &RoundTripLimit,
) -> RoundTripVerdict {
    let starts_at_zero = table2.speed_mps().first() == 0.0;
    let mut out = RoundTripVerdict {
        gear,
        wheel_angle_deg: None,
        places: 0,
        beyond_axes: 0,
        failed: 0,
        failed_rows_mps: Vec::new(),
        starts_at_zero,
        rms_mps2: 0.0,
        worst: None,
        pass: false,
    };
    let mut excess = f64::NEG_INFINITY;
    let mut check = |out: &mut RoundTripVerdict, speed_mps: f64, accel_mps2: f64, right_torque_nm: f64, std_err_mps2: f64| {
        // a row of a resting wheel gives no information on a wheel that just moves
        if holds && speed_mps == 0.0 && accel_mps2 <= 0.0 {
            return None;
        }
        // what the drive does not deliver is unreachable in Table 2
        if right_torque_nm > table1.delivered_nm(speed_mps) {
            return None;
        }
        let Some(torque_nm) = table2.torque_from_accel(speed_mps, accel_mps2) else {
            out.beyond_axes += 1;
            return None;
        };
        let error_mps2 = extended(surface, speed_mps, torque_nm)? - accel_mps2;
        let limit_mps2 = limit.at_most_mps2 + limit.standard_errors * std_err_mps2;
        out.places += 1;
        out.rms_mps2 += error_mps2 * error_mps2;
        out.failed += usize::from(error_mps2.abs() > limit_mps2);
        if error_mps2.abs() - limit_mps2 > excess {
            excess = error_mps2.abs() - limit_mps2;
            out.worst = Some(Worst { speed_mps, accel_mps2, torque_nm, right_torque_nm, error_mps2, limit_mps2 });
        }
        Some(error_mps2)
    };
    for (i, &torque_nm) in map1.torque_nm.iter().enumerate() {
        for (j, &speed_mps) in map1.speed_mps.iter().enumerate() {
            if map1.status[i][j] == CellStatus::Measured {
                check(&mut out, speed_mps, map1.accel_mps2[i][j], torque_nm, map1.std_err_mps2[i][j]);
            }
        }
    }
    for &speed_mps in table2.speed_mps().breaks() {
        let (mut sum_mps2, mut std_err_sum_mps2, mut count) = (0.0, 0.0, 0.0);
        for &accel_mps2 in table2.accel_mps2().breaks() {
            let Some((right_nm, true)) = torque_for(surface, speed_mps, accel_mps2) else { continue };
            let Some(std_err_mps2) = measured(map1, speed_mps, right_nm) else { continue };
            if let Some(error_mps2) = check(&mut out, speed_mps, accel_mps2, right_nm, std_err_mps2) {
                sum_mps2 += error_mps2;
                std_err_sum_mps2 += std_err_mps2;
                count += 1.0;
            }
        }
        // a row of one or two cells is judged by its cells; so is the row at 0, where friction is so steep that the best table between
        // the rows may miss it as a whole
        if count > 2.0 && speed_mps > 0.0 && sum_mps2.abs() > limit.row_mean_at_most_mps2 * count + limit.standard_errors * std_err_sum_mps2
        {
            out.failed_rows_mps.push(speed_mps);
        }
    }
    out.pass = out.places > 0 && out.failed == 0 && out.failed_rows_mps.is_empty() && starts_at_zero;
    out.rms_mps2 = (out.rms_mps2 / out.places.max(1) as f64).sqrt();
    out
}

/// a(v, τ) [m/s²], clamped in speed; extrapolated linearly from the last two rows beyond the torques. `None` for NaN.
fn extended(surface: &AccelTable, speed_mps: f64, torque_nm: f64) -> Option<f64> {
    if torque_nm.is_nan() {
        return None;
    }
    let torques = surface.torque_nm().breaks();
    let last = torques.len() - 1;
    let (end, inner) = if torque_nm > torques[last] { (last, last - 1) } else { (0, 1) };
    let at = |torque_nm: f64| surface.accel_from_torque_clamped(speed_mps, torque_nm);
    if surface.torque_nm().contains(torque_nm) {
        return at(torque_nm);
    }
    let slope = (at(torques[end])? - at(torques[inner])?) / (torques[end] - torques[inner]);
    Some(at(torques[end])? + slope * (torque_nm - torques[end]))
}

/// Standard error of Table 1 [m/s²] at a place whose surrounding cells were all measured; `None` elsewhere.
fn measured(map1: &AccelMap, speed_mps: f64, torque_nm: f64) -> Option<f64> {
    let inside = |breaks: &[f64], x: f64| x >= breaks[0] && x <= breaks[breaks.len() - 1];
    if !inside(&map1.speed_mps, speed_mps) || !inside(&map1.torque_nm, torque_nm) {
        return None;
    }
    let (i, p) = lookup::bracket(&map1.torque_nm, torque_nm)?;
    let (j, q) = lookup::bracket(&map1.speed_mps, speed_mps)?;
    let mut std_err = 0.0;
    for (row, row_share) in [(i, 1.0 - p), (i + 1, p)] {
        for (column, column_share) in [(j, 1.0 - q), (j + 1, q)] {
            let share = row_share * column_share;
            if share > 0.0 {
                if map1.status.get(row)?.get(column) != Some(&CellStatus::Measured) {
                    return None;
                }
                std_err += share * map1.std_err_mps2.get(row)?.get(column)?;
            }
        }
    }
    Some(std_err)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::map::Vehicle;
    use crate::sim::{PhysicalSettings, WorldSettings as World};
    use crate::verify::reference_maps::known_maps;

    fn maps() -> Maps {
        let vehicle = Vehicle {
            wheelbase_m: 0.92,
            wheel_radius_m: 0.12,
            test_angle_deg: 90.0,
            torque_limit_nm: Some(44.0),
            torque_full_scale_nm: None,
        };
        let (table1, table2) = known_maps(&World::physical(vehicle, PhysicalSettings::default())).unwrap();
        Maps::new(table1, table2).unwrap()
    }

    fn limit() -> RoundTripLimit {
        RoundTripLimit { at_most_mps2: 0.15, row_mean_at_most_mps2: 0.05, standard_errors: 3.0, reason: String::new() }
    }

    #[test]
    fn beyond_its_torques_the_surface_goes_on_with_its_last_slope() {
        let surface = maps().table1.maps[0].surface.table().unwrap();
        let torques = surface.torque_nm().breaks();
        let (last, before) = (torques[torques.len() - 1], torques[torques.len() - 2]);
        let at = |torque_nm: f64| extended(&surface, 0.3, torque_nm).unwrap();
        let slope = (at(last) - at(before)) / (last - before);
        assert!((at(last + 7.0) - at(last) - 7.0 * slope).abs() < 1e-12);
        assert!(at(torques[0] - 7.0) < at(torques[0]));
        assert_eq!(extended(&surface, 0.3, f64::NAN), None);
    }

    #[test]
    fn the_standard_error_is_interpolated_and_needs_every_cell_around() {
        let mut map = maps().table1.maps[0].clone();
        map.std_err_mps2[5][4] = 0.05;
        let (torque_nm, speed_mps) = (map.torque_nm[5], map.speed_mps[4]);
        let half_m = 0.5 * (map.speed_mps[5] - speed_mps);
        assert!((measured(&map, speed_mps + half_m, torque_nm).unwrap() - 0.03).abs() < 1e-12);
        map.status[5][5] = CellStatus::Extrapolated;
        assert_eq!(measured(&map, speed_mps + half_m, torque_nm), None);
        assert_eq!(measured(&map, speed_mps, torque_nm), Some(0.05), "a cell with no share is not needed");
        assert_eq!(measured(&map, speed_mps, 1e3), None);
    }

    #[test]
    fn a_whole_row_that_is_a_little_off_fails_although_no_place_does() {
        let mut maps = maps();
        assert!(round_trip(&maps, &limit()).unwrap().iter().all(|t| t.pass));
        let (rows, columns) = (maps.forward.speed_mps().len(), maps.forward.accel_mps2().len());
        // 1.4 N·m are 0.1 m/s² at an inertia of 13 N·m per m/s²: within the limit of a place, over that of a row
        let values = (0..rows * columns).map(|k| maps.forward.values()[k] + if k / columns == 8 { 1.4 } else { 0.0 }).collect();
        maps.forward = TorqueTable::new(maps.forward.speed_mps().clone(), maps.forward.accel_mps2().clone(), values).unwrap();
        let trip = &round_trip(&maps, &limit()).unwrap()[0];
        assert!(!trip.pass && trip.failed == 0, "{trip:?}");
        assert_eq!(trip.failed_rows_mps, [maps.forward.speed_mps().breaks()[8]]);
    }
}
