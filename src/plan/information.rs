//! Information of runs on the surface's coefficients.

use crate::fit::motion::integration::Course;
use crate::fit::motion::regressors::{Free, whitened_sums};
use crate::fit::noise::model::Noise;
use crate::fit::nuisance;
use crate::fit::surface::design::{Design, STRIBECK_MPS};
use crate::fit::surface::lattice::{Lattice, LatticeSurface};
use crate::fit::{Error, FitSettings, Result};
use crate::map::{DelayEstimate, Gear, Table1File};
use crate::plan::drive::{DrivenPart, PlannedVehicle, READING_S};
use crate::plan::settings::PlanSettings;
use faer::Mat;
use faer::linalg::solvers::DenseSolveCore;
use rayon::prelude::*;
use std::ops::Range;

/// Rows of a stretch's information are added until this share of its trace is left: with fewer rows, long stretches that pass many speeds
/// and torques lose too much.
const LEFT_OUT: f64 = 1e-3;
/// Least standard deviation that a block of the physics form may add to the surface [m/s², root mean square over the lattice]: a term that
/// the data so far did not need is not known to be zero.
const UNSEEN_PHYSICS_MPS2: f64 = 0.01;
/// The same for a block beyond it: if runs left out support none of the surface, and if they support all of it.
const UNSEEN_BEYOND_MPS2: [f64; 2] = [0.0003, 0.003];
/// The lag, and the dead times of the log driven before and of the next one.
const DELAYS: usize = 3;
/// Weight of a standard error of a delay against coefficients, which are measured by their effect on the surface [m/s²].
const DELAY_UNIT_MPS2: f64 = 0.01;
/// Largest standard error of a delay that the data hardly determine [s].
const MOST_DELAY_STD_S: f64 = 5e-3;
/// Usual rates of an encoder and of a yaw rate [Hz].
const RATE_HZ: [f64; 2] = [50.0, 100.0];
/// How much faster than the requested cells the runs go [m/s].
const BEYOND_MPS: f64 = 0.1;
/// Most speeds of a gear's cells.
const MOST_SPEEDS: usize = 40;

/// A matrix R of few rows with RᵀR the information on the coefficients of the design.
pub(crate) type Information = Mat<f64>;

/// A cell whose torque is to be estimated.
pub(crate) struct TorqueCell {
    pub(crate) gear: Gear,
    pub(crate) speed_mps: f64,
    pub(crate) torque_nm: f64,
    /// The row c with cᵀβ the torque [N·m].
    pub(crate) contrast: Vec<f64>,
}

/// The estimator's regressors over the surface of a `table1.json`.
pub(crate) struct Model {
    surface: LatticeSurface,
    pub(crate) design: Design,
    noise: Noise,
    pub(crate) vehicles: Vec<PlannedVehicle>,
    /// Torques that may be driven [N·m], rising.
    pub(crate) levels_nm: Vec<f64>,
    breaks: (Vec<f64>, Vec<f64>),
    dead_time_std_s: f64,
    lag_std_s: f64,
}

