//! Which kind of drive lies between command and torque: the data choose, by the prediction of runs that were left out.
//!
//! First the coarse search (`delay_grid`) with a small physical model: kinds that explain the data no better than a first-order lag, and
//! a limit of power that explains no more, are dropped. Each of the rest is fitted to a sample of the data, and predicts the runs of each
//! fold with the surface fitted without them. The score of a run is its −2·ln L under the noise of that fit, with single innovations
//! bounded, so that a push or a slip counts equally for all drives. A first-order lag stays unless another kind is better by several
//! standard errors of the paired differences between runs. A torque limit is not searched for: a flat surface shows it (`flat_top`).

use crate::campaign::Survey;
use crate::fit::calibration::Calibration;
use crate::fit::drive::effective_torque::EffectiveTorque;
use crate::fit::drive::torque_input::TorqueChoice;
use crate::fit::drive_form::drive_model::{DriveKind, DriveModel};
use crate::fit::drive_form::torque_limit::TorqueLimit;
use crate::fit::motion::coarse_readings::replace_coarse;
use crate::fit::motion::integration::{Course, courses, surface_of};
use crate::fit::motion::passes::{along_one, wide_speed};
use crate::fit::motion::regressors::Free;
use crate::fit::motion::segment::Segment;
use crate::fit::motion::segmentation::all_segments;
use crate::fit::motion::so_far::SoFar;
use crate::fit::noise::model::Reading;
use crate::fit::rounds::cross_validation::{self, HeldOut};
use crate::fit::rounds::delay_grid::{self, KnownDrive};
use crate::fit::rounds::delay_rounds;
use crate::fit::rounds::initial_guess::{Examined, InitialGuess, largest_nm, largest_power};
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
/// …or when so many runs gain this much each (−2·ln L), and all gains together are so many times the losses.
const FEWEST_GAINS: usize = 2;
const CLEAR_GAIN: f64 = 9.0;
const GAIN_OVER_LOSS: f64 = 10.0;
/// A limit is chosen where it predicts no worse and leaves so little of the surface's gain over the physics form, of a gain of at least this
/// much (whitened squared error).
const SUPERFLUOUS: f64 = 0.1;
const DEVIATES: f64 = 100.0;
/// A torque limit that a surface shows is chosen where the runs left out do not contradict it by this many standard errors: a smooth surface
/// follows the flat part beyond the limit as well, but not the corner between the torques that were driven.
const NOT_WORSE: f64 = 2.0;
/// Bound of a squared innovation in its variance.
const MOST_SQUARED: f64 = 16.0;

/// A run: its log and its number there.
type Run = (usize, usize);

/// The scores of a run's readings, −2·ln L: by source and sample.
type ReadingScores = BTreeMap<(u8, u32), f64>;

/// A drive with the scores of every run.
#[derive(Debug, Clone)]
struct ScoredDrive {
    drive: DriveModel,
    scores: BTreeMap<Run, ReadingScores>,
    /// By how much the surface's deviations from the physics form reduce the whitened squared error of runs left out.
    surface_gain: f64,
}

/// The choice, and the alternatives.
#[derive(Debug, Clone)]
pub(crate) struct DriveChoice {
    /// As found on a sample of the data.
    pub(crate) drive: DriveModel,
    /// The other drives that were fitted: by how much each is worse, with its standard error over the runs (−2·ln L).
    pub(crate) others: Vec<(DriveModel, f64, f64)>,
    /// A drive that the data prefer by far to the one that was given, and by how much (−2·ln L).
    pub(crate) better_than_given: Option<(DriveModel, f64)>,
}

