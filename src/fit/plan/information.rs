//! What runs tell of the surface's coefficients.

use super::super::anova::Design;
use super::super::course::Course;
use super::super::gram::LocalGram;
use super::super::kalman::Noise;
use super::super::lattice::{Lattice, LatticeSurface};
use super::super::regressors::{Free, whitened};
use super::super::{Error, Result, Settings};
use super::drive::{Part, READING_S, Vehicle};
use crate::map::{Gear, Table1File};
use faer::Mat;
use faer::linalg::solvers::DenseSolveCore;
use rayon::prelude::*;

/// Rows of a run's information are added until so little of its trace is left.
const LEFT_OUT: f64 = 1e-3;
/// Most rows of one stretch.
const MOST_ROWS: usize = 12;
/// Standard deviation that a block of coefficients may at least add to the surface [m/s², root mean square over the lattice]: what the data
/// so far did not ask for is not thereby known to be nothing.
const UNSEEN_MPS2: f64 = 0.01;
/// Usual rates of an encoder and of a yaw rate [Hz].
const RATE_HZ: [f64; 2] = [50.0, 100.0];
/// Most speeds of a gear's cells.
const MOST_SPEEDS: usize = 15;

/// A matrix R of few rows with RᵀR the information on the coefficients of the design.
pub(super) type Information = Mat<f64>;

/// A cell whose torque is to be known.
pub(super) struct Cell {
    pub(super) gear: Gear,
    pub(super) speed_mps: f64,
    pub(super) torque_nm: f64,
    /// The row c with cᵀβ the torque [N·m].
    pub(super) contrast: Vec<f64>,
}

/// The estimator's regressors over the surface of a `table1.json`.
pub(super) struct Model {
    surface: LatticeSurface,
    pub(super) design: Design,
    noise: Noise,
    pub(super) vehicles: Vec<Vehicle>,
    /// Torques that may be driven [N·m], rising.
    pub(super) levels_nm: Vec<f64>,
    breaks: (Vec<f64>, Vec<f64>),
}

