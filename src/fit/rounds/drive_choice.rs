//! Which kind of drive lies between command and torque: the data choose, by the prediction of runs that were left out.
//!
//! First the coarse search (`delay_grid`) with a small physical model: kinds that explain the data no better than a first-order lag are
//! dropped. Each of the rest is fitted to a sample of the data, and predicts the runs of each fold with the surface fitted without them. The
//! score of a run is its −2·ln L under the noise of that fit, with single innovations bounded, so that a push or a slip counts alike for all
//! drives. A first-order lag stays unless another kind is better by several standard errors of the paired differences between runs.

use crate::campaign::Survey;
use crate::fit::calibration::Calibration;
use crate::fit::drive::drive_model::DriveKind;
use crate::fit::drive::effective_torque::EffectiveTorque;
use crate::fit::drive::torque_input::TorqueChoice;
use crate::fit::motion::integration::courses;
use crate::fit::motion::passes::{along_one, wide_speed};
use crate::fit::motion::regressors::Free;
use crate::fit::motion::segment::Segment;
use crate::fit::motion::segmentation::all_segments;
use crate::fit::rounds::cross_validation::{self, HeldOut};
use crate::fit::rounds::delay_rounds;
use crate::fit::rounds::initial_guess::InitialGuess;
use crate::fit::rounds::state::State;
use crate::fit::{FitSettings, Result};
use rayon::prelude::*;
use std::collections::BTreeMap;

/// A kind is fitted when it lowers the squared error of the small model by this much, in the variance of the readings, and by this share.
const WORTH_A_FIT: (f64, f64) = (30.0, 0.01);
/// Another kind than a first-order lag is chosen when it is better by this many standard errors over the runs…
const CLEARLY: f64 = 3.0;
/// …and by this much a run on average.
const PER_RUN: f64 = 1.0;
/// Bound of a squared innovation in its variance.
const MOST_SQUARED: f64 = 16.0;

/// A kind of drive with the score of every run: log and run, −2·ln L.
#[derive(Debug, Clone)]
pub(crate) struct ScoredDrive {
    pub(crate) kind: DriveKind,
    scores: BTreeMap<(usize, usize), f64>,
}

/// The choice, with what was weighed.
#[derive(Debug, Clone)]
pub(crate) struct DriveChoice {
    pub(crate) kind: DriveKind,
    /// The other kinds that were fitted: by how much each is worse, with its standard error over the runs (−2·ln L).
    pub(crate) others: Vec<(DriveKind, f64, f64)>,
}

/// Chooses the kind of drive.
///
/// # Errors
/// As of the fit itself, for a first-order lag.
pub(crate) fn choose(surveys: &[Survey], choice: &TorqueChoice, settings: &FitSettings) -> Result<DriveChoice> {
    let only = |kind| DriveChoice { kind, others: Vec::new() };
    if choice.is_feedback() || settings.lag_s.is_some() {
        return Ok(only(DriveKind::FirstOrder));
    }
    let guess = |kind| InitialGuess::new(surveys, choice, settings, kind);
    let first = guess(DriveKind::FirstOrder)?;
    let least = (first.deviance - WORTH_A_FIT.0).min(first.deviance * (1.0 - WORTH_A_FIT.1));
    let promising = |kinds: &[DriveKind]| -> Vec<InitialGuess> {
        kinds.iter().filter_map(|kind| guess(*kind).ok()).filter(|g| g.deviance < least).collect()
    };
    let mut others = promising(&[DriveKind::RateLimit, DriveKind::SecondOrder]);
    if let Some(one_slope) = others.iter().find(|g| g.calibration.drive.kind == DriveKind::RateLimit).map(|g| g.deviance) {
        let two_slopes = promising(&[DriveKind::GrowingFalling, DriveKind::UpDown]);
        others.extend(two_slopes.into_iter().filter(|g| g.deviance < one_slope - WORTH_A_FIT.0));
    }
    if others.is_empty() {
        return Ok(only(DriveKind::FirstOrder));
    }
    let scored: Vec<ScoredDrive> =
        std::iter::once(first).chain(others).filter_map(|guess| scored(State::from_guess(guess, settings)).ok()).collect();
    let Some(simple) = scored.first().filter(|s| s.kind == DriveKind::FirstOrder) else { return Ok(only(DriveKind::FirstOrder)) };
    let best = scored[1..].iter().filter(|other| is_better(other, simple)).fold(simple, |best, other| {
        let (lower, _) = difference(best, other);
        if lower > 0.0 { other } else { best }
    });
    let rest = scored.iter().filter(|s| s.kind != best.kind).map(|s| {
        let (worse, std_err) = difference(s, best);
        (s.kind, worse, std_err)
    });
    Ok(DriveChoice { kind: best.kind, others: rest.collect() })
}