/// Chooses the drive: its kind, and whether it has a limit.
pub(crate) fn choose(examined: &Examined, surveys: &[Survey], choice: &TorqueChoice, settings: &FitSettings) -> DriveChoice {
    let of_kind = |kind| delay_grid::drives(kind, largest_nm(surveys));
    let kinds = settings.drive.map_or_else(|| DriveKind::ALL.to_vec(), DriveKind::of);
    let first = examined.guess(choice, settings, &of_kind(kinds[0]), None);
    let better_than_given = better_than_given(&first, examined, choice, settings, &of_kind(DriveKind::FirstOrder));
    let only = |drive| DriveChoice { drive, others: Vec::new(), better_than_given };
    if choice.is_feedback() {
        return only(first.calibration.drive);
    }
    let kinds = if settings.lag_s.is_some() { kinds[..1].to_vec() } else { kinds };
    let better_than = |deviance: f64| (deviance - WORTH_A_FIT.0).min(deviance * (1.0 - WORTH_A_FIT.1));
    let (known_drive, known_s) = (first.calibration.drive, first.calibration.dead_time_s.clone());
    let beside = KnownDrive { drive: &known_drive, dead_time_s: &known_s };
    let promising = |drives: &[DriveModel], deviance: f64| {
        Some(examined.guess(choice, settings, drives, Some(beside))).filter(|g| g.deviance < better_than(deviance))
    };
    let mut best = first.deviance;
    let mut tried = vec![first];
    for kind in &kinds[1..] {
        // two slopes where one is better than a lag
        let two_slopes = matches!(kind, DriveKind::GrowingFalling | DriveKind::UpDown);
        if two_slopes && !tried.iter().any(|g| g.calibration.drive.kind == DriveKind::RateLimit) {
            continue;
        }
        tried.extend(promising(&of_kind(*kind), if two_slopes { best } else { tried[0].deviance }));
        best = tried.iter().map(|g| g.deviance).fold(best, f64::min);
    }
    let unlimited =
        tried.iter().min_by(|a, b| a.deviance.total_cmp(&b.deviance)).map_or(tried[0].calibration.drive, |g| g.calibration.drive);
    let strongest = |drives: &[DriveModel]| examined.guess_of_most_power(choice, settings, drives, beside);
    let limited = strongest(&delay_grid::limited(unlimited, TorqueLimit::Power(largest_power(surveys))));
    if limited.deviance < strongest(&[unlimited]).deviance - WORTH_A_FIT.0 {
        tried.push(limited);
    }
    if tried.len() == 1 {
        return only(tried[0].calibration.drive);
    }
    let scored: Vec<ScoredDrive> = tried.into_iter().filter_map(|guess| scored(guess, settings).ok()).collect();
    let Some(simple) = scored.first() else { return only(unlimited) };
    let best = scored[1..].iter().fold(simple, |best, other| if is_better(other, best) { other } else { best });
    let rest = scored.iter().filter(|s| s.drive != best.drive).map(|s| {
        let (worse, std_err) = difference(s, best);
        (s.drive, worse, std_err)
    });
    DriveChoice { drive: best.drive, others: rest.collect(), better_than_given }
}

/// The first-order lag that the data prefer by far to the given one.
fn better_than_given(
    given: &InitialGuess,
    examined: &Examined,
    choice: &TorqueChoice,
    settings: &FitSettings,
    lags: &[DriveModel],
) -> Option<(DriveModel, f64)> {
    if settings.lag_s.is_none() || choice.is_feedback() {
        return None;
    }
    let free = examined.guess(choice, &FitSettings { lag_s: None, ..settings.clone() }, lags, None);
    let gain = given.deviance - free.deviance;
    (gain > WORTH_A_FIT.0 && gain > WORTH_A_FIT.1 * given.deviance).then_some((free.calibration.drive, gain))
}

/// The choice with a torque limit that the surface of the drive chosen shows, unless the runs left out contradict it.
pub(crate) fn with_torque_limit(
    limit_nm: f64,
    chosen: DriveChoice,
    examined: &Examined,
    choice: &TorqueChoice,
    settings: &FitSettings,
) -> DriveChoice {
    let scored_with = |drive: DriveModel| scored(examined.guess(choice, settings, &[drive], None), settings).ok();
    let limited = DriveModel { limit: TorqueLimit::Torque(limit_nm), ..chosen.drive };
    let (Some(limited), Some(unlimited)) = (scored_with(limited), scored_with(chosen.drive)) else { return chosen };
    let (worse, std_err) = difference(&unlimited, &limited);
    if worse < -NOT_WORSE * std_err {
        return chosen;
    }
    let others = std::iter::once((unlimited.drive, worse, std_err)).chain(chosen.others).collect();
    DriveChoice { drive: limited.drive, others, ..chosen }
}