impl Model {
    pub(crate) fn new(file: &Table1File, asked: &PlanSettings) -> Result<Self> {
        let settings: FitSettings = serde_json::from_value(file.settings.clone()).unwrap_or_default();
        let used: Vec<_> = file.report.runs.iter().filter(|r| r.used_s > 0.0).collect();
        let limit_nm = file.vehicle.torque_limit_nm.unwrap_or(f64::INFINITY);
        let mut torques: Vec<f64> = match &asked.torque_breaks_nm {
            Some(breaks) => breaks.clone(),
            None => file.maps.iter().flat_map(|m| m.torque_nm.iter().copied()).collect(),
        };
        torques.retain(|u| u.abs() <= limit_nm + 1e-9);
        torques.sort_unstable_by(f64::total_cmp);
        torques.dedup_by(|a, b| (*a - *b).abs() < 1e-6);
        let driven: Vec<f64> = file.maps.iter().map(|m| m.speed_mps.clone()).max_by_key(Vec::len).unwrap_or_default();
        let (Some(&low), Some(&high), Some(&fastest)) = (torques.first(), torques.last(), driven.last()) else {
            return Err(Error::NothingToPlan);
        };
        if used.is_empty() || fastest <= 0.0 {
            return Err(Error::NothingToPlan);
        }
        // a level that ends at a speed overshoots it by about 0.04 m/s
        let reached = used.iter().fold(0.0f64, |m, r| m.max(r.start_speed_mps).max(r.end_speed_mps)).min(fastest);
        let reached = ((reached - 0.04) * 20.0).floor().max(1.0) / 20.0;
        let speeds = match &asked.speed_breaks_mps {
            Some(breaks) => breaks.clone(),
            None => driven.into_iter().filter(|v| *v <= reached + 1e-9).collect(),
        };
        // no reading lies in the row of a wheel that has just begun to move: the surface is extrapolated to it, and most of its error
        // remains
        let speeds: Vec<f64> = speeds.into_iter().filter(|v| *v > 1e-9).collect();
        let Some(&fastest_wanted) = speeds.last().filter(|_| high > low && high > 0.0) else {
            return Err(Error::NoCells { low_nm: low, high_nm: high });
        };
        // cells are most certain when runs pass on both sides
        let fastest_mps = if asked.speed_breaks_mps.is_some() { fastest_wanted + BEYOND_MPS } else { reached };
        let fastest = fastest.max(fastest_mps);
        let lattice = Lattice::new(fastest, low, high, settings.speed_nodes.clamp(4, 40), settings.torque_nodes.clamp(6, 60));
        let design = {
            let stribeck_mps = file.report.diagnostics["stribeck_speed_mps"].as_f64().filter(|v| *v > 1e-3).unwrap_or(STRIBECK_MPS);
            Design::new(&lattice, file.maps.iter().any(|m| m.gear != file.maps[0].gear), stribeck_mps)
        };
        // one series of readings that carries as much information as all speed sources together
        let precision: f64 = file.witnesses.iter().zip(RATE_HZ).map(|(w, rate)| rate / (w.noise_mps * w.noise_mps).max(1e-8)).sum();
        let precision = if precision > 0.0 { precision } else { RATE_HZ[0] / (file.noise.speed_noise_mps.powi(2)).max(1e-8) };
        let noise = Noise {
            disturbance_mps2: file.noise.disturbance_mps2.max(1e-4),
            disturbance_time_s: file.noise.disturbance_time_s.max(0.01),
            offset_mps2: file.noise.run_offset_mps2.max(1e-4),
            reading_mps: [(1.0 / (precision * READING_S)).sqrt(); 2],
            start_scale: 1.0,
        };
        let mut vehicles = Vec::new();
        for map in &file.maps {
            vehicles.push(PlannedVehicle {
                gear: map.gear,
                surface: map.surface.table()?,
                dead_time_s: file.actuator.dead_time.value_s.clamp(0.0, 0.5),
                lag_s: file.actuator.lag.value_s.clamp(0.0, 0.3),
                transient_s: settings.transient_s,
                breakaway_nm: map.breakaway.torque_nm,
                fastest_mps,
            });
        }
        // even levels, about as many as a campaign has; from the table's lowest to its highest torque
        let step = (((high - low) / 16.0) * 2.0).round().max(1.0) / 2.0;
        let first = (low / step).ceil() as i64;
        let last = (high / step + 1e-9).floor() as i64;
        let levels_nm = (first..=last).map(|k| k as f64 * step).collect();
        let every = speeds.len().div_ceil(MOST_SPEEDS).max(1);
        let speeds = speeds.into_iter().step_by(every).collect();
        // delays need only the slopes in torque, driving and braking
        let theta = {
            let vehicle = &vehicles[0];
            let slope = |u: f64| vehicle.accel_mps2(0.3 * fastest_mps, u) - vehicle.accel_mps2(0.3 * fastest_mps, 0.0);
            let at = |u: f64| if u > 0.0 { u * slope(high) / high } else { u * slope(low.min(-high)) / low.min(-high) };
            (0..lattice.speed_mps.len()).flat_map(|_| lattice.torque_nm.iter().map(|u| at(*u))).collect()
        };
        let delay = |d: &DelayEstimate| d.std_err_s.unwrap_or(0.0).clamp(0.0, MOST_DELAY_STD_S);
        Ok(Self {
            surface: LatticeSurface { lattice, theta },
            design,
            noise,
            vehicles,
            levels_nm,
            breaks: (speeds, torques),
            dead_time_std_s: delay(&file.actuator.dead_time),
            lag_std_s: delay(&file.actuator.lag),
        })
    }

