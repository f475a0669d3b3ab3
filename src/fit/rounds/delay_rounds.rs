//! The first rounds: on a sample of a long campaign, with delays, encoder and noise free.

use crate::fit::Result;
use crate::fit::motion::integration::courses;
use crate::fit::motion::regressors::Free;
use crate::fit::rounds::convergence::STILL_MPS2;
use crate::fit::rounds::outliers::CUT_BEYOND;
use crate::fit::rounds::sampling;
use crate::fit::rounds::state::State;

/// Rounds in which the encoder is calibrated by the yaw rate: at once, and when pushes and slips are out.
const ENCODER_ROUNDS: [usize; 2] = [1, 4];
/// First round with cuts.
const CUT_FROM: usize = 2;
/// Rounds after which the noise is estimated.
const NOISE_ROUNDS: std::ops::RangeInclusive<usize> = 1..=4;
/// Round from which on a surface that no longer moves ends them.
const END_FROM: usize = 5;
/// Share of the segments that show the noise: before the cuts pushes and slips are still in.
const WELL_EXPLAINED: f64 = 0.6;

/// Makes the rounds; whether they looked at a part of the data only.
///
/// # Errors
/// Equations without information.
pub(crate) fn run(state: &mut State) -> Result<bool> {
    let (chosen, sampled) = sampling::choose(&state.logs);
    for (log, chosen) in state.logs.iter_mut().zip(chosen) {
        log.chosen = chosen;
    }
    for round in 0..state.settings.iterations[0] {
        if round >= CUT_FROM {
            state.cut(CUT_BEYOND[usize::from(round > CUT_FROM)]);
        }
        let data = state.data(false);
        let torques = state.torques();
        let free = match round {
            0 => Free::Surface,
            _ if ENCODER_ROUNDS.contains(&round) => Free::DelaysAndEncoder,
            _ => Free::Delays,
        };
        // two speed sources that are merged do not show how they differ
        let segments = if free == Free::DelaysAndEncoder { &data.segments } else { &data.merged };
        let courses = courses(segments, &torques, &state.calibration);
        let speeds = state.speeds(&courses);
        let found = state.round(&courses, &speeds, free, false)?;
        if NOISE_ROUNDS.contains(&round) {
            state.update_noise(segments, &found.pass, WELL_EXPLAINED);
        }
        if found.moved_mps2 < STILL_MPS2 && round >= END_FROM {
            break;
        }
    }
    for log in &mut state.logs {
        log.chosen.fill(true);
    }
    Ok(sampled)
}
