//! The common part of one gear's maps over the wheel angle.
//!
//! In: Table 1 of one gear and side at two or more angles. Out: an [`AngleFamily`]. The equation of motion in torques is
//!
//! M(δ)·A(V, U, δ) = H(V, U) − F(V, δ)
//!
//! H is the drive's response to its torque, the same at every angle, with H(V, 0) = 0 and slope 1 where it drives. The grid is the speeds
//! and torques that the maps cover, weighted by their standard errors. H, one inertia per angle, and one friction per angle and speed are
//! the least squares solution, each in turn from the others. The inertias are then M = m₀ + m₁·sin²δ, and the frictions at every speed f₀ +
//! f₁·sin²δ. From four angles on, a further term f₂·|sin δ| is used if it clearly reduces the errors at the angles left out.
//!
//! The error of such a family is measured: each angle between two others is left out, predicted by the rest, and compared with its own map.

use crate::fit::Result;
use crate::map::{AccelMap, AccelMaps, AngleFamily, CellStatus, DepartureFrom, Gear, LeftOutAngle, Side};
use crate::units::RAD_PER_DEG;

/// Spacing of the speeds compared [m/s].
const SPEED_STEP_MPS: f64 = 0.05;
/// About the number of torques compared.
const TORQUES: usize = 24;
/// Least standard error when angles are compared [m/s²].
const LEAST_STD_ERR_MPS2: f64 = 2e-3;
/// Rounds of the least squares, and the relative change of an inertia at which they have converged.
const ROUNDS: usize = 2000;
const STILL: f64 = 1e-9;
/// Fewest angles for a third term of friction, and the least ratio of the errors at angles left out without it to those with it: with two
/// or three such errors, a smaller gain may be chance.
const ANGLES_FOR_THIRD: usize = 4;
const GAIN_OF_THIRD: f64 = 1.25;
/// If no angle lies between two others: the part of the change of friction between neighbours that its shape over the angle may hide. The
/// largest distance of sin²δ from a straight line over 30° is a sixteenth of its range; this is four times as much.
const ASSUMED_SHARE: f64 = 0.25;

/// A family with the data that only the fit needs.
#[derive(Debug, Clone)]
pub(crate) struct Family {
    /// The part written into files.
    pub(crate) reported: AngleFamily,
    /// Number of terms of the friction.
    pub(crate) terms: usize,
    /// τ, the standard deviation of the departures of measured angles from the family [N·m]; absent with too few angles.
    pub(crate) spread_nm: Option<f64>,
}

/// The families of maps at several angles, by gear and side; a side with one angle has none.
pub(crate) fn families(maps: &[AccelMap]) -> Result<Vec<Family>> {
    let mut found = Vec::new();
    for gear in Gear::ALL {
        for side in Side::ALL {
            let mut own: Vec<&AccelMap> = maps.iter().filter(|m| m.gear == gear && side.holds(m.wheel_angle_deg)).collect();
            own.sort_by(|a, b| a.wheel_angle_deg.abs().total_cmp(&b.wheel_angle_deg.abs()));
            let plain = family(gear, side, &own, 2)?;
            let bent = if own.len() >= ANGLES_FOR_THIRD { family(gear, side, &own, 3)? } else { None };
            let miss = |f: &Family| f.reported.left_out.iter().map(|l| l.rms_nm.powi(2)).sum::<f64>().sqrt();
            found.extend(match (plain, bent) {
                (Some(plain), Some(bent)) if miss(&bent) * GAIN_OF_THIRD < miss(&plain) => Some(bent),
                (plain, _) => plain,
            });
        }
    }
    Ok(found)
}

