//! Cross-validation blocked by run: what each model tells about runs that it has not seen.
//!
//! Whole runs are dealt into five folds. The whitened normal equations are sums over segments, so the equations without a fold are the
//! whole ones minus the fold's; they are solved at the final calibration, noise and penalties. Three models are compared on the runs left
//! out, by the whitened squared error S_r of each run r: the plain form alone, the physics form (with friction near standstill that fades
//! over a speed of its own), and the whole surface. The surface's gain over a simpler form is D = Σ_r (S_r,simpler − S_r,surface), its
//! standard error √R times the standard deviation of the differences over the R runs.
//!
//! The simplest form is taken over which D does not exceed one standard error (the one-standard-error rule of Breiman et al. 1984,
//! *Classification and Regression Trees*): a simpler model that tells new runs as well is the surer one where nothing was measured.

use super::anova::{Block, Design};
use super::course::{Course, surface_of};
use super::gram::Gram;
use super::kalman::{Noise, whiten};
use super::lattice::{Lattice, LatticeSurface};
use super::penalised::{Solution, System};
use super::sampling::scramble;
use crate::map::Gear;
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Number of folds, when there are as many runs.
const FOLDS: usize = 5;
/// Fewest runs whose differences have a standard deviation worth the name.
const FEWEST_RUNS: usize = 10;

/// Surfaces of both gears: forward, reverse.
pub(crate) type Surfaces = [LatticeSurface; 2];

/// The models, from the simplest on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Form {
    /// The plain form alone.
    Plain,
    /// With friction near standstill that fades over a speed of its own.
    Physics,
    /// With every block.
    Surface,
}

impl Form {
    const ALL: [Self; 3] = [Self::Plain, Self::Physics, Self::Surface];

    /// Its name, for the report.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Plain => "plain form",
            Self::Physics => "physics form",
            Self::Surface => "plain form and surface",
        }
    }

    fn holds(self, block: &Block) -> bool {
        match self {
            Self::Plain => !block.penalised || block.name.ends_with("plain form"),
            Self::Physics => Self::Plain.holds(block) || block.name == "near standstill",
            Self::Surface => true,
        }
    }

    /// The penalties of the whole surface, infinite where this form holds nothing.
    pub(crate) fn penalties(self, blocks: &[Block], penalties: &[f64]) -> Vec<f64> {
        blocks.iter().zip(penalties).map(|(block, penalty)| if self.holds(block) { *penalty } else { f64::INFINITY }).collect()
    }
}

/// What the comparison found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Comparison {
    /// D: how much less the surface's whitened squared error is on runs left out than that of the plain form, summed over the runs.
    pub(crate) gain: f64,
    /// Its standard error.
    pub(crate) std_err: f64,
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
    /// Speeds along the segments, smoothed [m/s].
    pub(crate) speeds: &'a [Vec<f64>],
    pub(crate) noise: &'a Noise,
}

/// Cross-validates. `folds` are the sums of each fold, `whole` the equations of all; both without nuisance columns. `None` with fewer than
/// two folds, or when a fold's runs are all that holds some information.
pub(crate) fn validate(
    design: &Design,
    lattice: &Lattice,
    gears: &[Gear],
    (fold, folds): (&[usize], &[[Gram; 2]]),
    (whole, solution): (&System, &Solution),
    along: &Along,
) -> Option<Validation> {
    if folds.len() < 2 {
        return None;
    }
    let mut fitted: [Vec<Surfaces>; 3] = [Vec::new(), Vec::new(), Vec::new()];
    for grams in folds {
        let pairs: Vec<(Gear, &Gram)> = gears.iter().map(|g| (*g, &grams[usize::from(*g == Gear::Reverse)])).collect();
        let rest = whole.without(&System::new(design, &pairs, 0));
        for (form, surfaces) in Form::ALL.into_iter().zip(&mut fitted) {
            let beta = rest.solve(&design.blocks, &form.penalties(&design.blocks, &solution.penalties), 0, &[])?.beta;
            surfaces.push(Gear::ALL.map(|g| LatticeSurface { lattice: lattice.clone(), theta: design.lattice_values(g, &beta) }));
        }
    }
    let errors = fitted.each_ref().map(|surfaces| squared_errors(along, fold, surfaces));
    let comparison = choose(&errors);
    let [plain, physics, surface] = fitted;
    let without = match comparison.chosen {
        Form::Plain => plain,
        Form::Physics => physics,
        Form::Surface => surface,
    };
    Some(Validation { fold: fold.to_vec(), without, comparison })
}

