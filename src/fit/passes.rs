//! Passes over all segments: speeds along them, residuals, and the sums of the normal equations.
//!
//! The speeds at which the surface is looked up are filtered, not smoothed: smoothed ones hold a part of the very disturbance that the
//! innovations are to tell, and runs that are ended by their speed then bias surface and lag by several standard errors in an hour of data
//! (`speeds.rs`).

use super::course::{Course, surface_of};
use super::gram::Gram;
use super::kalman::{Noise, filter, smooth};
use super::lattice::LatticeSurface;
use super::regressors::{Free, whitened_sums};
use super::segment::Segment;
use super::speeds::Speeds;
use crate::map::Gear;
use rayon::prelude::*;

/// Noise that lets the speed go where the readings say: for the first smoothing, before there is a surface.
const WIDE: Noise = Noise { disturbance_mps2: 1.5, disturbance_time_s: 0.3, offset_mps2: 0.5, reading_mps: [0.01, 0.01], start_scale: 1.0 };
/// Segments added up together, one after another, while they are near; these sums are merged in their order.
const TOGETHER: usize = 32;
/// Such sums handled at once.
const AT_ONCE: usize = 8;

/// Speeds along the segments from their readings alone.
pub(crate) fn wide_speeds(courses: &[Course]) -> Vec<Speeds> {
    courses.par_iter().map(|c| wide_speed(c.segment).into()).collect()
}

/// Speeds along one segment from its readings alone.
pub(crate) fn wide_speed(segment: &Segment) -> Vec<f64> {
    let readings: Vec<f64> = segment.readings.iter().map(|r| r.speed_mps).collect();
    smooth(&readings, &segment.readings, segment.start_s, &WIDE, segment.start_std(&WIDE)).speed_mps
}

/// Smoothed speeds along segments, from the `residuals` of a pass.
pub(crate) fn smoothed_speeds(segments: &[Segment], residuals: &[Vec<f64>], noise: &Noise) -> Vec<Vec<f64>> {
    let of = |(s, residual): (&Segment, &Vec<f64>)| -> Vec<f64> {
        let deviation = smooth(residual, &s.readings, s.start_s, noise, s.start_std(noise)).speed_mps;
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
    /// Filtered.
    pub(crate) speeds: Vec<Speeds>,
    /// Readings less what the surface predicts [m/s].
    pub(crate) residuals: Vec<Vec<f64>>,
    /// The same, whitened.
    pub(crate) white: Vec<Vec<f64>>,
    /// Offset of each segment [m/s²].
    pub(crate) offsets: Vec<f64>,
}

/// The same along one segment.
pub(crate) struct AlongOne {
    pub(crate) speeds: Speeds,
    /// Standard deviation of the speed that is expected at each reading [m/s].
    pub(crate) expected_std_mps: Vec<f64>,
    residual_mps: Vec<f64>,
    white: Vec<f64>,
    offset_mps2: f64,
}

/// What a pass finds along one segment, the surface looked up at the given speeds.
pub(crate) fn along_one(course: &Course, surface: &LatticeSurface, noise: &Noise, speeds: &Speeds) -> AlongOne {
    let s = course.segment;
    let model = course.predicted(speeds, surface);
    let residual_mps: Vec<f64> = s.readings.iter().zip(&model).map(|(r, m)| r.speed_mps - m).collect();
    let filtered = filter(&residual_mps, &s.readings, s.start_s, noise, s.start_std(noise));
    let on_model = |deviation: &[f64]| model.iter().zip(deviation).map(|(m, d)| (m + d).max(0.0)).collect();
    AlongOne {
        speeds: Speeds { before: on_model(&filtered.expected_mps), after: on_model(&filtered.speed_mps) },
        expected_std_mps: filtered.expected_std_mps,
        residual_mps,
        white: filtered.white,
        offset_mps2: filtered.offset_mps2,
    }
}

impl Pass<'_> {
    /// Speeds, residuals and whitened residuals. `known` are speeds from a pass over the same segments with a surface near to this one.
    pub(crate) fn along(&self, known: Option<&[Speeds]>) -> Along {
        let one = |(k, course): (usize, &Course)| {
            let surface = surface_of(self.surfaces, course.segment);
            match known {
                Some(known) => along_one(course, surface, self.noise, &known[k]),
                None => along_one(course, surface, self.noise, &wide_speed(course.segment).into()),
            }
        };
        let parts: Vec<AlongOne> = self.courses.par_iter().enumerate().map(one).collect();
        let mut along = Along::default();
        for part in parts {
            along.offsets.push(part.offset_mps2);
            along.speeds.push(part.speeds);
            along.residuals.push(part.residual_mps);
            along.white.push(part.white);
        }
        along
    }

    /// The sums of both gears, fold by fold.
    pub(crate) fn assemble(&self, speeds: &[Speeds], free: Free, logs: usize, (fold, folds): (&[usize], usize)) -> Vec<[Gram; 2]> {
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
    pub(crate) fn movement(&self, speeds: &[Speeds], before: &[LatticeSurface; 2]) -> f64 {
        let (mut sum, mut count) = (0.0, 0);
        for (course, speed) in self.courses.iter().zip(speeds) {
            let (before, now) = (surface_of(before, course.segment), surface_of(self.surfaces, course.segment));
            for (row, v) in speed.after.iter().enumerate().step_by(5) {
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
