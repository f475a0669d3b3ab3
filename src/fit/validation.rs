//! Cross-validation blocked by run: what each model tells about runs that it has not seen.
//!
//! Whole runs are dealt into five folds. The whitened normal equations are sums over segments, so the equations without a fold are the
//! whole ones minus the fold's; they are solved at the final noise and penalties, for the surface and its delays. Two models are compared
//! on the runs left out by their whitened errors, e of the physics form alone and e − Δ of the whole surface, Δ the difference of what the
//! two predict. The surface's gain is D = Σe² − Σ(e − Δ)².
//!
//! Were the physics form right, ΣeΔ would be zero but for its standard error √(φΣΔ²), since neither Δ nor the form was fitted to the runs
//! left out; φ is the errors' variance, 1 when the noise model is right. The surface is taken when ΣeΔ exceeds 3.5 standard errors and D is
//! positive. Two would do if the penalties had not seen the runs left out: they keep the waves that all runs share by chance, and 27
//! campaigns of a vehicle that obeys the form showed up to 3.3. A form that tells new runs as well is the surer one where nothing was
//! measured. (A standard error from the spread of the runs, as in Breiman et al. 1984, *Classification and Regression Trees*,
//! never lets a surface win that only a few runs need: those that reach where the power is limited, say.)

use super::anova::{Block, Design};
use super::course::{Course, surface_of};
use super::gram::Gram;
use super::kalman::{Noise, whiten};
use super::lattice::{Lattice, LatticeSurface};
use super::penalised::{Solution, System};
use super::regressors::nuisance;
use super::sampling::scramble;
use crate::map::Gear;
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Number of folds, when there are as many runs.
const FOLDS: usize = 5;
/// Standard errors from which on the surface is believed.
const BEYOND_DOUBT: f64 = 3.5;
/// Fewest runs that are worth comparing.
const FEWEST_RUNS: usize = 10;

/// Surfaces of both gears: forward, reverse.
pub(crate) type Surfaces = [LatticeSurface; 2];

/// The models.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Form {
    /// The physics form alone.
    Physics,
    /// With every block.
    Surface,
}

impl Form {
    const ALL: [Self; 2] = [Self::Physics, Self::Surface];

    /// Its name, for the report.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Physics => "physics form",
            Self::Surface => "physics form and surface",
        }
    }

    fn holds(self, block: &Block) -> bool {
        self == Self::Surface || block.physics
    }

    /// The penalties of the whole surface, infinite where this form holds nothing.
    pub(crate) fn penalties(self, blocks: &[Block], penalties: &[f64]) -> Vec<f64> {
        blocks.iter().zip(penalties).map(|(block, penalty)| if self.holds(block) { *penalty } else { f64::INFINITY }).collect()
    }
}

/// What the comparison found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Comparison {
    /// D: how much less the surface's whitened squared error is on runs left out than that of the physics form.
    pub(crate) gain: f64,
    /// ΣeΔ in its standard errors: what speaks for the surface.
    pub(crate) in_std_errs: f64,
    /// Number of runs compared.
    pub(crate) runs: usize,
    /// The form that was taken.
    pub(crate) chosen: Form,
}

/// Folds, the surfaces fitted without each, and which model won.
#[derive(Debug, Clone)]
pub(crate) struct Validation {
    /// The fold of each segment.
    pub(crate) fold: Vec<usize>,
    /// The chosen model's surfaces, fitted without each fold.
    pub(crate) without: Vec<Surfaces>,
    /// The comparison.
    pub(crate) comparison: Comparison,
}

/// The fold of each segment and the number of folds: runs are shuffled, the same way each time, and dealt in turn, so that a campaign's own
/// rhythm does not put all runs of a level into one fold. One fold when there is one run.
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

/// What the segments are judged with.
pub(crate) struct Along<'a> {
    pub(crate) courses: &'a [Course<'a>],
    /// Speeds along the segments, filtered [m/s].
    pub(crate) speeds: &'a [Vec<f64>],
    pub(crate) noise: &'a Noise,
}

