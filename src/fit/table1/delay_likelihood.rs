//! Likelihood of other delays: the profile likelihood of dead time and lag around the finished fit.
//!
//! For each pair the residual y − ∫A(v, u(t − T_d; T_c))dt of the fitted surface A is whitened, and the surface may change in its six
//! main directions (1, U, U⁺, V, V², e^(−(V/0.08)²)): −2·ln L = ‖y − Xc‖² at the best c. The likelihood is profiled over these directions,
//! not over the whole surface. So it is a little narrower than the standard errors, which leave the whole surface free. If the torque
//! feedback is the input, it already contains the lag: only dead times from feedback to speed are tried.

use crate::fit::drive::effective_torque::EffectiveTorque;
use crate::fit::drive::torque_input::TorqueInput;
use crate::fit::motion::integration::Course;
use crate::fit::motion::log_data::LogData;
use crate::fit::motion::lookup_speeds::Speeds;
use crate::fit::motion::segment::Segment;
use crate::fit::noise::whitening::whiten;
use crate::fit::rounds::estimate::Estimate;
use crate::fit::table1::runs::round;
use crate::map::{DeadTimeLikelihood, DelayLikelihood};
use faer::linalg::solvers::Solve;
use faer::{Col, Mat};
use rayon::prelude::*;

/// Half-width of the map in standard errors of the less certain delay, and its bounds [s].
const HALF_WIDTH_STD_ERRS: f64 = 6.0;
const HALF_WIDTH_S: (f64, f64) = (0.003, 0.06);
/// Steps to each side.
const PAIRS: i32 = 7;
/// Dead times over the whole range [s].
const LONGEST_S: f64 = 0.4;
const STEP_S: f64 = 0.01;
/// More readings than this, all logs together, do not change the picture; and the fewest of one log.
const ENOUGH_READINGS: usize = 12_000;
const FEWEST_READINGS: usize = 1500;
/// Directions in which the surface may change.
const DIRECTIONS: usize = 6;
const WIDTH: usize = DIRECTIONS + 1;

/// Segments of one log, sampled evenly if there are many, and the speeds at which the surface was looked up.
struct LikelihoodLog<'a> {
    data: &'a LogData<'a>,
    dead_time_s: f64,
    segments: Vec<(&'a Segment, &'a Speeds)>,
}

type DelayGram = [[f64; WIDTH]; WIDTH];

/// The likelihood around the estimate; `None` if no data show delays.
pub(crate) fn delay_likelihood(estimate: &Estimate) -> Option<DelayLikelihood> {
    let logs: Vec<LikelihoodLog> = (0..estimate.data.logs.len()).map(|k| view(estimate, k)).collect();
    let drive = &estimate.calibration.drive;
    let found_lag_s = drive.mean_lag_s();
    let std_err_s = estimate
        .calibration_errors
        .dead_time_s
        .iter()
        .copied()
        .fold(drive.mean_lag_std_err_s(estimate.calibration_errors.drive_s), f64::max);
    let half_width_s = (HALF_WIDTH_STD_ERRS * std_err_s).clamp(HALF_WIDTH_S.0, HALF_WIDTH_S.1);
    let shifts: Vec<f64> = (-PAIRS..=PAIRS).map(|k| f64::from(k) * half_width_s / f64::from(PAIRS)).collect();
    let measured = estimate.data.logs.iter().any(|l| l.input != TorqueInput::Command);
    // a feedback is used without a lag
    let lags: Vec<f64> = if measured { vec![found_lag_s] } else { shifts.iter().map(|s| found_lag_s + s).filter(|l| *l >= 0.0).collect() };
    let pairs: Vec<(f64, f64)> = lags.iter().flat_map(|l| shifts.iter().map(move |s| (*l, *s))).collect();
    let values: Vec<f64> = pairs
        .par_iter()
        .map(|(lag_s, shift_s)| {
            let mut sum = [[0.0; WIDTH]; WIDTH];
            for log in &logs {
                let lagged = log.data.torque(&drive.later(*lag_s - found_lag_s), estimate.calibration.drift);
                add(&mut sum, &gram(estimate, log, &lagged, log.dead_time_s + shift_s));
            }
            deviance(&sum)
        })
        .collect();
    let best = values.iter().copied().fold(f64::INFINITY, f64::min);
    if !best.is_finite() {
        return None;
    }
    let rows = values.chunks(shifts.len()).map(|row| row.iter().map(|v| round(v - best, 1e2)).collect()).collect();
    let per_log = logs.iter().zip(&estimate.data.logs).map(|(log, data)| {
        let dead_time_s: Vec<f64> = (0..=(LONGEST_S / STEP_S).round() as i32).map(|k| round(f64::from(k) * STEP_S, 1e3)).collect();
        let lagged = log.data.torque(drive, estimate.calibration.drift);
        let late_s = log.data.input.late_s();
        let values: Vec<f64> = dead_time_s.par_iter().map(|d| deviance(&gram(estimate, log, &lagged, *d - late_s))).collect();
        let best = values.iter().copied().fold(f64::INFINITY, f64::min);
        DeadTimeLikelihood {
            log: data.survey.track.source.file.clone(),
            found_s: round(late_s + log.dead_time_s, 1e6),
            deviance: values.iter().map(|v| if v.is_finite() { round(v - best, 1e1) } else { 0.0 }).collect(),
            dead_time_s,
        }
    });
    Some(DelayLikelihood {
        dead_time_shift_s: shifts.iter().map(|s| round(*s, 1e6)).collect(),
        lag_s: lags.iter().map(|l| round(*l, 1e6)).collect(),
        deviance: rows,
        per_log: per_log.collect(),
    })
}

