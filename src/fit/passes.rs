//! Passes over all segments: speeds along them, residuals, and the sums of the normal equations.
//!
//! The speeds at which the surface is looked up are filtered, not smoothed: what a reading predicts may depend on earlier ones only (Ljung,
//! *System Identification*). Smoothed speeds hold a part of the very disturbance that the innovations are to tell, and runs that are ended
//! by their speed then bias surface and lag by several standard errors in an hour of data.

use super::course::{Course, surface_of};
use super::gram::Gram;
use super::kalman::{Noise, filter, smooth};
use super::lattice::LatticeSurface;
use super::regressors::{Free, whitened_sums};
use super::segment::Segment;
use crate::map::Gear;
use rayon::prelude::*;
use std::borrow::Cow;

/// Noise that lets the speed go where the readings say: for the first smoothing, before there is a surface.
const WIDE: Noise = Noise { disturbance_mps2: 1.5, disturbance_time_s: 0.3, offset_mps2: 0.5, reading_mps: [0.01, 0.01] };
/// Segments added up together, one after another, while they are near; these sums are merged in their order.
const TOGETHER: usize = 32;
/// Such sums handled at once.
const AT_ONCE: usize = 8;

/// Speeds along the segments from their readings alone.
pub(crate) fn wide_speeds(courses: &[Course]) -> Vec<Vec<f64>> {
    courses.par_iter().map(|c| wide_speed(c.segment)).collect()
}

/// Speeds along one segment from its readings alone.
pub(crate) fn wide_speed(segment: &Segment) -> Vec<f64> {
    let readings: Vec<f64> = segment.readings.iter().map(|r| r.speed_mps).collect();
    smooth(&readings, &segment.readings, segment.start_s, &WIDE, segment.start_std_mps).speed_mps
}

/// Smoothed speeds along segments, from the `residuals` of a pass.
pub(crate) fn smoothed_speeds(segments: &[Segment], residuals: &[Vec<f64>], noise: &Noise) -> Vec<Vec<f64>> {
    let of = |(s, residual): (&Segment, &Vec<f64>)| -> Vec<f64> {
        let deviation = smooth(residual, &s.readings, s.start_s, noise, s.start_std_mps).speed_mps;
        s.readings.iter().zip(residual).zip(deviation).map(|((r, e), d)| (r.speed_mps - e + d).max(0.0)).collect()
    };
    segments.par_iter().zip(residuals).map(of).collect()
}

/// What a pass goes by.
#[derive(Clone, Copy)]
pub(crate) struct Pass<'a> {
    pub(crate) courses: &'a [Course<'a>],
    /// Forward, reverse.
    pub(crate) surfaces: &'a [LatticeSurface; 2],
    pub(crate) noise: &'a Noise,
}

/// What a pass finds along each segment, one entry per reading.
#[derive(Debug, Clone, Default)]
pub(crate) struct Along {
    /// Filtered speeds [m/s].
    pub(crate) speeds: Vec<Vec<f64>>,
    /// Readings less what the surface predicts [m/s].
    pub(crate) residuals: Vec<Vec<f64>>,
    /// The same, whitened.
    pub(crate) white: Vec<Vec<f64>>,
    /// Offset of each segment [m/s²].
    pub(crate) offsets: Vec<f64>,
}

impl Pass<'_> {
    /// Speeds, residuals and whitened residuals. `known` are speeds from a pass over the same segments with a surface near to this one.
    pub(crate) fn along(&self, known: Option<&[Vec<f64>]>) -> Along {
        let parts: Vec<([Vec<f64>; 3], f64)> = self
            .courses
            .par_iter()
            .enumerate()
            .map(|(k, course)| {
                let s = course.segment;
                let speed = known.map_or_else(|| Cow::Owned(wide_speed(s)), |known| Cow::Borrowed(&known[k]));
                let model = course.predicted(&speed, surface_of(self.surfaces, s));
                let residual: Vec<f64> = s.readings.iter().zip(&model).map(|(r, m)| r.speed_mps - m).collect();
                let (deviation, white) = filter(&residual, &s.readings, s.start_s, self.noise, s.start_std_mps);
                let speed = model.iter().zip(&deviation.speed_mps).map(|(m, d)| (m + d).max(0.0)).collect();
                ([speed, residual, white], deviation.offset_mps2)
            })
            .collect();
        let mut along = Along::default();
        for ([speed, residual, white], offset) in parts {
            along.offsets.push(offset);
            along.speeds.push(speed);
            along.residuals.push(residual);
            along.white.push(white);
        }
        along
    }

    /// The sums of both gears, fold by fold.
    pub(crate) fn assemble(&self, speeds: &[Vec<f64>], free: Free, logs: usize, (fold, folds): (&[usize], usize)) -> Vec<[Gram; 2]> {
        let size = self.surfaces[0].lattice.columns() + free.nuisances(logs) + 1;
        let mut grams = vec![[Gram::new(size), Gram::new(size)]; folds];
        for (number, grams) in grams.iter_mut().enumerate() {
            for (gear, gram) in Gear::ALL.into_iter().zip(grams) {
                let of_gear = |k: &usize| fold[*k] == number && self.courses[*k].segment.gear == gear;
                let own: Vec<usize> = (0..self.courses.len()).filter(of_gear).collect();
                for batch in own.chunks(TOGETHER * AT_ONCE) {
                    let sum = |segments: &[usize]| {
                        let mut sum = Gram::new(size);
                        for &k in segments {
                            let course = &self.courses[k];
                            let surface = surface_of(self.surfaces, course.segment);
                            sum.add(&whitened_sums(course, &speeds[k], surface, self.noise, free));
                        }
                        sum
                    };
                    let sums: Vec<Gram> = batch.par_chunks(TOGETHER).map(sum).collect();
                    for sum in &sums {
                        gram.add_all(sum);
                    }
                }
            }
        }
        grams
    }

    /// Root mean square change of the surface over the readings since `before` [m/s²].
    pub(crate) fn movement(&self, speeds: &[Vec<f64>], before: &[LatticeSurface; 2]) -> f64 {
        let (mut sum, mut count) = (0.0, 0);
        for (course, speed) in self.courses.iter().zip(speeds) {
            let (before, now) = (surface_of(before, course.segment), surface_of(self.surfaces, course.segment));
            for (row, v) in speed.iter().enumerate().step_by(5) {
                let u = course.steps(row).last().map_or(0.0, |s| s.torque.torque_nm);
                sum += (now.accel_mps2(*v, u) - before.accel_mps2(*v, u)).powi(2);
                count += 1;
            }
        }
        (sum / f64::from(count.max(1))).sqrt()
    }
}

/// The sum over the folds, in their order.
pub(crate) fn total(folds: &[[Gram; 2]]) -> [Gram; 2] {
    let mut sum = folds[0].clone();
    for fold in &folds[1..] {
        sum.iter_mut().zip(fold).for_each(|(a, b)| a.add_all(b));
    }
    sum
}