/// The family of maps of one gear and side, with the errors at its angles left out. `None` with fewer than two angles, and if the angles
/// have nothing in common to compare.
fn family(gear: Gear, side: Side, maps: &[&AccelMap], terms: usize) -> Result<Option<Family>> {
    let Some(mut family) = shape(gear, side, maps, terms)? else { return Ok(None) };
    let reported = &mut family.reported;
    let (mut squares, mut count) = (0.0, 0);
    for k in 1..maps.len().saturating_sub(1) {
        let others: Vec<&AccelMap> = maps.iter().enumerate().filter(|(j, _)| *j != k).map(|(_, m)| *m).collect();
        let Some(rest) = shape(gear, side, &others, terms)? else { continue };
        let Some(miss) = left_out(maps[k], &others, &rest.reported)? else { continue };
        let (low, high) = (maps[k - 1].wheel_angle_deg, maps[k + 1].wheel_angle_deg);
        let share = (maps[k].wheel_angle_deg - low) / (high - low);
        squares += (miss.rms_nm.powi(2) - miss.expected_nm.powi(2)).max(0.0) / (4.0 * share * (1.0 - share));
        count += 1;
        reported.left_out.push(miss);
    }
    if count > 0 {
        let departure_nm = (squares / f64::from(count)).sqrt().max(family.spread_nm.unwrap_or(0.0));
        reported.departure_nm = round6(departure_nm);
        reported.departure_from = DepartureFrom::AnglesLeftOut;
    } else {
        let mut widest: f64 = 0.0;
        for pair in maps.windows(2) {
            let [a, b] = [pair[0], pair[1]].map(|m| (m.wheel_angle_deg * RAD_PER_DEG).sin());
            for v in &reported.speed_mps {
                widest = widest.max((reported.terms().friction_nm(*v, b) - reported.terms().friction_nm(*v, a)).abs());
            }
        }
        reported.departure_nm = round6(ASSUMED_SHARE * widest);
        reported.departure_from = DepartureFrom::Assumed;
    }
    Ok(Some(family))
}

/// One map at a point of the grid.
#[derive(Debug, Clone, Copy)]
struct FamilyPoint {
    accel_mps2: f64,
    weight: f64,
}

/// The maps over a common grid: `points[angle][speed][torque]`.
struct FamilyGrid {
    speed_mps: Vec<f64>,
    torque_nm: Vec<f64>,
    points: Vec<Vec<Vec<Option<FamilyPoint>>>>,
}

impl FamilyGrid {
    fn new(maps: &[&AccelMap]) -> Result<Self> {
        let ends = |pick: fn(&AccelMap) -> f64, better: fn(f64, f64) -> f64| maps.iter().map(|m| pick(m)).reduce(better).unwrap_or(0.0);
        let fastest = ends(|m| m.speed_mps[m.speed_mps.len() - 1], f64::max);
        let (low, high) = (ends(|m| m.torque_nm[0], f64::min), ends(|m| m.torque_nm[m.torque_nm.len() - 1], f64::max));
        let step_nm = (high - low) / TORQUES as f64;
        let speed_mps: Vec<f64> = (0..=(fastest / SPEED_STEP_MPS + 1e-6) as usize).map(|k| k as f64 * SPEED_STEP_MPS).collect();
        let torque_nm: Vec<f64> =
            ((low / step_nm).ceil() as i64..=(high / step_nm + 1e-6).floor() as i64).map(|k| k as f64 * step_nm).collect();
        let mut points = Vec::new();
        for map in maps {
            let (table, all) = (map.table()?, AccelMaps::new([*map], &[])?);
            let at = |v: f64, u: f64| {
                let covered = table.torque_nm().contains(u) && table.speed_mps().contains(v);
                let status = map.status[table.torque_nm().nearest(u)][table.speed_mps().nearest(v)];
                let found = all.accel(map.gear, v, u, map.wheel_angle_deg)?;
                let error = found.std_err_mps2.max(LEAST_STD_ERR_MPS2);
                (covered && status != CellStatus::Extrapolated)
                    .then(|| FamilyPoint { accel_mps2: found.accel_mps2, weight: 1.0 / (error * error) })
            };
            points.push(speed_mps.iter().map(|v| torque_nm.iter().map(|u| at(*v, *u)).collect()).collect());
        }
        Ok(Self { speed_mps, torque_nm, points })
    }
}

