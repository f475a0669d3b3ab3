//! The last rounds: on everything, without the moments after steps, until surface and delays converge. Then the cross-validation, which
//! determines how much of the surface is used beyond the physics form.

use crate::fit::motion::integration::{Course, courses, courses_again};
use crate::fit::motion::log_data::Cuts;
use crate::fit::motion::lookup_speeds::Speeds;
use crate::fit::motion::merging::spread;
use crate::fit::motion::passes::smoothed_speeds;
use crate::fit::motion::regressors::Free;
use crate::fit::rounds::convergence::{Convergence, Moved};
use crate::fit::rounds::cross_validation;
use crate::fit::rounds::cross_validation::{HeldOut, Validation};
use crate::fit::rounds::estimate::{Estimate, EstimateData, Paths, RoundCount, SurfaceModel};
use crate::fit::rounds::outliers::CUT_BEYOND;
use crate::fit::rounds::round::RoundResult;
use crate::fit::rounds::state::{RoundData, State};
use crate::fit::solve::penalised_least_squares::System;
use crate::fit::solve::plausible_penalties::plausible_covariance;
use crate::fit::solve::shrinkage::Stacked;
use crate::fit::{Error, Result};
use faer::Mat;

/// From this round on, speeds move by half of the step asked for: most campaigns converge before.
const HALF_WAY_FROM: usize = 3;
/// Share of the segments from which the noise is estimated: pushes and slips are cut by now.
const WELL_EXPLAINED: f64 = 0.98;

/// Results of the last round.
struct FinalRound {
    stacked: Stacked,
    plausible: Mat<f64>,
    system: System,
    lookups: Vec<Speeds>,
    validation: Option<Validation>,
}

/// Makes the rounds. `sampled`: whether the rounds before used only a part of the data.
///
/// # Errors
/// Equations without information.
pub(crate) fn run(mut state: State, sampled: bool) -> Result<Estimate> {
    state.penalties.clear();
    state.last_steps.clear();
    state.cut(CUT_BEYOND[1]);
    let mut data = state.data(true);
    let mut speeds = None;
    let mut convergence = Convergence::default();
    let most = state.settings.iterations[1].max(2);
    let mut free = Free::DelaysAndDrift;
    // one log is the campaign
    let several = state.logs.len() > 1;
    state.drifts = [true, several, true, several];
    for round in 1.. {
        let torques = state.torques();
        let courses = courses(&data.merged, &torques, &state.calibration);
        let along = speeds.take().unwrap_or_else(|| state.speeds(&courses));
        let mut found = state.round(&courses, &along, free, true)?;
        let converged = convergence.reached(Moved { surface_mps2: found.moved_mps2, delays: found.stepped });
        if round == 1 {
            state.update_noise(&data.merged, &found.pass, WELL_EXPLAINED);
            free = state.keep_clear_drifts(&found.solution);
            // the better surface judges the cuts again, which also moves the starts from rest a little; afterwards the cuts do not change
            if !sampled || state.logs.iter().any(|l| l.cuts != Cuts::default()) {
                drop(courses);
                state.cut(CUT_BEYOND[1]);
                data = state.data(true);
                convergence = Convergence::default();
                state.last_steps.clear();
                continue;
            }
        } else if converged || round >= most {
            let last = final_round(&mut state, &courses, &along, free, found)?;
            drop(courses);
            return Ok(estimate(state, data, last, free, converged));
        }
        // half steps converge where speeds and surface follow each other
        let mut next = std::mem::take(&mut found.pass.speeds);
        if round >= HALF_WAY_FROM {
            next.iter_mut().zip(&along).for_each(|(next, last)| next.go_half_way_from(last));
        }
        speeds = Some(next);
    }
    Err(Error::Singular)
}

/// Cross-validates, and uses as much of the surface as the runs left out support.
fn final_round(state: &mut State, courses: &[Course], speeds: &[Speeds], free: Free, found: RoundResult) -> Result<FinalRound> {
    let RoundResult { solution, system, folds, fold, mut pass, .. } = found;
    let prior = state.nuisance_prior(free);
    let held_out = HeldOut { fold: &fold, folds: &folds, whole: &system, prior: &prior, courses, speeds, noise: &state.noise };
    let validation = cross_validation::validate(&state.design, &state.surfaces.forward.lattice, &state.gears, &held_out);
    let share = validation.as_ref().map_or(0.0, |v| v.comparison.surface_share);
    let stacked = Stacked::new(&system, solution, &state.design.blocks, share, &prior).ok_or(Error::Singular)?;
    if share < 1.0 {
        state.surfaces = state.surfaces_of(&stacked.solution);
        state.calibrate(&stacked.solution, free);
        let torques = state.torques();
        let courses = courses_again(courses, &torques, &state.calibration);
        pass = state.pass(&courses).along(Some(speeds));
    }
    let plausible = plausible_covariance(&system, &state.design.blocks, &stacked.solution.penalties, &prior).ok_or(Error::Singular)?;
    Ok(FinalRound { stacked, system, plausible, lookups: pass.speeds, validation })
}

/// The estimate, with every single reading compared with it.
fn estimate(state: State, data: RoundData, last: FinalRound, free: Free, converged: bool) -> Estimate {
    let RoundData { transients, segments, merged } = data;
    let FinalRound { stacked, system, plausible, lookups, validation } = last;
    let speeds: Vec<Speeds> =
        segments.iter().zip(merged.iter().zip(&lookups)).map(|(s, (m, v))| spread(&v.after, &m.readings, &s.readings).into()).collect();
    let torques = state.torques();
    let pass = state.pass(&courses(&segments, &torques, &state.calibration)).along(Some(&speeds));
    let drift = state.shrunk_drift.with_clear(state.drifts, &state.calibration.drift, &state.calibration_errors.drift);
    Estimate {
        paths: Paths {
            speeds_mps: smoothed_speeds(&segments, &pass.residuals, &state.noise),
            offsets_mps2: pass.offsets,
            white: pass.white,
            merged,
            lookups,
        },
        data: EstimateData { logs: state.logs, end: state.end, gears: state.gears, has_yaw: state.has_yaw, segments, transients },
        model: SurfaceModel { design: state.design, surfaces: state.surfaces, stacked, system, plausible },
        calibration: state.calibration,
        drift,
        free,
        other_drives: Vec::new(),
        better_than_given: None,
        calibration_errors: state.calibration_errors,
        noise: state.noise,
        noise_bounds: state.noise_bounds,
        rounds: RoundCount { count: state.rounds, converged },
        validation,
    }
}
