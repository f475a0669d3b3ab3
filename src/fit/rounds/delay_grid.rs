//! A first look at dead time and lag: the profile likelihood of a small physical model over a coarse grid.
//!
//! A = c₀ + c₁·U + c₂·U⁺ + c₃·V + c₄·V² + c₅·e^(−(V/0.08)²), integrated and whitened like the full surface, solved for each pair of
//! dead time (0 … 400 ms) and lag (0 … 200 ms). Each log has its own dead time; the lag is shared.

use crate::fit::drive::effective_torque::EffectiveTorque;
use crate::fit::drive::torque_input::TorqueInput;
use crate::fit::motion::log_data::LogData;
use crate::fit::motion::segment::Segment;
use crate::fit::noise::model::Noise;
use crate::fit::noise::whitening::whiten;
use faer::linalg::solvers::Solve;
use faer::{Col, Mat};
use rayon::prelude::*;

const COLUMNS: usize = 6;
/// Lags tried [s].
const LAGS_S: [f64; 6] = [0.005, 0.03, 0.06, 0.1, 0.15, 0.2];
/// Spacing of the dead times tried, first and second [s].
const DEAD_TIME_STEPS_S: [f64; 2] = [0.02, 0.005];
/// Dead times tried, from and to [s]: from the command, and from a feedback, which another clock may stamp too late.
const DEAD_TIMES_S: [f64; 2] = [0.0, 0.4];
const AFTER_FEEDBACK_S: [f64; 2] = [-0.1, 0.3];
/// Readings per log beyond which more do not sharpen a first look.
const ENOUGH_READINGS: usize = 4000;

/// What one log brings: its segments, their smoothed speeds, its torque.
pub(crate) struct GridLog<'a> {
    pub(crate) segments: Vec<&'a Segment>,
    pub(crate) speed_mps: Vec<&'a [f64]>,
    pub(crate) log: &'a LogData<'a>,
}

/// The best lag and the best dead time of each log; either may be given.
pub(crate) fn search(logs: &[GridLog], noise: &Noise, fixed_dead_time_s: Option<f64>, fixed_lag_s: Option<f64>) -> (Vec<f64>, f64) {
    let lags: Vec<f64> = fixed_lag_s.map_or(LAGS_S.to_vec(), |l| vec![l]);
    let measured = logs.iter().any(|l| l.log.input != TorqueInput::Command);
    let [least_s, most_s] = if measured { AFTER_FEEDBACK_S } else { DEAD_TIMES_S };
    let steps = ((most_s - least_s) / DEAD_TIME_STEPS_S[0]).round() as usize;
    let coarse: Vec<f64> = match fixed_dead_time_s {
        Some(d) => vec![d],
        None => (0..=steps).map(|k| least_s + k as f64 * DEAD_TIME_STEPS_S[0]).collect(),
    };
    let profile = |log: &GridLog, lagged: &EffectiveTorque, dead_times: &[f64]| -> (f64, f64) {
        dead_times
            .iter()
            .map(|d| (residual(log, lagged, *d, noise), *d))
            .fold((f64::INFINITY, 0.0), |best, tried| if tried.0 < best.0 { tried } else { best })
    };
    let by_lag: Vec<(f64, f64, Vec<f64>)> = lags
        .par_iter()
        .map(|lag| {
            let best: Vec<(f64, f64)> = logs.iter().map(|log| profile(log, &log.log.torque(*lag), &coarse)).collect();
            (best.iter().map(|b| b.0).sum::<f64>(), *lag, best.iter().map(|b| b.1).collect())
        })
        .collect();
    let (_, lag, dead_times) = by_lag
        .into_iter()
        .fold(None, |best: Option<(f64, f64, Vec<f64>)>, tried| match best {
            Some(b) if b.0 <= tried.0 => Some(b),
            _ => Some(tried),
        })
        .unwrap_or((0.0, 0.05, vec![0.05; logs.len()]));
    if fixed_dead_time_s.is_some() {
        return (dead_times, lag);
    }
    let fine = logs
        .par_iter()
        .zip(&dead_times)
        .map(|(log, centre)| {
            let tried: Vec<f64> = (-4i32..=4).map(|k| (centre + f64::from(k) * DEAD_TIME_STEPS_S[1]).clamp(least_s, most_s)).collect();
            profile(log, &log.log.torque(lag), &tried).1
        })
        .collect();
    (fine, lag)
}

/// ‖y − Xc‖² of the best small model for one log.
fn residual(log: &GridLog, lagged: &EffectiveTorque, dead_time_s: f64, noise: &Noise) -> f64 {
    const WIDTH: usize = COLUMNS + 1;
    let mut gram = [[0.0f64; WIDTH]; WIDTH];
    let mut used = 0;
    for (segment, speed_mps) in log.segments.iter().zip(&log.speed_mps) {
        if used > ENOUGH_READINGS {
            break;
        }
        used += segment.readings.len();
        let mut data = vec![0.0; segment.readings.len() * WIDTH];
        let mut sums = [0.0; WIDTH];
        let sign = segment.gear.sign();
        let mut cursor = lagged.cursor();
        for (row, line) in data.chunks_exact_mut(WIDTH).enumerate() {
            let reading = segment.readings[row];
            let from = if row > 0 { segment.readings[row - 1].t_s } else { segment.start_s };
            let dt = reading.t_s - from;
            let v = (if row > 0 { 0.5 * (speed_mps[row] + speed_mps[row - 1]) } else { speed_mps[row] }).max(0.0);
            let u = sign * cursor.at(0.5 * (from + reading.t_s) - dead_time_s).torque_nm;
            let near = v / 0.08;
            for (sum, column) in sums.iter_mut().zip([1.0, u, u.max(0.0), v, v * v, (-near * near).exp()]) {
                *sum += dt * column;
            }
            sums[COLUMNS] = reading.speed_mps;
            line.copy_from_slice(&sums);
        }
        whiten(&mut data, WIDTH, &segment.readings, segment.start_s, noise, segment.start_std(noise));
        for line in data.chunks_exact(WIDTH) {
            for a in 0..WIDTH {
                for b in a..WIDTH {
                    gram[a][b] += line[a] * line[b];
                }
            }
        }
    }
    let at = |a: usize, b: usize| if a <= b { gram[a][b] } else { gram[b][a] };
    let matrix = Mat::from_fn(COLUMNS, COLUMNS, |a, b| at(a, b) + if a == b { 1e-9 * at(a, a) + 1e-12 } else { 0.0 });
    let right = Col::from_fn(COLUMNS, |a| at(a, COLUMNS));
    let Ok(factor) = matrix.llt(faer::Side::Lower) else { return f64::INFINITY };
    let c = factor.solve(&right);
    at(COLUMNS, COLUMNS) - (0..COLUMNS).map(|k| c[k] * right[k]).sum::<f64>()
}