impl Model {
    pub(super) fn new(file: &Table1File) -> Result<Self> {
        let settings: Settings = serde_json::from_value(file.settings.clone()).unwrap_or_default();
        let used: Vec<_> = file.report.runs.iter().filter(|r| r.used_s > 0.0).collect();
        let mut torques: Vec<f64> = file.maps.iter().flat_map(|m| m.torque_nm.iter().copied()).collect();
        torques.sort_unstable_by(f64::total_cmp);
        torques.dedup_by(|a, b| (*a - *b).abs() < 1e-6);
        let speeds: Vec<f64> = file.maps.iter().map(|m| m.speed_mps.clone()).max_by_key(Vec::len).unwrap_or_default();
        let (Some(&low), Some(&high), Some(&fastest)) = (torques.first(), torques.last(), speeds.last()) else {
            return Err(Error::NothingToPlan);
        };
        if used.is_empty() || high <= low || high <= 0.0 || fastest <= 0.0 {
            return Err(Error::NothingToPlan);
        }
        let high = file.vehicle.torque_limit_nm.map_or(high, |limit| high.min(limit));
        let lattice = Lattice::new(fastest, low, high, settings.speed_nodes.clamp(4, 40), settings.torque_nodes.clamp(6, 60));
        let design = Design::new(&lattice, file.maps.iter().any(|m| m.gear != file.maps[0].gear));
        // one series of readings that tells as much as all witnesses together
        let precision: f64 = file.witnesses.iter().zip(RATE_HZ).map(|(w, rate)| rate / (w.noise_mps * w.noise_mps).max(1e-8)).sum();
        let precision = if precision > 0.0 { precision } else { RATE_HZ[0] / (file.noise.speed_noise_mps.powi(2)).max(1e-8) };
        let noise = Noise {
            disturbance_mps2: file.noise.disturbance_mps2.max(1e-4),
            disturbance_time_s: file.noise.disturbance_time_s.max(0.01),
            offset_mps2: file.noise.run_offset_mps2.max(1e-4),
            reading_mps: [(1.0 / (precision * READING_S)).sqrt(); 2],
        };
        let reached = used.iter().fold(0.0f64, |m, r| m.max(r.start_speed_mps).max(r.end_speed_mps));
        // a level that ends at a speed overshoots it by some 0.04 m/s
        let fastest_mps = ((reached.min(fastest) - 0.04) * 20.0).floor().max(1.0) / 20.0;
        let mut vehicles = Vec::new();
        for map in &file.maps {
            vehicles.push(Vehicle {
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
        let torques = torques.into_iter().filter(|u| *u <= high + 1e-9).collect();
        let every = speeds.iter().filter(|v| **v <= fastest_mps + 1e-9).count().div_ceil(MOST_SPEEDS).max(1);
        let speeds = speeds.into_iter().filter(|v| *v <= fastest_mps + 1e-9).step_by(every).collect();
        let theta = vec![0.0; lattice.columns()];
        Ok(Self { surface: LatticeSurface { lattice, theta }, design, noise, vehicles, levels_nm, breaks: (speeds, torques) })
    }

    /// The information of stretches of a gear.
    pub(super) fn information(&self, gear: Gear, parts: &[Part]) -> Information {
        let t = self.design.transform(gear);
        let q = t.ncols();
        let blocks: Vec<Mat<f64>> = parts
            .iter()
            .map(|part| {
                let s = &part.segment;
                // the command holds its dead time already only where it was taken off here
                let dead_time_s = self.vehicles[0].dead_time_s;
                let course = Course::new(s, &part.command, dead_time_s);
                let local = whitened(&course, &part.speed_mps, &self.surface, &self.noise, Free::Surface);
                let width = local.columns.len();
                let gram = LocalGram::new(local.columns, &local.data);
                let root = pivoted_root(&gram.values, width - 1);
                let touched = Mat::from_fn(width - 1, q, |r, c| t[(gram.columns[r] as usize, c)]);
                &root * &touched
            })
            .collect();
        let rows = blocks.iter().map(Mat::nrows).sum();
        let mut all = Mat::zeros(rows, q);
        let mut at = 0;
        for block in &blocks {
            all.submatrix_mut(at, 0, block.nrows(), q).copy_from(block);
            at += block.nrows();
        }
        all
    }

    /// (XᵀX + Λ)⁻¹ of the runs that the file reports.
    pub(super) fn covariance(&self, file: &Table1File) -> Result<Mat<f64>> {
        let q = self.design.coefficients();
        let driven: Vec<Information> = file
            .report
            .runs
            .par_iter()
            .filter(|r| r.used_s > 0.0)
            .filter_map(|r| {
                let vehicle = self.vehicles.iter().find(|v| v.gear == r.gear)?;
                let parts = vehicle.driven(r.torque_nm, r.start_speed_mps.max(0.0), r.used_s.min(30.0));
                Some(self.information(r.gear, &parts))
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

    /// The diagonal of Λ: what the fit chose, yet no tighter than [`UNSEEN_MPS2`] allows.
    fn ridge(&self, file: &Table1File) -> Vec<f64> {
        let t = self.design.transform(Gear::Forward);
        let told = |name: &str| {
            let blocks = file.report.diagnostics.get("blocks")?.as_array()?;
            blocks.iter().find(|b| b.get("block").and_then(serde_json::Value::as_str) == Some(name))?.get("penalty")?.as_f64()
        };
        let mut ridge = vec![0.0; self.design.coefficients()];
        for block in &self.design.blocks {
            // the variance that unit coefficients of this block give the surface, mean over the lattice
            let unit = block.range.clone().map(|c| (0..t.nrows()).map(|r| t[(r, c)].powi(2)).sum::<f64>()).sum::<f64>() / t.nrows() as f64;
            let penalty = if block.penalised {
                let most = unit / (UNSEEN_MPS2 * UNSEEN_MPS2);
                told(block.name).filter(|p| *p > 0.0).map_or(most, |p| p.min(most))
            } else {
                // vague: 10 m/s²
                unit / 100.0
            };
            ridge[block.range.clone()].fill(penalty.max(1e-9));
        }
        ridge
    }

    /// The cells of both gears whose torque is to be known, just moving included.
    pub(super) fn cells(&self) -> Vec<Cell> {
        let mut cells = Vec::new();
        let (speeds, torques) = &self.breaks;
        for vehicle in &self.vehicles {
            let slope_at = |v: f64, u: f64| {
                let axis = vehicle.surface.torque_nm();
                let (low, high) = ((u - 1.5).max(axis.first()), (u + 1.5).min(axis.last()));
                if high > low { (vehicle.accel_mps2(v, high) - vehicle.accel_mps2(v, low)) / (high - low) } else { 0.0 }
            };
            let (low, high) = (torques[0], torques[torques.len() - 1]);
            let mean = (vehicle.accel_mps2(0.0, high) - vehicle.accel_mps2(0.0, low)) / (high - low);
            let t = self.design.transform(vehicle.gear);
            for &torque_nm in torques {
                for &speed_mps in speeds {
                    // where the surface is nearly level its slope is not known well enough to weigh a cell by
                    let slope = slope_at(speed_mps, torque_nm).max(0.3 * mean.abs()).max(1e-9);
                    let spot = self.surface.lattice.spot(speed_mps, torque_nm);
                    let contrast = (0..t.ncols())
                        .map(|c| spot.columns(&self.surface.lattice).map(|(r, w)| w * t[(r, c)]).sum::<f64>() / slope)
                        .collect();
                    cells.push(Cell { gear: vehicle.gear, speed_mps, torque_nm, contrast });
                }
            }
        }
        cells
    }
}

/// Rows R with RᵀR nearly the leading `size` × `size` part of a symmetric matrix: Cholesky's factor with diagonal pivots.
fn pivoted_root(gram: &Mat<f64>, size: usize) -> Mat<f64> {
    let mut left: Vec<f64> = (0..size).map(|k| gram[(k, k)]).collect();
    let total: f64 = left.iter().sum();
    let mut rows: Vec<Vec<f64>> = Vec::new();
    while rows.len() < MOST_ROWS.min(size) && left.iter().sum::<f64>() > LEFT_OUT * total {
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
