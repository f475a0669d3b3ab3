//! Passes over all segments: speeds along them, residuals, and the sums of the normal equations.
//!
//! The surface is looked up at filtered speeds, not at smoothed ones. Smoothed speeds hold a part of the disturbance that the innovations
//! must show. Runs that end at a given speed then bias surface and lag by several standard errors in an hour of data (`lookup_speeds.rs`).

use crate::fit::motion::integration::{Course, surface_of};
use crate::fit::motion::lookup_speeds::Speeds;
use crate::fit::motion::regressors::{Free, whitened_sums};
use crate::fit::motion::segment::Segment;
use crate::fit::noise::kalman::{filter, smooth};
use crate::fit::noise::model::Noise;
use crate::fit::solve::normal_equations::Gram;
use crate::fit::surface::lattice::LatticeSurface;
use crate::map::{Gear, PerGear};
use rayon::prelude::*;

/// Noise with which the speed follows the readings: for the first smoothing, before there is a surface.
const WIDE: Noise = Noise { disturbance_mps2: 1.5, disturbance_time_s: 0.3, offset_mps2: 0.5, reading_mps: [0.01, 0.01], start_scale: 1.0 };
/// Neighbouring segments added up together, one after another; these sums are merged in their order.
const TOGETHER: usize = 32;
/// Number of such sums computed at once.
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

/// Inputs of a pass.
#[derive(Clone, Copy)]
pub(crate) struct Pass<'a> {
    pub(crate) courses: &'a [Course<'a>],
    /// Forward, reverse.
    pub(crate) surfaces: &'a PerGear<LatticeSurface>,
    pub(crate) noise: &'a Noise,
}

/// Results of a pass along the segments, one entry per reading.
#[derive(Debug, Clone, Default)]
pub(crate) struct PassResult {
    /// Filtered.
    pub(crate) speeds: Vec<Speeds>,
    /// Readings minus the surface's prediction [m/s].
    pub(crate) residuals: Vec<Vec<f64>>,
    /// The same, whitened.
    pub(crate) white: Vec<Vec<f64>>,
    /// Offset of each segment [m/s²].
    pub(crate) offsets: Vec<f64>,
}

/// The same along one segment.
pub(crate) struct SegmentResult {
    pub(crate) speeds: Speeds,
    /// Standard deviation of the speed that is expected at each reading [m/s].
    pub(crate) expected_std_mps: Vec<f64>,
    residual_mps: Vec<f64>,
    /// The residuals, whitened.
    pub(crate) white: Vec<f64>,
    offset_mps2: f64,
}

/// Results of a pass along one segment, with the surface looked up at the given speeds.
pub(crate) fn along_one(course: &Course, surface: &LatticeSurface, noise: &Noise, speeds: &Speeds) -> SegmentResult {
    let s = course.segment;
    let model = course.predicted(speeds, surface);
    let residual_mps: Vec<f64> = s.readings.iter().zip(&model).map(|(r, m)| r.speed_mps - m).collect();
    let filtered = filter(&residual_mps, &s.readings, s.start_s, noise, s.start_std(noise));
    let on_model = |deviation: &[f64]| model.iter().zip(deviation).map(|(m, d)| (m + d).max(0.0)).collect();
    SegmentResult {
        speeds: Speeds { before: on_model(&filtered.expected_mps), after: on_model(&filtered.speed_mps) },
        expected_std_mps: filtered.expected_std_mps,
        residual_mps,
        white: filtered.white,
        offset_mps2: filtered.offset_mps2,
    }
}