/// Whether a drive is clearly better than a simpler one.
fn is_better(drive: &ScoredDrive, simple: &ScoredDrive) -> bool {
    let (lower, std_err) = difference(simple, drive);
    lower > CLEARLY * std_err && lower > PER_RUN * simple.scores.len() as f64
}

/// By how much the second predicts better than the first, over the runs that both predict, with its standard error.
fn difference(first: &ScoredDrive, second: &ScoredDrive) -> (f64, f64) {
    let each: Vec<f64> = first.scores.iter().filter_map(|(run, score)| Some(score - second.scores.get(run)?)).collect();
    let (count, sum) = (each.len() as f64, each.iter().sum::<f64>());
    let spread: f64 = each.iter().map(|d| (d - sum / count.max(1.0)).powi(2)).sum();
    (sum, (spread * count / (count - 1.0).max(1.0)).sqrt())
}

/// Fits a sample, and scores every run by the surface without its fold.
fn scored(mut state: State) -> Result<ScoredDrive> {
    delay_rounds::run(&mut state)?;
    let kind = state.calibration.drive.kind;
    let data = state.data(false);
    let torques = state.torques();
    let courses = courses(&data.merged, &torques, &state.calibration);
    let speeds = state.speeds(&courses);
    let found = state.round(&courses, &speeds, Free::Delays, true)?;
    let prior = state.nuisance_prior(Free::Delays);
    let held_out = HeldOut {
        fold: &found.fold,
        folds: &found.folds,
        whole: &found.system,
        prior: &prior,
        courses: &courses,
        speeds: &speeds,
        noise: &state.noise,
    };
    let validation = cross_validation::validate(&state.design, &state.surfaces.forward.lattice, &state.gears, &held_out);
    let fold_of: BTreeMap<(usize, usize), usize> =
        courses.iter().zip(&found.fold).map(|(c, fold)| ((c.segment.log, c.segment.run), *fold)).collect();
    let torques = state.torques();
    // the same readings for every drive: no cuts, no starts that the surface places
    for log in &mut state.logs {
        log.cuts = crate::fit::motion::log_data::Cuts::default();
    }
    let plain = Calibration { encoder_scale: state.calibration.encoder_scale, ..state.calibration.clone() };
    let segments = all_segments(&state.logs, &plain, &torques, None, &vec![Vec::new(); state.logs.len()]);
    let score = |segment: &Segment| -> Option<((usize, usize), f64)> {
        let run = (segment.log, segment.run);
        let surfaces = match &validation {
            Some(validation) => &validation.without[*fold_of.get(&run)?],
            None => &state.surfaces,
        };
        Some((run, run_score(segment, &torques, &state, surfaces)))
    };
    let parts: Vec<Option<((usize, usize), f64)>> = segments.par_iter().map(score).collect();
    let mut scores = BTreeMap::new();
    for (run, score) in parts.into_iter().flatten() {
        *scores.entry(run).or_insert(0.0) += score;
    }
    Ok(ScoredDrive { kind, scores })
}

/// −2·ln L of a segment with bounded innovations.
fn run_score(segment: &Segment, torques: &[EffectiveTorque], state: &State, surfaces: &cross_validation::Surfaces) -> f64 {
    let course = crate::fit::motion::integration::Course::new(segment, &torques[segment.log], state.calibration.dead_time_s[segment.log]);
    let surface = crate::fit::motion::integration::surface_of(surfaces, segment);
    let mut speeds = wide_speed(segment).into();
    for _ in 0..2 {
        speeds = along_one(&course, surface, &state.noise, &speeds).speeds;
    }
    let along = along_one(&course, surface, &state.noise, &speeds);
    let precisions = state.noise.precisions();
    let variance = |(reading, expected): (&crate::fit::noise::model::Reading, &f64)| expected * expected + reading.variance(precisions);
    let variances = segment.readings.iter().zip(&along.expected_std_mps).map(variance);
    // the first reading only tells the unknown speed
    variances.zip(&along.white).skip(1).map(|(variance, white)| (white * white).min(MOST_SQUARED) + variance.ln()).sum()
}