/// The input of a fit: the torque feedback stays where the choice made it the input, unless a drive behind the command predicts runs left out
/// clearly better. A feedback on the motor's side of an elastic drive agrees with the command and is not the torque at the wheel.
pub(crate) fn with_better_input(surveys: &[Survey], choice: TorqueChoice, settings: &FitSettings) -> TorqueChoice {
    if !choice.is_feedback() || choice.is_for_undelivered() || settings.drive.is_some() {
        return choice;
    }
    let command = choice.with_command();
    let scored_with = |choice: &TorqueChoice| -> Option<ScoredDrive> {
        let examined = Examined::new(surveys, choice, settings).ok()?;
        let drive = choose(&examined, surveys, choice, settings).drive;
        scored(examined.guess(choice, settings, &[drive], None), settings).ok()
    };
    match (scored_with(&choice), scored_with(&command)) {
        (Some(feedback), Some(drive)) if is_better(&drive, &feedback) => command,
        _ => choice,
    }
}

/// Whether a drive is clearly better than one that was tried before: by its mean over the runs, or because several runs gain much and the
/// others lose hardly anything. A limit acts in a few runs only, so that the spread between the runs hides it.
fn is_better(drive: &ScoredDrive, before: &ScoredDrive) -> bool {
    let (lower, std_err) = difference(before, drive);
    let of_runs = differences(before, drive);
    let each = || of_runs.iter();
    let (gains, losses) = (each().filter(|d| **d > 0.0).sum::<f64>(), -each().filter(|d| **d < 0.0).sum::<f64>());
    let in_some = each().filter(|d| **d > CLEAR_GAIN).count() >= FEWEST_GAINS && gains > GAIN_OVER_LOSS * losses;
    let clearly = (lower > CLEARLY * std_err || in_some) && lower > PER_RUN * before.scores.len() as f64;
    clearly || lower > 0.0 && explains_the_surface(drive, before)
}

/// Whether a limit alone makes the surface's deviations from the physics form superfluous. Then the limited drive is the simpler model: one
/// number for what is otherwise a bend of the surface, which cannot follow a corner between the torques that were driven.
fn explains_the_surface(limited: &ScoredDrive, before: &ScoredDrive) -> bool {
    let by_limit_alone = limited.drive.kind == before.drive.kind && before.drive.limit == TorqueLimit::None;
    let deviates = before.surface_gain > DEVIATES;
    by_limit_alone && limited.drive.limit != TorqueLimit::None && deviates && limited.surface_gain < SUPERFLUOUS * before.surface_gain
}

/// By how much the second predicts each run better than the first, over the readings that both predict. A later dead time lets a run begin a
/// reading later, and a reading more would count for more than any drive explains.
fn differences(first: &ScoredDrive, second: &ScoredDrive) -> Vec<f64> {
    let of_run = |(run, scores): (&Run, &ReadingScores)| {
        let others = second.scores.get(run)?;
        Some(scores.iter().filter_map(|(reading, score)| Some(score - others.get(reading)?)).sum())
    };
    first.scores.iter().filter_map(of_run).collect()
}

/// By how much the second predicts better than the first, over the runs that both predict, with its standard error.
fn difference(first: &ScoredDrive, second: &ScoredDrive) -> (f64, f64) {
    let each = differences(first, second);
    let (count, sum) = (each.len() as f64, each.iter().sum::<f64>());
    let spread: f64 = each.iter().map(|d| (d - sum / count.max(1.0)).powi(2)).sum();
    (sum, (spread * count / (count - 1.0).max(1.0)).sqrt())
}

