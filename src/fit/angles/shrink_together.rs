//! Moves the maps of a family toward each other, each as far as its standard errors allow.
//!
//! At a point (V, U) every map k of a family gives the drive's torque, y_k = M(δ_k)·A_k + F(V, δ_k), with standard error σ_k = M(δ_k)·s_k.
//! The angles differ by departures of standard deviation τ from the family. For map i the others give an estimate with mean ȳ = Σ w_k·y_k /
//! Σ w_k, w_k = 1/(τ² + σ_k²), and variance P = τ² + 1/Σ w_k + h·σ_i², where h is the share of map i in its own friction. The best
//! combination is λ·y_i + (1 − λ)·ȳ with λ = P/(P + σ_i²), of variance λ·σ_i². A map does not change where the others have no samples, or
//! where the departures are much larger than its errors.
//!
//! Source: Morris 1983, *Parametric empirical Bayes inference*.

use crate::fit::Result;
use crate::fit::angles::family::Family;
use crate::fit::table1::tables::confidence;
use crate::map::{AccelMap, AccelTable, Axis, CellStatus, Side, sha256_hex};
use crate::signal::median;
use crate::units::RAD_PER_DEG;

/// Factor on the variance of cells without a sample near them.
const UNSEEN: f64 = 10.0;
/// Least slope of a surface along torque, relative to the median one.
const LEAST_SLOPE: f64 = 0.02;

/// One map's estimate of the drive's torque.
struct MapEvidence {
    inertia: f64,
    sin: f64,
    surface: AccelTable,
    std_err: AccelTable,
    /// 1 at cells that were measured or interpolated, 0 elsewhere.
    seen: AccelTable,
}

impl MapEvidence {
    fn new(map: &AccelMap, family: &Family) -> Result<Self> {
        let sin = (map.wheel_angle_deg * RAD_PER_DEG).sin();
        let over_cells = |values: Vec<f64>| -> Result<AccelTable> {
            let (speed, torque) = (Axis::new("speed_mps", map.speed_mps.clone())?, Axis::new("torque_nm", map.torque_nm.clone())?);
            Ok(AccelTable::new(speed, torque, values)?)
        };
        let seen = map.status.iter().flatten().map(|s| if *s == CellStatus::Extrapolated { 0.0 } else { 1.0 }).collect();
        Ok(Self {
            inertia: family.reported.terms().inertia(sin),
            sin,
            surface: map.surface.table()?,
            std_err: over_cells(map.std_err_mps2.concat())?,
            seen: over_cells(seen)?,
        })
    }

    /// The drive's torque, its variance, and the share measured or interpolated; `None` outside the surface.
    fn drive_torque(&self, family: &Family, v: f64, u: f64) -> Option<(f64, f64, f64)> {
        let accel = self.surface.accel_from_torque(v, u)?;
        let sigma = self.inertia * self.std_err.accel_from_torque_clamped(v, u)?;
        let seen = self.seen.accel_from_torque(v, u).unwrap_or(0.0);
        Some((self.inertia * accel + family.reported.terms().friction_nm(v, self.sin), sigma * sigma, seen))
    }
}

/// Moves the maps of every family toward each other: cells, standard errors, fine surfaces, breakaway torques and the CSVs' hashes. A map
/// of two families (straight ahead) uses the one with more angles.
pub(crate) fn draw_together(maps: &mut [AccelMap], families: &[Family]) -> Result<()> {
    let before = maps.to_vec();
    for map in maps {
        let belongs = |f: &&Family| f.reported.gear == map.gear && f.reported.side.holds(map.wheel_angle_deg) && f.spread_nm.is_some();
        let most = families.iter().filter(belongs).max_by_key(|f| (f.reported.wheel_angle_deg.len(), f.reported.side == Side::Left));
        let Some((family, spread_nm)) = most.and_then(|f| Some((f, f.spread_nm?))) else { continue };
        let of_family = |m: &&AccelMap| m.gear == family.reported.gear && family.reported.side.holds(m.wheel_angle_deg);
        let others: Vec<MapEvidence> = before
            .iter()
            .filter(of_family)
            .filter(|m| m.wheel_angle_deg.total_cmp(&map.wheel_angle_deg).is_ne())
            .map(|m| MapEvidence::new(m, family))
            .collect::<Result<_>>()?;
        let own = MapEvidence::new(map, family)?;
        let leverage = family.terms as f64 / family.reported.wheel_angle_deg.len() as f64;
        let better = |v: f64, u: f64, accel: f64| -> Option<(f64, f64)> {
            let (_, variance, seen) = own.drive_torque(family, v, u)?;
            let friction = family.reported.terms().friction_nm(v, own.sin);
            let variance = variance * (1.0 + (UNSEEN - 1.0) * (1.0 - seen));
            let (mut weights, mut sum) = (0.0, 0.0);
            for (torque, sigma2, seen) in others.iter().filter_map(|w| w.drive_torque(family, v, u)) {
                let weight = seen / (spread_nm * spread_nm + sigma2).max(1e-12);
                weights += weight;
                sum += weight * torque;
            }
            if weights <= 0.0 {
                return None;
            }
            let prior = spread_nm * spread_nm + 1.0 / weights + leverage * variance;
            let share = prior / (prior + variance).max(1e-12);
            let torque = share * (own.inertia * accel + friction) + (1.0 - share) * sum / weights;
            Some(((torque - friction) / own.inertia, (share * variance).sqrt() / own.inertia))
        };
        for (i, u) in map.torque_nm.iter().enumerate() {
            for (j, v) in map.speed_mps.iter().enumerate() {
                if let Some((accel, error)) = better(*v, *u, map.accel_mps2[i][j]) {
                    map.accel_mps2[i][j] = round(accel, 1e9);
                    map.std_err_mps2[i][j] = round(error, 1e6);
                    map.confidence[i][j] = confidence(error, map.status[i][j]);
                }
            }
        }
        for (i, u) in map.surface.torque_nm.iter().enumerate() {
            for (j, v) in map.surface.speed_mps.iter().enumerate() {
                if let Some((accel, _)) = better(*v, *u, map.surface.accel_mps2[i][j]) {
                    map.surface.accel_mps2[i][j] = round(accel, 1e9);
                }
            }
        }
        rise(&map.torque_nm, &mut map.accel_mps2);
        rise(&map.surface.torque_nm, &mut map.surface.accel_mps2);
        breakaway(map)?;
        map.csv.sha256 = sha256_hex(map.table()?.to_matrix().to_csv().as_bytes());
    }
    Ok(())
}

