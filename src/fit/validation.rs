//! Cross-validation blocked by run: what each model tells about runs that it has not seen.
//!
//! Whole runs are dealt into five folds. The whitened normal equations are sums over segments, so the equations without a fold are the
//! whole ones minus the fold's; they are solved at the final noise and penalties, for the surface and its delays. Two models are compared
//! on the runs left out, by the whitened squared error S_r of each run r: the physics form alone, and the whole surface. The surface's
//! gain is D = Σ_r (S_r,physics − S_r,surface), its standard error √R times the standard deviation of the differences over the R runs.
//!
//! The physics form is taken unless the surface gains more than two standard errors: among as many parameters as a surface has, some fit
//! noise that by chance all runs share, and a form that tells new runs as well is the surer one where nothing was measured. (The rule of
//! Breiman et al. 1984, *Classification and Regression Trees*, allows the simpler model one standard error; gains beyond one, but not
//! beyond two, were noise more often than not in campaigns of a vehicle that obeys the form.)

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
/// Standard errors of gain from which on the surface is believed.
const BEYOND_DOUBT: f64 = 2.0;
/// Fewest runs whose differences have a standard deviation worth the name.
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
    /// D: how much less the surface's whitened squared error is on runs left out than that of the physics form, summed over the runs.
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
    let errors = fitted.each_ref().map(|fitted| squared_errors(along, fold, fitted));
    let comparison = choose(&errors);
    let [physics, surface] = fitted;
    let chosen = if comparison.chosen == Form::Physics { physics } else { surface };
    Some(Validation { fold: fold.to_vec(), without: chosen.into_iter().map(|f| f.surfaces).collect(), comparison })
}

/// What was fitted without a fold: surfaces, and changes of the nuisance columns.
struct Fitted {
    surfaces: Surfaces,
    delays_s: Vec<f64>,
}

type RunErrors = BTreeMap<(usize, usize), f64>;

/// Whitened squared error of each run against what was fitted without its fold.
fn squared_errors(along: &Along, fold: &[usize], without: &[Fitted]) -> RunErrors {
    let of_segments: Vec<f64> = along
        .courses
        .par_iter()
        .zip(along.speeds)
        .zip(fold)
        .map(|((course, speed), fold)| {
            let segment = course.segment;
            let Fitted { surfaces, delays_s } = &without[*fold];
            let delays_s = [delays_s[nuisance::LAG], delays_s[nuisance::DEAD_TIME + segment.log]];
            let model = course.predicted_with(speed, surface_of(surfaces, segment), delays_s);
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

/// The physics form, unless the surface tells the runs better beyond doubt; by their errors under both.
fn choose([physics, surface]: &[RunErrors; 2]) -> Comparison {
    let gains: Vec<f64> = physics.values().zip(surface.values()).map(|(p, s)| p - s).collect();
    let runs = gains.len() as f64;
    let gain: f64 = gains.iter().sum();
    let variance = gains.iter().map(|g| (g - gain / runs).powi(2)).sum::<f64>() / (runs - 1.0).max(1.0);
    let std_err = (runs * variance).sqrt();
    let as_good = gains.len() >= FEWEST_RUNS && gain <= BEYOND_DOUBT * std_err;
    Comparison { gain, std_err, runs: gains.len(), chosen: if as_good { Form::Physics } else { Form::Surface } }
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
    fn the_physics_form_wins_ties_and_loses_by_more_than_two_standard_errors() {
        let runs = |shift: f64| (0..20).map(|k| ((0, k), 100.0 + shift + (k % 3) as f64)).collect::<RunErrors>();
        let even: RunErrors = runs(0.0).into_iter().map(|(r, e)| (r, e + if r.1 % 2 == 0 { 1.0 } else { -1.0 })).collect();
        // the standard error of twenty differences of ±1 is 4.6
        let shifted = |by: f64| -> RunErrors { even.iter().map(|(r, e)| (*r, e + by / 20.0)).collect() };
        assert_eq!(choose(&[even.clone(), runs(0.0)]).chosen, Form::Physics);
        assert_eq!(choose(&[shifted(8.0), runs(0.0)]).chosen, Form::Physics);
        assert_eq!(choose(&[shifted(11.0), runs(0.0)]).chosen, Form::Surface);
    }
}