    /// The information of stretches of a gear, in the log driven before (0) or the next one (1).
    pub(crate) fn information(&self, gear: Gear, parts: &[DrivenPart], log: usize) -> Information {
        let t = self.design.transform(gear);
        let (q, base) = (t.ncols(), t.nrows());
        let blocks: Vec<Mat<f64>> = parts
            .iter()
            .map(|part| {
                let s = &part.segment;
                let course = Course::new(s, &part.command, self.vehicles[0].dead_time_s);
                let mut gram = whitened_sums(&course, &part.speed_mps.clone().into(), &self.surface, &self.noise, Free::Delays);
                let width = gram.columns.len();
                let units: Vec<f64> =
                    gram.columns.iter().map(|c| (*c as usize).checked_sub(base).map_or(1.0, |n| self.delay_std_s(n))).collect();
                for c in 0..width {
                    for r in c..width {
                        gram.values[(r, c)] *= units[r] * units[c];
                    }
                }
                let root = pivoted_root(&gram.values, width, LEFT_OUT);
                let touched = Mat::from_fn(width, q + DELAYS, |r, c| match (gram.columns[r] as usize).checked_sub(base) {
                    None if c < q => t[(gram.columns[r] as usize, c)],
                    Some(nuisance::DRIVE) if c == q => 1.0,
                    Some(nuisance::DEAD_TIME) if c == q + 1 + log => 1.0,
                    _ => 0.0,
                });
                &root * &touched
            })
            .collect();
        let rows = blocks.iter().map(Mat::nrows).sum();
        let mut all = Mat::zeros(rows, q + DELAYS);
        let mut at = 0;
        for block in &blocks {
            all.submatrix_mut(at, 0, block.nrows(), q + DELAYS).copy_from(block);
            at += block.nrows();
        }
        all
    }

    /// Standard error of the delay of a nuisance column of the estimator [s]; 0 for the speed itself and for columns that are no delay.
    fn delay_std_s(&self, nuisance: usize) -> f64 {
        match nuisance {
            nuisance::DRIVE => self.lag_std_s,
            nuisance::DEAD_TIME => self.dead_time_std_s,
            _ => 0.0,
        }
    }

    /// (XᵀX + Λ)⁻¹ of the runs that the file reports.
    pub(crate) fn covariance(&self, file: &Table1File) -> Result<Mat<f64>> {
        let q = self.size();
        let driven: Vec<Information> = file
            .report
            .runs
            .par_iter()
            .filter(|r| r.used_s > 0.0)
            .filter_map(|r| {
                let vehicle = self.vehicles.iter().find(|v| v.gear == r.gear)?;
                let parts = vehicle.driven(r.torque_nm, r.start_speed_mps.max(0.0), r.used_s.min(30.0));
                Some(self.information(r.gear, &parts, 0))
            })
            .collect();
        let mut h: Mat<f64> = Mat::zeros(q, q);
        for rows in &driven {
            h += rows.transpose() * rows;
        }
        let ridge = self.ridge(file);
        for (k, r) in ridge.iter().enumerate() {
            h[(k, k)] += r;
        }
        let factor = h.llt(faer::Side::Lower).map_err(|_| Error::Singular)?;
        Ok(factor.inverse())
    }

    /// Number of unknowns: the coefficients of the design, the lag, the dead times of both logs.
    pub(crate) fn size(&self) -> usize {
        self.design.coefficients() + DELAYS
    }

    /// Variance that unit coefficients of a block give the surface, mean over the lattice [m²/s⁴].
    fn unit_variance(&self, columns: &Range<usize>) -> f64 {
        let t = self.design.transform(Gear::Forward);
        columns.clone().map(|c| (0..t.nrows()).map(|r| t[(r, c)].powi(2)).sum::<f64>()).sum::<f64>() / t.nrows() as f64
    }

    /// Effect of a unit of each coefficient on the surface, root mean square over its block and the lattice [m/s²].
    pub(crate) fn unit_mps2(&self) -> Vec<f64> {
        let mut unit = vec![DELAY_UNIT_MPS2; self.size()];
        for block in &self.design.blocks {
            unit[block.range.clone()].fill((self.unit_variance(&block.range) / block.range.len() as f64).max(1e-12).sqrt());
        }
        unit
    }

    /// The diagonal of Λ: the fit's choice, but no tighter than [`UNSEEN_PHYSICS_MPS2`] and [`UNSEEN_BEYOND_MPS2`] allow.
    fn ridge(&self, file: &Table1File) -> Vec<f64> {
        let chosen = |name: &str| {
            let blocks = file.report.diagnostics.get("blocks")?.as_array()?;
            blocks.iter().find(|b| b.get("block").and_then(serde_json::Value::as_str) == Some(name))?.get("penalty")?.as_f64()
        };
        let surface_share = file.report.diagnostics["model_choice"]["surface_share"].as_f64().map_or(1.0, |share| share.clamp(0.0, 1.0));
        let [none, all] = UNSEEN_BEYOND_MPS2;
        let unseen_beyond_mps2 = none + surface_share * (all - none);
        // delays are measured by their standard errors
        let mut ridge = vec![1.0; self.size()];
        for block in &self.design.blocks {
            let unit = self.unit_variance(&block.range);
            let penalty = if block.penalised {
                let unseen_mps2 = if block.physics { UNSEEN_PHYSICS_MPS2 } else { unseen_beyond_mps2 };
                let most = unit / (unseen_mps2 * unseen_mps2);
                chosen(block.name).filter(|p| *p > 0.0).map_or(most, |p| p.min(most))
            } else {
                // vague: 10 m/s²
                unit / 100.0
            };
            ridge[block.range.clone()].fill(penalty.max(1e-9));
        }
        ridge
    }