/// Inertia per angle, friction per angle and speed, drive over speed and torque.
struct Split {
    inertia: Vec<f64>,
    friction_nm: Vec<Vec<Option<f64>>>,
}

/// Alternating least squares; `None` where an angle shows no rise of acceleration with torque.
fn split(grid: &FamilyGrid) -> Option<Split> {
    let (angles, speeds, torques) = (grid.points.len(), grid.speed_mps.len(), grid.torque_nm.len());
    let mut drive: Vec<Vec<f64>> = vec![grid.torque_nm.clone(); speeds];
    let mut found = Split { inertia: vec![1.0; angles], friction_nm: vec![vec![None; speeds]; angles] };
    let unloaded = (0..torques).min_by(|a, b| grid.torque_nm[*a].abs().total_cmp(&grid.torque_nm[*b].abs()))?;
    for _ in 0..ROUNDS {
        let mut moved: f64 = 0.0;
        for (k, points) in grid.points.iter().enumerate() {
            // per speed the weighted means; over all of them the slope
            let (mut rise, mut along) = (0.0, 0.0);
            let mut means = vec![None; speeds];
            for (i, row) in points.iter().enumerate() {
                let cells = || row.iter().enumerate().filter_map(|(j, t)| t.map(|t| (j, t)));
                let weight: f64 = cells().map(|(_, t)| t.weight).sum();
                if cells().count() < 2 {
                    continue;
                }
                let mean_accel = cells().map(|(_, t)| t.weight * t.accel_mps2).sum::<f64>() / weight;
                let mean_drive = cells().map(|(j, t)| t.weight * drive[i][j]).sum::<f64>() / weight;
                for (j, t) in cells() {
                    rise += t.weight * (t.accel_mps2 - mean_accel) * (drive[i][j] - mean_drive);
                    along += t.weight * (t.accel_mps2 - mean_accel).powi(2);
                }
                means[i] = Some((mean_accel, mean_drive));
            }
            if along <= 0.0 || rise <= 0.0 {
                return None;
            }
            let inertia = rise / along;
            moved = moved.max((inertia / found.inertia[k] - 1.0).abs());
            found.inertia[k] = inertia;
            found.friction_nm[k] = means.into_iter().map(|m| m.map(|(accel, drive)| drive - inertia * accel)).collect();
        }
        if moved < STILL {
            break;
        }
        let (mut product, mut square) = (0.0, 0.0);
        for i in 0..speeds {
            for j in (0..torques).filter(|j| *j != unloaded) {
                let (mut sum, mut weights) = (0.0, 0.0);
                for k in 0..angles {
                    if let (Some(t), Some(friction)) = (grid.points[k][i][j], found.friction_nm[k][i]) {
                        let weight = t.weight / found.inertia[k].powi(2);
                        sum += weight * (found.inertia[k] * t.accel_mps2 + friction);
                        weights += weight;
                    }
                }
                if weights > 0.0 {
                    drive[i][j] = sum / weights;
                    if grid.torque_nm[j] > 0.0 {
                        product += drive[i][j] * grid.torque_nm[j];
                        square += grid.torque_nm[j].powi(2);
                    }
                }
            }
        }
        let scale = if product > 0.0 { square / product } else { 1.0 };
        drive.iter_mut().flatten().for_each(|h| *h *= scale);
    }
    Some(found)
}