/// Cross-validates. `folds` are the sums of each fold, `whole` the equations of all, `prior` the standard deviations of the nuisance columns
/// in both. `None` with fewer than two folds, or when a fold's runs are all that holds some information.
pub(crate) fn validate(
    design: &Design,
    lattice: &Lattice,
    gears: &[Gear],
    (fold, folds): (&[usize], &[[Gram; 2]]),
    (whole, solution): (&System, &Solution),
    prior: &[f64],
    along: &Along,
) -> Option<Validation> {
    if folds.len() < 2 {
        return None;
    }
    let mut fitted: [Vec<Fitted>; 2] = [Vec::new(), Vec::new()];
    for grams in folds {
        let pairs: Vec<(Gear, &Gram)> = gears.iter().map(|g| (*g, &grams[usize::from(*g == Gear::Reverse)])).collect();
        let rest = whole.without(&System::new(design, &pairs, prior.len()));
        for (form, fitted) in Form::ALL.into_iter().zip(&mut fitted) {
            let beta = rest.solve(&design.blocks, &form.penalties(&design.blocks, &solution.penalties), 0, prior)?.beta;
            let (beta, delays_s) = beta.split_at(design.coefficients());
            let surfaces = Gear::ALL.map(|g| LatticeSurface { lattice: lattice.clone(), theta: design.lattice_values(g, beta) });
            fitted.push(Fitted { surfaces, delays_s: delays_s.to_vec() });
        }
    }
    let mut runs: Vec<(usize, usize)> = along.courses.iter().map(|c| (c.segment.log, c.segment.run)).collect();
    runs.dedup();
    let comparison = choose(sums(along, fold, &fitted), runs.len());
    let [physics, surface] = fitted;
    let chosen = if comparison.chosen == Form::Physics { physics } else { surface };
    Some(Validation { fold: fold.to_vec(), without: chosen.into_iter().map(|f| f.surfaces).collect(), comparison })
}

/// What was fitted without a fold: surfaces, and changes of the nuisance columns.
struct Fitted {
    surfaces: Surfaces,
    delays_s: Vec<f64>,
}

/// Sums over the runs left out: e², e·Δ and Δ², and the number of errors.
#[derive(Debug, Clone, Copy, Default)]
struct Sums {
    squared: f64,
    with_difference: f64,
    difference_squared: f64,
    count: f64,
}

/// The sums over all runs, each against what was fitted without its fold.
fn sums(along: &Along, fold: &[usize], [physics, surface]: &[Vec<Fitted>; 2]) -> Sums {
    let of_segments: Vec<Sums> = along
        .courses
        .par_iter()
        .zip(along.speeds)
        .zip(fold)
        .map(|((course, speed), fold)| {
            let segment = course.segment;
            let predicted = |Fitted { surfaces, delays_s }: &Fitted| {
                let delays_s = [delays_s[nuisance::LAG], delays_s[nuisance::DEAD_TIME + segment.log]];
                course.predicted_with(speed, surface_of(surfaces, segment), delays_s)
            };
            let (physics, surface) = (predicted(&physics[*fold]), predicted(&surface[*fold]));
            let mut rows: Vec<f64> = Vec::with_capacity(2 * physics.len());
            for ((reading, p), s) in segment.readings.iter().zip(physics).zip(surface) {
                rows.extend([reading.speed_mps - p, s - p]);
            }
            whiten(&mut rows, 2, &segment.readings, segment.start_s, along.noise, segment.start_std_mps);
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

/// The physics form, unless the surface tells the runs better beyond doubt.
fn choose(sums: Sums, runs: usize) -> Comparison {
    let Sums { squared, with_difference, difference_squared, count } = sums;
    let gain = 2.0 * with_difference - difference_squared;
    let of_surface = (squared - gain) / count.max(1.0);
    let in_std_errs = with_difference / (of_surface * difference_squared).sqrt().max(1e-12);
    let better = in_std_errs > BEYOND_DOUBT && gain > 0.0;
    Comparison { gain, in_std_errs, runs, chosen: if better || runs < FEWEST_RUNS { Form::Surface } else { Form::Physics } }
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
    fn the_physics_form_wins_unless_the_surface_is_better_beyond_doubt() {
        let of =
            |with_difference: f64, difference_squared: f64| Sums { squared: 1000.0, with_difference, difference_squared, count: 1000.0 };
        // pure noise in Δ; a difference that helps, but may be chance; one that helps beyond doubt; one that is real, yet overdone
        assert_eq!(choose(of(0.0, 9.0), 20).chosen, Form::Physics);
        assert_eq!(choose(of(9.0, 9.0), 20).chosen, Form::Physics);
        assert_eq!(choose(of(40.0, 49.0), 20).chosen, Form::Surface);
        assert_eq!(choose(of(40.0, 100.0), 20).chosen, Form::Physics);
        assert_eq!(choose(of(0.0, 9.0), 5).chosen, Form::Surface);
    }
}