/// Makes every column rise with torque: two rising surfaces mixed by shares that differ from point to point may not.
fn rise(torque_nm: &[f64], accel: &mut [Vec<f64>]) {
    let slope = |i: usize, j: usize, accel: &[Vec<f64>]| (accel[i + 1][j] - accel[i][j]) / (torque_nm[i + 1] - torque_nm[i]);
    let columns = accel.first().map_or(0, Vec::len);
    let slopes: Vec<f64> =
        (0..torque_nm.len() - 1).flat_map(|i| (0..columns).map(move |j| (i, j))).map(|(i, j)| slope(i, j, accel)).collect();
    let least = LEAST_SLOPE * median(&slopes).max(1e-9);
    for i in 0..torque_nm.len() - 1 {
        for j in 0..columns {
            let floor = accel[i][j] + least * (torque_nm[i + 1] - torque_nm[i]);
            if accel[i + 1][j] < floor {
                accel[i + 1][j] = round(floor, 1e9);
            }
        }
    }
}

/// The breakaway torque of the new surface: its zero at standstill, within the bounds from the starts from rest.
fn breakaway(map: &mut AccelMap) -> Result<()> {
    let surface = &map.surface;
    let at = |i: usize| surface.accel_mps2[i][0];
    let Some(i) = (1..surface.torque_nm.len()).rev().find(|i| at(i - 1) <= 0.0 && at(*i) > 0.0) else { return Ok(()) };
    let (low, high) = (surface.torque_nm[i - 1], surface.torque_nm[i]);
    let slope = (at(i) - at(i - 1)) / (high - low);
    let mut torque_nm = (low - at(i - 1) / slope).max(0.0);
    if let Some(std_err_nm) = &mut map.breakaway.std_err_nm {
        let errors = AccelTable::new(
            Axis::new("speed_mps", map.speed_mps.clone())?,
            Axis::new("torque_nm", map.torque_nm.clone())?,
            map.std_err_mps2.concat(),
        )?;
        let error = errors.accel_from_torque_clamped(0.0, torque_nm).unwrap_or(*std_err_nm * slope) / slope;
        *std_err_nm = round(error.min(*std_err_nm), 1e6);
    }
    if let Some(at_rest) = map.breakaway.at_rest_up_to_nm {
        torque_nm = torque_nm.max(at_rest);
    }
    if let Some(moved) = map.breakaway.moved_from_nm {
        torque_nm = torque_nm.min(moved);
    }
    map.breakaway.torque_nm = round(torque_nm, 1e6);
    Ok(())
}

fn round(value: f64, steps: f64) -> f64 {
    (value * steps).round() / steps
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_column_that_falls_is_lifted_and_one_that_rises_stays() {
        let mut accel = vec![vec![0.0, 0.0], vec![1.0, 1.0], vec![2.0, 0.9], vec![3.0, 3.0]];
        rise(&[0.0, 10.0, 20.0, 30.0], &mut accel);
        assert!(accel.windows(2).all(|w| w[1][1] > w[0][1]));
        assert_eq!(accel.iter().map(|row| row[0]).collect::<Vec<_>>(), [0.0, 1.0, 2.0, 3.0]);
    }
}