impl Pass<'_> {
    /// Speeds, residuals and whitened residuals. `known` are speeds from a pass over the same segments with a surface near to this one.
    pub(crate) fn along(&self, known: Option<&[Speeds]>) -> PassResult {
        let one = |(k, course): (usize, &Course)| {
            let surface = surface_of(self.surfaces, course.segment);
            match known {
                Some(known) => along_one(course, surface, self.noise, &known[k]),
                None => along_one(course, surface, self.noise, &wide_speed(course.segment).into()),
            }
        };
        let parts: Vec<SegmentResult> = self.courses.par_iter().enumerate().map(one).collect();
        let mut along = PassResult::default();
        for part in parts {
            along.offsets.push(part.offset_mps2);
            along.speeds.push(part.speeds);
            along.residuals.push(part.residual_mps);
            along.white.push(part.white);
        }
        along
    }

    /// The sums of both gears, fold by fold.
    pub(crate) fn assemble(&self, speeds: &[Speeds], free: Free, logs: usize, (fold, folds): (&[usize], usize)) -> Vec<PerGear<Gram>> {
        let size = self.surfaces.forward.lattice.columns() + free.nuisances(logs) + 1;
        let mut grams = vec![PerGear::from_fn(|_| Gram::new(size)); folds];
        for (number, grams) in grams.iter_mut().enumerate() {
            for gear in Gear::ALL {
                let gram = &mut grams[gear];
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
    pub(crate) fn movement(&self, speeds: &[Speeds], before: &PerGear<LatticeSurface>) -> f64 {
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
pub(crate) fn total(folds: &[PerGear<Gram>]) -> PerGear<Gram> {
    let mut sum = folds[0].clone();
    for fold in &folds[1..] {
        for gear in Gear::ALL {
            sum[gear].add_all(&fold[gear]);
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fit::drive::effective_torque::EffectiveTorque;
    use crate::fit::drive::lagged_command::LaggedCommand;
    use crate::fit::motion::expected_stop::readings_before_stop;
    use crate::fit::noise::model::Reading;
    use crate::fit::noise::whitening::whiten;
    use crate::fit::surface::lattice::Lattice;
    use crate::signal::Series;
    use rand::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};

    const NOISE: Noise =
        Noise { disturbance_mps2: 0.05, disturbance_time_s: 0.25, offset_mps2: 0.01, reading_mps: [0.02, 0.02], start_scale: 1.0 };
    /// Readings are so far apart [s].
    const PERIOD_S: f64 = 0.01;

    /// A(v, u) = 0.05·u + `by_speed`·v − 0.5.
    fn surface(by_speed: f64) -> LatticeSurface {
        let lattice = Lattice::new(1.0, -20.0, 20.0, 12, 9);
        let (along_speed, mut theta) = (lattice.along_speed(|v| v), vec![0.0; lattice.columns()]);
        for (i, v) in along_speed.iter().enumerate() {
            for (j, u) in lattice.torque_nm.iter().enumerate() {
                theta[lattice.column(i, j)] = 0.05 * u + by_speed * v - 0.5;
            }
        }
        LatticeSurface { lattice, theta }
    }

    fn torque(torque_nm: f64) -> EffectiveTorque {
        EffectiveTorque::lagged(LaggedCommand::new(&Series { t_s: vec![0.0], value: vec![torque_nm] }, 0.0))
    }

    fn segment(readings_mps: &[f64], anchored: bool) -> Segment {
        let reading = |(k, v): (usize, &f64)| Reading::single((k + 1) as f64 * PERIOD_S, *v, 0, k as u32);
        let start_std_mps = if anchored { 3e-3 } else { 3.0 };
        Segment {
            log: 0,
            run: 0,
            gear: Gear::Forward,
            progress: [0.0; 2],
            start_s: 0.0,
            anchored,
            start_std_mps,
            readings: readings_mps.iter().enumerate().map(reading).collect(),
        }
    }

    /// Converged speeds: each look-up uses the last filtered speeds.
    fn settled(course: &Course, surface: &LatticeSurface) -> SegmentResult {
        let mut found = along_one(course, surface, &NOISE, &wide_speed(course.segment).into());
        for _ in 0..20 {
            found = along_one(course, surface, &NOISE, &found.speeds);
        }
        found
    }

    #[test]
    fn what_is_expected_at_a_reading_does_not_depend_on_it() {
        let (torque, surface) = (torque(14.0), surface(3.0));
        let mut readings_mps: Vec<f64> = (0..60).map(|k| 0.3 * PERIOD_S * f64::from(k)).collect();
        let mut expected = Vec::new();
        for error_mps in [0.0, 0.1] {
            readings_mps[40] += error_mps;
            let segment = segment(&readings_mps, true);
            let found = settled(&Course::new(&segment, &torque, 0.0), &surface);
            expected.push((found.speeds.before[..=40].to_vec(), found.speeds.after[40]));
        }
        let [(before, after), (before_wrong, after_wrong)] = &expected[..] else { unreachable!("two readings were tried") };
        assert!(before.iter().zip(before_wrong).all(|(a, b)| (a - b).abs() < 1e-9), "{:?} {:?}", before[40], before_wrong[40]);
        assert!(after_wrong - after > 1e-3);
    }

    /// Innovations of the true surface are uncorrelated with the extra prediction of a steeper surface: their product is
    /// zero on average. It was not while look-ups leaned towards the reading.
    #[test]
    fn innovations_of_the_true_surface_do_not_lean_towards_a_steeper_one() {
        let (torque, surface) = (torque(13.0), surface(1.0));
        let mut rng = rand_pcg::Pcg64::seed_from_u64(7);
        let mut draw = || -> f64 { StandardNormal.sample(&mut rng) };
        let decay = (-PERIOD_S / NOISE.disturbance_time_s).exp();
        let (mut sum, mut squares, mut leanings) = (0.0, 0.0, Vec::new());
        for _ in 0..400 {
            let (mut v, mut d, b) = (0.0, NOISE.disturbance_mps2 * draw(), NOISE.offset_mps2 * draw());
            let mut readings_mps = Vec::new();
            for _ in 0..120 {
                v += PERIOD_S * (surface.accel_mps2(v, 13.0) + d + b);
                d = decay * d + NOISE.disturbance_mps2 * (1.0 - decay * decay).sqrt() * draw();
                readings_mps.push(v + NOISE.reading_mps[0] * draw());
            }
            let segment = segment(&readings_mps, true);
            let segment = Segment { start_std_mps: 1e-4, ..segment };
            let course = Course::new(&segment, &torque, 0.0);
            let found = settled(&course, &surface);
            let lean = |speeds: &Speeds| {
                let mut predicted = 0.0;
                let way = |row| {
                    predicted += course.along(speeds, row).map(|(v, step)| v * step.length_s).sum::<f64>();
                    predicted
                };
                let mut steeper: Vec<f64> = (0..course.rows()).map(way).collect();
                whiten(&mut steeper, 1, &segment.readings, segment.start_s, &NOISE, segment.start_std(&NOISE));
                let square: f64 = steeper.iter().map(|s| s * s).sum();
                (steeper.iter().zip(&found.white).map(|(s, e)| s * e).sum::<f64>(), square)
            };
            let (own, square) = lean(&found.speeds);
            sum += own;
            squares += square;
            leanings.push(lean(&found.speeds.after.clone().into()).0 - own);
        }
        assert!(sum.abs() < 3.0 * squares.sqrt(), "{}", sum / squares.sqrt());
        let runs = leanings.len() as f64;
        let mean = leanings.iter().sum::<f64>() / runs;
        let spread = (leanings.iter().map(|l| (l - mean).powi(2)).sum::<f64>() / runs).sqrt();
        assert!(mean > 10.0 * spread / runs.sqrt(), "{mean} {spread}");
    }

    #[test]
    fn a_segment_ends_before_the_stop_whatever_the_last_readings_say() {
        let (torque, surface) = (torque(-10.0), surface(0.0));
        // v̇ = −1 m/s² from 0.5 m/s: the wheel is at rest from 0.5 s on
        let true_mps: Vec<f64> = (1..=80).map(|k| (0.5 - PERIOD_S * f64::from(k)).max(0.0)).collect();
        let end = |readings_mps: &[f64]| {
            let segment = segment(readings_mps, false);
            readings_before_stop(&Course::new(&segment, &torque, 0.0), &surface, &NOISE, 8)
        };
        let first = end(&true_mps).unwrap_or(0);
        assert!((40..50).contains(&first), "{first}");
        for error_mps in [-0.1, 0.03, 0.1] {
            let mut readings_mps = true_mps.clone();
            readings_mps[first..].iter_mut().for_each(|v| *v += error_mps);
            assert_eq!(end(&readings_mps), Some(first));
        }
        // a wheel that speeds up has no stop before it
        let faster: Vec<f64> = (1..=80).map(|k| PERIOD_S * 0.5 * f64::from(k)).collect();
        let segment = segment(&faster, false);
        assert_eq!(
            readings_before_stop(
                &Course::new(&segment, &crate::fit::motion::passes::tests::torque(20.0), 0.0),
                &crate::fit::motion::passes::tests::surface(0.0),
                &NOISE,
                8
            ),
            None
        );
    }
}
