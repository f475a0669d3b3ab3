//! The rounds of the estimator: speeds, noise, cuts, surface and delays, each from the others, until they converge.
//!
//! 1. A first guess of calibration, noise, dead time and lag (`initial_guess`, `delay_grid`).
//! 2. Rounds on a sample of a long campaign, with delays, encoder and noise free (`delay_rounds`, `sampling`).
//! 3. Rounds on everything, without the moments after steps (`surface_rounds`), until surface and delays converge (`convergence`).
//!
//! Each round (`round`) filters the speeds along the segments with the surface of the last one, adds up the whitened sums, solves them with
//! penalties chosen by the data, and moves on to the new surface and calibration (`calibration_step`). Between rounds, readings that do not
//! belong are cut (`outliers`). At the end, runs left out determine how much of the surface is used (`cross_validation`).

pub(crate) mod calibration_step;
pub(crate) mod convergence;
pub(crate) mod cross_validation;
mod delay_grid;
mod delay_rounds;
pub(crate) mod drive_choice;
pub(crate) mod estimate;
mod flat_top;
pub(crate) mod initial_guess;
pub(crate) mod outliers;
mod round;
mod sampling;
mod state;
mod surface_rounds;

use crate::campaign::Survey;
use crate::fit::drive::torque_input::TorqueChoice;
use crate::fit::drive_form::torque_limit::TorqueLimit;
use crate::fit::rounds::drive_choice::DriveChoice;
use crate::fit::rounds::estimate::Estimate;
use crate::fit::rounds::initial_guess::Examined;
use crate::fit::rounds::state::State;
use crate::fit::{FitSettings, KnownCalibration, Result};

/// Runs the estimator with the torque input that was chosen.
///
/// # Errors
/// A slow speed signal without a yaw rate, too little motion, one torque only, equations without information.
pub(crate) fn estimate<'a>(surveys: &'a [Survey], choice: &TorqueChoice, settings: &FitSettings) -> Result<Estimate<'a>> {
    let examined = Examined::new(surveys, choice, settings)?;
    let mut chosen = match &settings.known {
        Some(KnownCalibration { drive: Some(drive), .. }) => DriveChoice { drive: *drive, others: Vec::new(), better_than_given: None },
        _ => drive_choice::choose(&examined, surveys, choice, settings),
    };
    let mut state = State::from_guess(examined.guess(choice, settings, &[chosen.drive], None), settings);
    let mut sampled = delay_rounds::run(&mut state)?;
    let free = settings.known.as_ref().is_none_or(|k| k.drive.is_none()) && !choice.is_feedback();
    if free
        && chosen.drive.limit == TorqueLimit::None
        && let Some(limit_nm) = flat_top::limit_nm(&state)
    {
        chosen = drive_choice::with_torque_limit(limit_nm, chosen, &examined, choice, settings);
        if chosen.drive.limit != TorqueLimit::None {
            state = State::from_guess(examined.guess(choice, settings, &[chosen.drive], None), settings);
            sampled = delay_rounds::run(&mut state)?;
        }
    }
    let estimate = surface_rounds::run(state, sampled)?;
    Ok(Estimate { other_drives: chosen.others, better_than_given: chosen.better_than_given, ..estimate })
}