/// The family with two or three `terms` of friction, without the errors at angles left out.
fn shape(gear: Gear, side: Side, maps: &[&AccelMap], terms: usize) -> Result<Option<Family>> {
    if maps.len() < terms {
        return Ok(None);
    }
    let grid = FamilyGrid::new(maps)?;
    let Some(split) = split(&grid) else { return Ok(None) };
    let sines: Vec<f64> = maps.iter().map(|m| (m.wheel_angle_deg * RAD_PER_DEG).sin().abs()).collect();
    let basis = |k: usize| [1.0, sines[k] * sines[k], sines[k]];
    let all: Vec<([f64; 3], f64)> = split.inertia.iter().enumerate().map(|(k, m)| (basis(k), *m)).collect();
    let Some(inertia) = least_squares::<2>(&all) else { return Ok(None) };
    let mut reported = AngleFamily {
        gear,
        side,
        wheel_angle_deg: maps.iter().map(|m| m.wheel_angle_deg).collect(),
        inertia: inertia.map(round6),
        speed_mps: Vec::new(),
        friction_nm: [Vec::new(), Vec::new(), Vec::new()],
        departure_nm: 0.0,
        departure_from: DepartureFrom::Assumed,
        left_out: Vec::new(),
    };
    for (i, v) in grid.speed_mps.iter().enumerate() {
        let Some(rows) = (0..maps.len()).map(|k| split.friction_nm[k][i].map(|f| (basis(k), f))).collect::<Option<Vec<_>>>() else {
            continue;
        };
        let solved = if terms == 3 { least_squares::<3>(&rows) } else { least_squares::<2>(&rows).map(|[a, b]| [a, b, 0.0]) };
        if let Some(solved) = solved {
            reported.speed_mps.push(round6(*v));
            for (list, term) in reported.friction_nm.iter_mut().zip(solved).take(terms) {
                list.push(round6(term));
            }
        }
    }
    if reported.check().is_err() {
        return Ok(None);
    }
    let spread_nm = spread(&grid, &reported, &sines, terms);
    Ok(Some(Family { reported, terms, spread_nm }))
}

/// τ from the differences of the maps' drive torques y_k = M·A_k + F at the same speed and torque, beyond their standard errors. Errors at
/// one speed are correlated, and the friction's terms use up as many of the angles: m angles leave m − terms degrees of freedom.
fn spread(grid: &FamilyGrid, family: &AngleFamily, sines: &[f64], terms: usize) -> Option<f64> {
    let (mut squares, mut free, mut variance, mut count) = (0.0, 0.0, 0.0, 0.0);
    for (i, v) in grid.speed_mps.iter().enumerate() {
        for j in 0..grid.torque_nm.len() {
            let torques: Vec<(f64, f64)> = grid
                .points
                .iter()
                .zip(sines)
                .filter_map(|(points, sin)| {
                    let (point, inertia) = (points[i][j]?, family.terms().inertia(*sin));
                    Some((inertia * point.accel_mps2 + family.terms().friction_nm(*v, *sin), inertia * inertia / point.weight))
                })
                .collect();
            if torques.len() <= terms {
                continue;
            }
            let weights: f64 = torques.iter().map(|(_, s2)| 1.0 / s2).sum();
            let mean = torques.iter().map(|(y, s2)| y / s2).sum::<f64>() / weights;
            squares += torques.iter().map(|(y, _)| (y - mean).powi(2)).sum::<f64>();
            free += (torques.len() - terms) as f64;
            variance += torques.iter().map(|(_, s2)| s2).sum::<f64>();
            count += torques.len() as f64;
        }
    }
    (free > 0.0).then(|| (squares / free - variance / count).max(0.0).sqrt())
}

/// Least squares of the values on the first `N` of three terms; `None` if they do not determine them.
fn least_squares<const N: usize>(rows: &[([f64; 3], f64)]) -> Option<[f64; N]> {
    let mut normal = [[0.0; N]; N];
    let mut right = [0.0; N];
    for (terms, value) in rows {
        for a in 0..N {
            right[a] += terms[a] * value;
            for b in 0..N {
                normal[a][b] += terms[a] * terms[b];
            }
        }
    }
    // Gauss's elimination; the matrix is positive definite where the angles differ
    let whole = normal[0][0];
    for a in 0..N {
        if normal[a][a] < 1e-9 * whole {
            return None;
        }
        for b in a + 1..N {
            let factor = normal[b][a] / normal[a][a];
            for c in a..N {
                normal[b][c] -= factor * normal[a][c];
            }
            right[b] -= factor * right[a];
        }
    }
    let mut solution = [0.0; N];
    for a in (0..N).rev() {
        let known: f64 = (a + 1..N).map(|b| normal[a][b] * solution[b]).sum();
        solution[a] = (right[a] - known) / normal[a][a];
    }
    Some(solution)
}