fn view<'a>(estimate: &'a Estimate, log: usize) -> LikelihoodLog<'a> {
    let data = &estimate.data.logs[log];
    let dead_time_s = estimate.calibration.dead_time_s[log];
    let (segments, speeds) = (&estimate.paths.merged, &estimate.paths.lookups);
    let own: Vec<(&Segment, &Speeds)> = segments.iter().zip(speeds).filter(|(s, _)| s.log == log).collect();
    let readings: usize = own.iter().map(|(s, _)| s.readings.len()).sum();
    let enough = (ENOUGH_READINGS / estimate.data.logs.len().max(1)).max(FEWEST_READINGS);
    let segments = own.into_iter().step_by(readings.div_ceil(enough).max(1)).collect();
    LikelihoodLog { data, dead_time_s, segments }
}

/// The whitened sums of one log: directions and residual.
fn gram(estimate: &Estimate, log: &LikelihoodLog, lagged: &EffectiveTorque, dead_time_s: f64) -> DelayGram {
    let mut gram = [[0.0; WIDTH]; WIDTH];
    for (segment, speed) in &log.segments {
        let course = Course::new(segment, lagged, dead_time_s);
        let model = course.predicted(speed, estimate.model.surface(segment.gear));
        let mut data = vec![0.0; segment.readings.len() * WIDTH];
        let mut sums = [0.0; WIDTH];
        for (row, line) in data.chunks_exact_mut(WIDTH).enumerate() {
            for (v, step) in course.along(speed, row) {
                let (u, near) = (step.torque.torque_nm, v / 0.08);
                for (sum, column) in sums.iter_mut().zip([1.0, u, u.max(0.0), v, v * v, (-near * near).exp()]) {
                    *sum += step.length_s * column;
                }
            }
            sums[DIRECTIONS] = segment.readings[row].speed_mps - model[row];
            line.copy_from_slice(&sums);
        }
        whiten(&mut data, WIDTH, &segment.readings, segment.start_s, &estimate.noise, segment.start_std(&estimate.noise));
        for line in data.chunks_exact(WIDTH) {
            for a in 0..WIDTH {
                for b in a..WIDTH {
                    gram[a][b] += line[a] * line[b];
                }
            }
        }
    }
    gram
}

fn add(sum: &mut DelayGram, other: &DelayGram) {
    sum.iter_mut().flatten().zip(other.iter().flatten()).for_each(|(a, b)| *a += b);
}

/// ‖y − Xc‖² at the best c.
fn deviance(gram: &DelayGram) -> f64 {
    let at = |a: usize, b: usize| if a <= b { gram[a][b] } else { gram[b][a] };
    let matrix = Mat::from_fn(DIRECTIONS, DIRECTIONS, |a, b| at(a, b) + if a == b { 1e-9 * at(a, a) + 1e-12 } else { 0.0 });
    let right = Col::from_fn(DIRECTIONS, |a| at(a, DIRECTIONS));
    let Ok(factor) = matrix.llt(faer::Side::Lower) else { return f64::INFINITY };
    let c = factor.solve(&right);
    at(DIRECTIONS, DIRECTIONS) - (0..DIRECTIONS).map(|k| c[k] * right[k]).sum::<f64>()
}