/// Fits a sample, and scores every run by the surface without its fold.
fn scored(guess: InitialGuess, settings: &FitSettings) -> Result<ScoredDrive> {
    let mut state = State::from_guess(guess, settings);
    delay_rounds::run(&mut state)?;
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
    let mut segments = all_segments(&state.logs, &plain, &torques, None, &vec![Vec::new(); state.logs.len()]);
    let so_far = SoFar { surfaces: &state.surfaces, noise: &state.noise };
    replace_coarse(&mut segments, &state.logs, &plain, &torques, so_far);
    let score = |segment: &Segment| -> Option<(Run, ReadingScores)> {
        let run = (segment.log, segment.run);
        let surfaces = match &validation {
            Some(validation) => &validation.without[*fold_of.get(&run)?],
            None => &state.surfaces,
        };
        Some((run, reading_scores(segment, &torques, &state, surfaces)))
    };
    let parts: Vec<Option<(Run, ReadingScores)>> = segments.par_iter().map(score).collect();
    let mut scores: BTreeMap<Run, ReadingScores> = BTreeMap::new();
    for (run, of_segment) in parts.into_iter().flatten() {
        scores.entry(run).or_default().extend(of_segment);
    }
    let surface_gain = validation.as_ref().map_or(0.0, |v| v.comparison.gain);
    Ok(ScoredDrive { drive: state.calibration.drive, scores, surface_gain })
}

/// −2·ln L of a segment's readings with bounded innovations.
fn reading_scores(segment: &Segment, torques: &[EffectiveTorque], state: &State, surfaces: &cross_validation::Surfaces) -> ReadingScores {
    let course = Course::new(segment, &torques[segment.log], state.calibration.dead_time_s[segment.log]);
    let surface = surface_of(surfaces, segment);
    let mut speeds = wide_speed(segment).into();
    for _ in 0..2 {
        speeds = along_one(&course, surface, &state.noise, &speeds).speeds;
    }
    let along = along_one(&course, surface, &state.noise, &speeds);
    let precisions = state.noise.precisions();
    let each = segment.readings.iter().zip(&along.expected_std_mps).zip(&along.white);
    let scored = |((reading, expected_mps), white): ((&Reading, &f64), &f64)| {
        let variance = expected_mps * expected_mps + reading.variance(precisions);
        ((reading.source, reading.sample), (white * white).min(MOST_SQUARED) + variance.ln())
    };
    // the first reading only gives the unknown speed
    each.skip(1).map(scored).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scored(of_run: impl Fn(usize) -> f64) -> ScoredDrive {
        ScoredDrive {
            drive: DriveModel::first_order(0.05),
            scores: (0..30).map(|k| ((0, k), ReadingScores::from([((0, 7), of_run(k))]))).collect(),
            surface_gain: 2000.0,
        }
    }

    fn noise(k: usize) -> f64 {
        0.5 * ((k * 7919 % 13) as f64 / 6.0 - 1.0)
    }

    #[test]
    fn a_drive_is_better_by_all_runs_or_by_a_few_that_need_it() {
        let before = scored(|_| 100.0);
        let is = |gain: &dyn Fn(usize) -> f64| is_better(&scored(|k| 100.0 - gain(k)), &before);
        assert!(!is(&|_| 0.0) && !is(&noise));
        assert!(is(&|k| 3.0 + noise(k)), "every run gains a little");
        assert!(is(&|k| if k < 2 { 40.0 } else { 0.0 }), "two runs reach a limit");
        assert!(!is(&|k| if k < 1 { 80.0 } else { 0.0 }), "one run may be a push");
        assert!(!is(&|k| if k < 2 { 40.0 } else { -0.5 }), "the others pay for it");
        let mut with_one_reading_more = scored(|_| 100.0);
        with_one_reading_more.scores.values_mut().for_each(|run| {
            run.insert((0, 6), -9.0);
        });
        assert!(!is_better(&with_one_reading_more, &before), "a reading more is no better prediction");
    }

    #[test]
    fn a_limit_that_explains_what_the_surface_did_is_chosen_where_it_predicts_no_worse() {
        let before = scored(|_| 100.0);
        let limited = |gain: f64, surface_gain: f64| {
            let drive = DriveModel { limit: TorqueLimit::Power(60.0), ..before.drive };
            ScoredDrive { drive, surface_gain, ..scored(|k| 100.0 + 20.0 * noise(k) - gain) }
        };
        assert!(is_better(&limited(1.0, 10.0), &before));
        assert!(!is_better(&limited(-1.0, 10.0), &before), "it predicts worse");
        assert!(!is_better(&limited(1.0, 1000.0), &before), "the surface is needed all the same");
    }
}