    /// The cells of both gears whose torque is to be estimated.
    pub(crate) fn cells(&self) -> Vec<TorqueCell> {
        let mut cells = Vec::new();
        let (speeds, torques) = &self.breaks;
        for vehicle in &self.vehicles {
            // beyond the torques of the surface as at its end
            let slope_at = |v: f64, u: f64| (vehicle.accel_mps2(v, u + 1.5) - vehicle.accel_mps2(v, u - 1.5)) / 3.0;
            let (low, high) = (torques[0], torques[torques.len() - 1]);
            let mean = (vehicle.accel_mps2(0.0, high) - vehicle.accel_mps2(0.0, low)) / (high - low);
            let t = self.design.transform(vehicle.gear);
            for &torque_nm in torques {
                for &speed_mps in speeds {
                    // where the surface is nearly level, its slope is too uncertain to weight a cell by
                    let slope = slope_at(speed_mps, torque_nm).max(0.3 * mean.abs()).max(1e-9);
                    let spot = self.surface.lattice.spot(speed_mps, torque_nm);
                    let mut contrast: Vec<f64> = (0..t.ncols())
                        .map(|c| spot.columns(&self.surface.lattice).map(|(r, w)| w * t[(r, c)]).sum::<f64>() / slope)
                        .collect();
                    contrast.resize(self.size(), 0.0);
                    cells.push(TorqueCell { gear: vehicle.gear, speed_mps, torque_nm, contrast });
                }
            }
        }
        cells
    }
}

/// Rows R with RᵀR nearly the leading `size` × `size` part of a symmetric matrix: Cholesky's factor with diagonal pivots, as many as leave
/// `left_out` of the trace.
pub(crate) fn pivoted_root(gram: &Mat<f64>, size: usize, left_out: f64) -> Mat<f64> {
    let mut left: Vec<f64> = (0..size).map(|k| gram[(k, k)]).collect();
    let total: f64 = left.iter().sum();
    let mut rows: Vec<Vec<f64>> = Vec::new();
    while rows.len() < size && left.iter().sum::<f64>() > left_out * total {
        let pivot = (0..size).fold(0, |best, k| if left[k] > left[best] { k } else { best });
        let scale = left[pivot].sqrt();
        if scale.is_nan() || scale <= 0.0 {
            break;
        }
        let row: Vec<f64> =
            (0..size).map(|k| (gram[(pivot.max(k), pivot.min(k))] - rows.iter().map(|r| r[pivot] * r[k]).sum::<f64>()) / scale).collect();
        left.iter_mut().zip(&row).for_each(|(l, r)| *l = (*l - r * r).max(0.0));
        left[pivot] = 0.0;
        rows.push(row);
    }
    Mat::from_fn(rows.len(), size, |r, c| rows[r][c])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A stretch that passes through many cells has information on each: a cap on the rows must not cut it.
    #[test]
    fn rows_of_a_root_keep_all_but_the_share_that_may_be_left_out() {
        let size = 40;
        // smooth in the distance of two cells, as neighbours on a lattice are
        let gram = Mat::from_fn(size, size, |a, b| 3.0 * (-(a as f64 - b as f64).powi(2) / 4.0).exp() + if a == b { 0.01 } else { 0.0 });
        let left = |left_out: f64| {
            let root = pivoted_root(&gram, size, left_out);
            let again = root.transpose() * &root;
            let missing: f64 = (0..size).map(|k| gram[(k, k)] - again[(k, k)]).sum();
            (root.nrows(), missing / (3.01 * size as f64))
        };
        let (rows, missing) = left(1e-3);
        assert!(rows > 12 && rows <= size && missing.abs() <= 1e-3, "{rows} {missing}");
        let (rows, missing) = left(0.2);
        assert!(rows < size / 2 && missing <= 0.2, "{rows} {missing}");
    }
}
