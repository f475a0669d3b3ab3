//! Cross-validation blocked by run: how well the surface predicts runs that were not fitted, and how much of the surface is used.
//!
//! Whole runs are dealt into five folds. The whitened normal equations are sums over segments, so the equations without a fold are the
//! whole ones minus the fold's. They are solved at the final noise for the surface and its delays. The penalties are chosen again: those of
//! the whole fit have seen the runs left out, and keep the waves that all runs share by chance. Two models predict the runs left out: the
//! physics form alone, with whitened errors e, and the whole surface, with e − Δ, where Δ is the difference of the two predictions. With a
//! share w of the surface's deviations the errors are e − wΔ, and least for ŵ = ΣeΔ/ΣΔ² (stacking: Wolpert 1992, *Stacked generalization*;
//! Breiman 1996, *Stacked regressions*), from 0 to 1.
//!
//! If the physics form were right, ΣeΔ would be zero but for its standard error √(φΣΔ²), since neither Δ nor the form was fitted to the
//! runs left out; φ is the errors' variance, 1 when the noise model is right. With z = ΣeΔ in its standard errors, ŵ is known to ŵ/z and is
//! shrunk accordingly: w = ŵ·(1 − 1/z²), and 0 below z = 1. So the surface is used as far as the data support it. With an all-or-nothing
//! threshold, maps of two drives of one vehicle would differ by the side of the threshold on which they fell.

use crate::fit::motion::integration::{Course, surface_of};
use crate::fit::motion::lookup_speeds::Speeds;
use crate::fit::noise::model::Noise;
use crate::fit::noise::whitening::whiten;
use crate::fit::rounds::sampling::scramble;
use crate::fit::solve::normal_equations::Gram;
use crate::fit::solve::penalised_least_squares::{SETTLING_ROUNDS, Solution, System};
use crate::fit::solve::shrinkage::{mixed, physics_alone};
use crate::fit::surface::design::Design;
use crate::fit::surface::lattice::{Lattice, LatticeSurface};
use crate::map::{Gear, PerGear};
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Number of folds, when there are as many runs.
const FOLDS: usize = 5;
/// Fewest runs for a comparison: with fewer, the physics form alone is used.
const FEWEST_RUNS: usize = 4;

/// Surfaces of both gears: forward, reverse.
pub(crate) type Surfaces = PerGear<LatticeSurface>;

/// Results of the comparison.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ModelComparison {
    /// By how much the whole surface reduces the whitened squared error of the physics form, on runs left out.
    pub(crate) gain: f64,
    /// ΣeΔ in its standard errors: the evidence for the surface.
    pub(crate) in_std_errs: f64,
    /// Number of runs compared.
    pub(crate) runs: usize,
    /// w: the share of the surface's deviations from the physics form that is used, 0 to 1.
    pub(crate) surface_share: f64,
}

/// Folds, the surfaces fitted without each, and how the models compare.
#[derive(Debug, Clone)]
pub(crate) struct Validation {
    /// The fold of each segment.
    pub(crate) fold: Vec<usize>,
    /// The surfaces fitted without each fold, with the share w.
    pub(crate) without: Vec<Surfaces>,
    /// The comparison.
    pub(crate) comparison: ModelComparison,
}

/// The fold of each segment and the number of folds: runs are shuffled, in the same way each time, and dealt in turn, so that a campaign's
/// own rhythm does not put all runs of a level into one fold. One fold when there is one run.
pub(crate) fn deal(courses: &[Course]) -> (Vec<usize>, usize) {
    let run_of: Vec<(usize, usize)> = courses.iter().map(|c| (c.segment.log, c.segment.run)).collect();
    deal_runs(&run_of)
}