type RunErrors = BTreeMap<(usize, usize), f64>;

/// Whitened squared error of each run against the surface fitted without its fold.
fn squared_errors(along: &Along, fold: &[usize], without: &[Surfaces]) -> RunErrors {
    let of_segments: Vec<f64> = along
        .courses
        .par_iter()
        .zip(along.speeds)
        .zip(fold)
        .map(|((course, speed), fold)| {
            let segment = course.segment;
            let model = course.predicted(speed, surface_of(&without[*fold], segment));
            let mut error: Vec<f64> = segment.readings.iter().zip(&model).map(|(r, m)| r.speed_mps - m).collect();
            whiten(&mut error, 1, &segment.readings, segment.start_s, along.noise, segment.start_std_mps);
            error.iter().map(|e| e * e).sum()
        })
        .collect();
    let mut of_runs = BTreeMap::new();
    for (course, sum) in along.courses.iter().zip(of_segments) {
        *of_runs.entry((course.segment.log, course.segment.run)).or_insert(0.0) += sum;
    }
    of_runs
}

/// The surface's gain over a simpler form, with its standard error.
fn gain(surface: &RunErrors, simpler: &RunErrors) -> (f64, f64) {
    let gains: Vec<f64> = simpler.values().zip(surface.values()).map(|(p, s)| p - s).collect();
    let runs = gains.len() as f64;
    let gain: f64 = gains.iter().sum();
    let variance = gains.iter().map(|g| (g - gain / runs).powi(2)).sum::<f64>() / (runs - 1.0).max(1.0);
    (gain, (runs * variance).sqrt())
}

/// The simplest form that tells the runs as well as the surface, by their errors under plain, physics form and surface.
fn choose([plain, physics, surface]: &[RunErrors; 3]) -> Comparison {
    let runs = surface.len();
    let (gained, std_err) = gain(surface, plain);
    let as_good = |(gain, std_err): (f64, f64)| runs >= FEWEST_RUNS && gain <= std_err;
    let chosen = if as_good((gained, std_err)) {
        Form::Plain
    } else if as_good(gain(surface, physics)) {
        Form::Physics
    } else {
        Form::Surface
    };
    let chosen = match std::env::var("XFORM").as_deref() { Ok("plain") => Form::Plain, Ok("physics") => Form::Physics, Ok("surface") => Form::Surface, _ => chosen };
    Comparison { gain: gained, std_err, runs, chosen }
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
    fn the_simplest_form_wins_ties_and_loses_by_more_than_a_standard_error() {
        let runs = |shift: f64| (0..20).map(|k| ((0, k), 100.0 + shift + (k % 3) as f64)).collect::<RunErrors>();
        let even: RunErrors = runs(0.0).into_iter().map(|(r, e)| (r, e + if r.1 % 2 == 0 { 1.0 } else { -1.0 })).collect();
        let worse: RunErrors = even.iter().map(|(r, e)| (*r, e + 1.0)).collect();
        assert_eq!(choose(&[even.clone(), even.clone(), runs(0.0)]).chosen, Form::Plain);
        assert_eq!(choose(&[worse.clone(), even, runs(0.0)]).chosen, Form::Physics);
        assert_eq!(choose(&[worse.clone(), worse, runs(0.0)]).chosen, Form::Surface);
    }
}