/// Prediction of `map` by `others`, over its covered cells; `None` if they cover none of them.
fn left_out(map: &AccelMap, others: &[&AccelMap], family: &AngleFamily) -> Result<Option<LeftOutAngle>> {
    let all = AccelMaps::new(others.iter().copied(), std::slice::from_ref(family))?;
    let inertia = family.terms().inertia((map.wheel_angle_deg * RAD_PER_DEG).sin());
    let (mut squares, mut expected, mut count) = (0.0, 0.0, 0.0);
    for (i, u) in map.torque_nm.iter().enumerate() {
        for (j, v) in map.speed_mps.iter().enumerate().filter(|(j, _)| map.status[i][*j] != CellStatus::Extrapolated) {
            // the family has no departure yet: the rest is the error of the maps
            if let Some(found) = all.accel(map.gear, *v, *u, map.wheel_angle_deg) {
                squares += (inertia * (found.accel_mps2 - map.accel_mps2[i][j])).powi(2);
                expected += (inertia * found.std_err_mps2.hypot(map.std_err_mps2[i][j])).powi(2);
                count += 1.0;
            }
        }
    }
    let root = |sum: f64| round6((sum / count).sqrt());
    Ok((count > 0.0).then(|| LeftOutAngle { wheel_angle_deg: map.wheel_angle_deg, rms_nm: root(squares), expected_nm: root(expected) }))
}

fn round6(value: f64) -> f64 {
    (value * 1e6).round() / 1e6
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::sim::VehicleFile;
    use crate::verify::reference_maps::known_maps;

    /// The bundled vehicle's own forward maps.
    fn maps(angles_deg: &[f64]) -> Vec<AccelMap> {
        let settings = VehicleFile::bundled().unwrap().settings();
        let at = |angle_deg: &f64| {
            let mut world = settings.clone();
            world.vehicle.test_angle_deg = *angle_deg;
            known_maps(&world).unwrap().0.maps.remove(0)
        };
        angles_deg.iter().map(at).collect()
    }

    #[test]
    fn the_inertia_is_that_of_the_rigid_vehicle_and_an_angle_left_out_is_predicted() {
        let found = families(&maps(&[30.0, 60.0, 90.0])).unwrap();
        assert_eq!(found.len(), 1);
        let family = &found[0].reported;
        let vehicle = VehicleFile::bundled().unwrap();
        let (motion, radius_m) = (vehicle.motion, vehicle.vehicle.wheel_radius_m);
        let turning_kg = motion.yaw_inertia_kgm2 / vehicle.vehicle.wheelbase_m.powi(2) - motion.mass_kg;
        // η·M per drive torque: the efficiency is part of the drive's response, whose slope is 1 by definition
        let ratio = family.inertia[1] / family.inertia[0];
        let wheel_kg = motion.wheel_inertia_kgm2 / (radius_m * radius_m);
        assert!((ratio - turning_kg / (motion.mass_kg + wheel_kg)).abs() < 0.02, "{ratio} {family:?}");
        assert_eq!((family.left_out.len(), family.departure_from), (1, DepartureFrom::AnglesLeftOut));
        assert!(family.left_out[0].wheel_angle_deg == 60.0 && family.left_out[0].rms_nm < 0.5, "{:?}", family.left_out);
    }

    #[test]
    fn a_single_angle_and_angles_of_both_sides_make_no_family() {
        assert!(families(&maps(&[90.0])).unwrap().is_empty());
        assert!(families(&maps(&[-60.0, 60.0])).unwrap().is_empty());
    }

    #[test]
    fn with_two_angles_the_departure_is_assumed() {
        let found = families(&maps(&[60.0, 90.0])).unwrap();
        assert_eq!(found[0].reported.departure_from, DepartureFrom::Assumed);
        assert!(found[0].reported.left_out.is_empty() && found[0].reported.departure_nm > 0.0);
    }
}