fn deal_runs(run_of: &[(usize, usize)]) -> (Vec<usize>, usize) {
    let mut runs = run_of.to_vec();
    runs.sort_unstable();
    runs.dedup();
    let mut shuffled: Vec<(u64, (usize, usize))> = runs.iter().enumerate().map(|(k, run)| (scramble(k as u64), *run)).collect();
    shuffled.sort_unstable();
    let count = FOLDS.min(runs.len()).max(1);
    let fold: BTreeMap<(usize, usize), usize> = shuffled.iter().enumerate().map(|(k, (_, run))| (*run, k % count)).collect();
    (run_of.iter().map(|run| fold[run]).collect(), count)
}

/// Inputs of the comparison, fold by fold.
pub(crate) struct HeldOut<'a> {
    /// The fold of each segment.
    pub(crate) fold: &'a [usize],
    /// The sums of both gears of each fold.
    pub(crate) folds: &'a [PerGear<Gram>],
    /// The equations of all folds.
    pub(crate) whole: &'a System,
    /// Prior standard deviations of the nuisance columns.
    pub(crate) prior: &'a [f64],
    pub(crate) courses: &'a [Course<'a>],
    pub(crate) speeds: &'a [Speeds],
    pub(crate) noise: &'a Noise,
}

/// Cross-validates. `None` with fewer than two folds, or if only the runs of one fold hold some information.
pub(crate) fn validate(design: &Design, lattice: &Lattice, gears: &[Gear], held_out: &HeldOut) -> Option<Validation> {
    let HeldOut { fold, folds, whole, prior, .. } = *held_out;
    if folds.len() < 2 {
        return None;
    }
    let fit_without = |grams: &PerGear<Gram>| -> Option<Without> {
        let pairs: Vec<(Gear, &Gram)> = gears.iter().map(|g| (*g, &grams[*g])).collect();
        let rest = whole.without(&System::new(design, &pairs, prior.len()));
        let surface = rest.solve(&design.blocks, &[], SETTLING_ROUNDS, prior)?;
        let physics = rest.solve(&design.blocks, &physics_alone(&design.blocks), SETTLING_ROUNDS, prior)?;
        let fitted = |solution: Solution| {
            let delays_s = solution.beta[design.coefficients()..].to_vec();
            Fitted { surfaces: design.surfaces(lattice, &solution.beta), delays_s }
        };
        Some(Without { physics: fitted(physics), surface: fitted(surface) })
    };
    let without: Vec<Without> = folds.par_iter().map(fit_without).collect::<Option<_>>()?;
    let mut runs: Vec<(usize, usize)> = held_out.courses.iter().map(|c| (c.segment.log, c.segment.run)).collect();
    runs.dedup();
    let comparison = compare(sums(held_out, &without), runs.len());
    let mixed = without.iter().map(|w| w.mixed(comparison.surface_share)).collect();
    Some(Validation { fold: fold.to_vec(), without: mixed, comparison })
}

/// The fit without a fold: surfaces, and changes of the nuisance columns.
struct Fitted {
    surfaces: Surfaces,
    delays_s: Vec<f64>,
}

/// The fits of both models without a fold.
struct Without {
    physics: Fitted,
    surface: Fitted,
}

impl Without {
    /// The surfaces with a share of the whole surface's deviations.
    fn mixed(&self, share: f64) -> Surfaces {
        PerGear::from_fn(|gear| {
            let (physics, surface) = (&self.physics.surfaces[gear], &self.surface.surfaces[gear]);
            LatticeSurface { lattice: physics.lattice.clone(), theta: mixed(&physics.theta, &surface.theta, share) }
        })
    }
}

/// Sums over the runs left out: e², e·Δ and Δ², and the number of errors.
#[derive(Debug, Clone, Copy, Default)]
struct Sums {
    squared: f64,
    with_difference: f64,
    difference_squared: f64,
    count: f64,
}

