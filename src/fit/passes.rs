//! Passes over all segments: speeds along them, residuals, and the sums of the normal equations.

use super::actuator::LaggedCommand;
use super::gram::{Gram, LocalGram};
use super::kalman::{Noise, smooth, whiten};
use super::lattice::LatticeSurface;
use super::regressors::{matrix, nuisance, predicted};
use super::segment::{Calibration, Segment};
use crate::map::Gear;
use rayon::prelude::*;

/// Noise that lets the speed go where the readings say: for the first smoothing, before there is a surface.
const WIDE: Noise = Noise { disturbance_mps2: 1.5, disturbance_time_s: 0.3, offset_mps2: 0.5, reading_mps: [0.01, 0.01] };
/// Segments handled at once; sums are merged in their order.
const BATCH: usize = 64;

/// Speeds along the segments from their readings alone.
pub(crate) fn wide_speeds(segments: &[Segment]) -> Vec<Vec<f64>> {
    segments.par_iter().map(wide_speed).collect()
}

fn wide_speed(segment: &Segment) -> Vec<f64> {
    let readings: Vec<f64> = segment.readings.iter().map(|r| r.speed_mps).collect();
    smooth(&readings, &segment.readings, segment.start_s, &WIDE, segment.start_std_mps).speed_mps
}

/// What a pass goes by.
#[derive(Clone, Copy)]
pub(crate) struct Way<'a> {
    /// Lagged command of each log.
    pub(crate) lagged: &'a [LaggedCommand],
    pub(crate) calibration: &'a Calibration,
    /// Forward, reverse.
    pub(crate) surfaces: &'a [LatticeSurface; 2],
    pub(crate) noise: &'a Noise,
}

/// What a pass finds along each segment, one entry per reading.
#[derive(Debug, Clone, Default)]
pub(crate) struct Along {
    /// Smoothed speeds [m/s].
    pub(crate) speeds: Vec<Vec<f64>>,
    /// Readings less what the surface predicts [m/s].
    pub(crate) residuals: Vec<Vec<f64>>,
    /// The same, whitened.
    pub(crate) white: Vec<Vec<f64>>,
}

impl Way<'_> {
    fn surface(&self, segment: &Segment) -> &LatticeSurface {
        &self.surfaces[usize::from(segment.gear == Gear::Reverse)]
    }

    /// Effective torque of the segment's gear at a time [N·m].
    fn torque_nm(&self, segment: &Segment, t_s: f64) -> f64 {
        segment.gear.sign() * self.lagged[segment.log].at(t_s - self.calibration.dead_time_s[segment.log]).torque_nm
    }

    /// Speeds, residuals and whitened residuals. `known` are speeds from a pass over the same segments with a surface near to this one.
    pub(crate) fn along(&self, segments: &[Segment], known: Option<&[Vec<f64>]>) -> Along {
        let parts: Vec<[Vec<f64>; 3]> = segments
            .par_iter()
            .enumerate()
            .map(|(k, s)| {
                let (mut speed, rounds) = known.map_or_else(|| (wide_speed(s), 2), |known| (known[k].clone(), 1));
                let mut residual = Vec::new();
                for _ in 0..rounds {
                    let model = predicted(s, &speed, &|t| self.torque_nm(s, t), self.surface(s));
                    residual = s.readings.iter().zip(&model).map(|(r, m)| r.speed_mps - m).collect();
                    let deviation = smooth(&residual, &s.readings, s.start_s, self.noise, s.start_std_mps).speed_mps;
                    speed = model.iter().zip(&deviation).map(|(m, d)| (m + d).max(0.0)).collect();
                }
                let mut white = residual.clone();
                whiten(&mut white, 1, &s.readings, s.start_s, self.noise, s.start_std_mps);
                [speed, residual, white]
            })
            .collect();
        let mut along = Along::default();
        for [speed, residual, white] in parts {
            along.speeds.push(speed);
            along.residuals.push(residual);
            along.white.push(white);
        }
        along
    }

    /// The sums of both gears, fold by fold.
    pub(crate) fn assemble(
        &self,
        segments: &[Segment],
        speeds: &[Vec<f64>],
        with_nuisance: bool,
        logs: usize,
        (fold, folds): (&[usize], usize),
    ) -> Vec<[Gram; 2]> {
        let nuisances = if with_nuisance { nuisance::DEAD_TIME + logs } else { 0 };
        let size = self.surfaces[0].lattice.columns() + nuisances + 1;
        let mut grams = vec![[Gram::new(size), Gram::new(size)]; folds];
        let paired: Vec<((&Segment, &Vec<f64>), &usize)> = segments.iter().zip(speeds).zip(fold).collect();
        for batch in paired.chunks(BATCH) {
            let locals: Vec<(Gear, usize, LocalGram)> = batch
                .par_iter()
                .map(|((s, speed), fold)| {
                    let dead_time_s = self.calibration.dead_time_s[s.log];
                    let mut local = matrix(s, speed, &self.lagged[s.log], dead_time_s, self.surface(s), with_nuisance);
                    let width = local.columns.len();
                    whiten(&mut local.data, width, &s.readings, s.start_s, self.noise, s.start_std_mps);
                    (s.gear, **fold, LocalGram::new(local.columns, &local.data))
                })
                .collect();
            for (gear, fold, local) in locals {
                grams[fold][usize::from(gear == Gear::Reverse)].add(&local);
            }
        }
        grams
    }

    /// Root mean square change of the surface over the readings since `before` [m/s²].
    pub(crate) fn movement(&self, segments: &[Segment], speeds: &[Vec<f64>], before: &[LatticeSurface; 2]) -> f64 {
        let (mut sum, mut count) = (0.0, 0);
        for (s, speed) in segments.iter().zip(speeds) {
            let before = &before[usize::from(s.gear == Gear::Reverse)];
            for (reading, v) in s.readings.iter().zip(speed).step_by(5) {
                let u = self.torque_nm(s, reading.t_s);
                sum += (self.surface(s).accel_mps2(*v, u) - before.accel_mps2(*v, u)).powi(2);
                count += 1;
            }
        }
        (sum / f64::from(count.max(1))).sqrt()
    }
}

/// The offset of each segment [m/s²].
pub(crate) fn offsets_of(segments: &[Segment], residuals: &[Vec<f64>], noise: &Noise) -> Vec<f64> {
    segments.iter().zip(residuals).map(|(s, r)| smooth(r, &s.readings, s.start_s, noise, s.start_std_mps).offset_mps2).collect()
}

/// The sum over the folds, in their order.
pub(crate) fn total(folds: &[[Gram; 2]]) -> [Gram; 2] {
    let mut sum = folds[0].clone();
    for fold in &folds[1..] {
        sum.iter_mut().zip(fold).for_each(|(a, b)| a.add_all(b));
    }
    sum
}