/// The sums over all runs, each compared with the fit without its fold.
fn sums(held_out: &HeldOut, without: &[Without]) -> Sums {
    let of_segments: Vec<Sums> = held_out
        .courses
        .par_iter()
        .zip(held_out.speeds)
        .zip(held_out.fold)
        .map(|((course, speed), fold)| {
            let segment = course.segment;
            let predicted = |Fitted { surfaces, delays_s }: &Fitted| course.predicted_with(speed, surface_of(surfaces, segment), delays_s);
            let Without { physics, surface } = &without[*fold];
            let (physics, surface) = (predicted(physics), predicted(surface));
            let mut rows: Vec<f64> = Vec::with_capacity(2 * physics.len());
            for ((reading, p), s) in segment.readings.iter().zip(physics).zip(surface) {
                rows.extend([reading.speed_mps - p, s - p]);
            }
            whiten(&mut rows, 2, &segment.readings, segment.start_s, held_out.noise, segment.start_std(held_out.noise));
            rows.chunks_exact(2).fold(Sums::default(), |sums, row| Sums {
                squared: sums.squared + row[0] * row[0],
                with_difference: sums.with_difference + row[0] * row[1],
                difference_squared: sums.difference_squared + row[1] * row[1],
                count: sums.count + 1.0,
            })
        })
        .collect();
    // in the order of the segments: the same bits for any number of threads
    of_segments.into_iter().fold(Sums::default(), |a, b| Sums {
        squared: a.squared + b.squared,
        with_difference: a.with_difference + b.with_difference,
        difference_squared: a.difference_squared + b.difference_squared,
        count: a.count + b.count,
    })
}

/// The share of the surface that is used: none of it with too few runs to decide.
fn compare(sums: Sums, runs: usize) -> ModelComparison {
    let Sums { squared, with_difference, difference_squared, count } = sums;
    let gain = 2.0 * with_difference - difference_squared;
    let variance = (squared - gain) / count.max(1.0);
    let in_std_errs = with_difference / (variance * difference_squared).sqrt().max(1e-12);
    let surface_share = if runs >= FEWEST_RUNS && in_std_errs > 1.0 {
        (with_difference / difference_squared).min(1.0) * (1.0 - in_std_errs.powi(-2))
    } else {
        0.0
    };
    ModelComparison { gain, in_std_errs, runs, surface_share }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_run_stays_in_one_fold_and_the_folds_are_even() {
        let run_of: Vec<(usize, usize)> = (0..2).flat_map(|log| (0..46).map(move |k| (log, k / 2))).collect();
        let (fold, count) = deal_runs(&run_of);
        assert_eq!(count, 5);
        for pair in fold.chunks(2) {
            assert_eq!(pair[0], pair[1]);
        }
        let sizes: Vec<usize> = (0..count).map(|f| fold.iter().filter(|x| **x == f).count() / 2).collect();
        assert!(sizes.iter().all(|s| (9..=10).contains(s)), "{sizes:?}");
        // no fold is a plain rhythm of the order
        assert!((0..5).all(|phase| fold.iter().step_by(2).skip(phase).step_by(5).any(|f| *f != fold[2 * phase])));
    }

    #[test]
    fn the_surface_comes_in_as_the_runs_left_out_ask_for_it() {
        let share = |with_difference: f64, difference_squared: f64, runs: usize| {
            compare(Sums { squared: 1000.0, with_difference, difference_squared, count: 1000.0 }, runs).surface_share
        };
        // no evidence; less than a standard error; against it; nearly all; half of it, well known; too few runs to decide
        assert!(share(0.0, 9.0, 20) <= 0.0 && share(2.0, 9.0, 20) <= 0.0 && share(-9.0, 9.0, 20) <= 0.0);
        assert!((0.97..1.0).contains(&share(49.0, 49.0, 20)));
        assert!((0.45..0.5).contains(&share(40.0, 80.0, 20)));
        assert!(share(49.0, 49.0, 3) <= 0.0);
        // larger with more evidence, without a jump
        let shares: Vec<f64> = (0..100).map(|k| share(0.5 * f64::from(k), 25.0, 20)).collect();
        assert!(shares.windows(2).all(|s| s[1] >= s[0] - 1e-12 && s[1] - s[0] < 0.06), "{shares:?}");
    }
}
