//! A first look at dead time and drive: the profile likelihood of a small physical model over a coarse grid.
//!
//! A = c₀ + c₁·U + c₂·U⁺ + c₃·V + c₄·V² + c₅·e^(−(V/0.08)²), integrated and whitened like the full surface, solved for each pair of
//! dead time (0 … 400 ms) and drive. Each log has its own dead time; the drive is shared.

use crate::fit::drive::effective_torque::EffectiveTorque;
use crate::fit::drive::torque_input::TorqueInput;
use crate::fit::drive_form::campaign_drift::CampaignDrift;
use crate::fit::drive_form::drive_model::{DriveKind, DriveModel};
use crate::fit::drive_form::parameters::{LIMIT, PARAMETERS};
use crate::fit::drive_form::torque_limit::TorqueLimit;
use crate::fit::motion::log_data::LogData;
use crate::fit::motion::segment::Segment;
use crate::fit::noise::model::Noise;
use crate::fit::noise::whitening::whiten;
use faer::linalg::solvers::Solve;
use faer::{Col, Mat};
use rayon::prelude::*;
use std::f64::consts::TAU;

const COLUMNS: usize = 6;
/// Lags of a first-order drive tried [s].
const LAGS_S: [f64; 6] = [0.005, 0.03, 0.06, 0.1, 0.15, 0.2];
/// Times tried in which a ramp crosses the reference torque [s], and the lag after it.
const RAMPS_S: [f64; 7] = [0.06, 0.12, 0.25, 0.45, 0.8, 1.5, 3.0];
const FIRST_LAG_S: f64 = 0.02;
/// Second-order drives tried.
const FREQUENCIES_HZ: [f64; 7] = [1.5, 2.3, 3.4, 5.0, 7.0, 10.0, 15.0];
const DAMPINGS: [f64; 3] = [0.12, 0.3, 0.7];
/// Limits tried, as a share of the largest power.
const LIMITS: [f64; 8] = [0.97, 0.9, 0.8, 0.7, 0.6, 0.5, 0.4, 0.3];
/// Factors by which parameters are refined, one after another.
const REFINING: [f64; 5] = [1.3, 1.2, 1.12, 1.07, 1.04];
/// Spacing of the dead times tried, first and second [s].
const DEAD_TIME_STEPS_S: [f64; 2] = [0.02, 0.005];
/// Range of dead times tried [s]: from the command, and from a feedback, which another clock may stamp too late.
const DEAD_TIMES_S: [f64; 2] = [0.0, 0.4];
const AFTER_FEEDBACK_S: [f64; 2] = [-0.1, 0.3];
/// More readings per log than this do not make a first estimate more accurate.
const ENOUGH_READINGS: usize = 4000;
/// Beside a drive that is known, this number is enough; dead times are tried in these steps [s], and a drive is dropped beyond this ratio
/// of deviances.
const FEW_READINGS: usize = 1500;
const BESIDE_STEP_S: f64 = 0.015;
const CLEARLY_WORSE: f64 = 1.1;

/// Data of one log: its segments, their smoothed speeds, its torque.
pub(crate) struct GridLog<'a> {
    pub(crate) segments: Vec<&'a Segment>,
    pub(crate) speed_mps: Vec<&'a [f64]>,
    pub(crate) log: &'a LogData<'a>,
}

/// The best of the drives tried.
#[derive(Debug, Clone)]
pub(crate) struct GridResult {
    /// ‖y − Xc‖² of all logs.
    pub(crate) deviance: f64,
    pub(crate) drive: DriveModel,
    /// Of each log [s].
    pub(crate) dead_time_s: Vec<f64>,
}

/// The drives of a kind that are tried first; `reference_nm` is the largest torque.
pub(crate) fn drives(kind: DriveKind, reference_nm: f64) -> Vec<DriveModel> {
    let of = |times_s| DriveModel::of_kind(kind, reference_nm).with(times_s);
    match kind {
        DriveKind::FirstOrder => LAGS_S.iter().map(|l| of([*l, 0.0, 0.0])).collect(),
        DriveKind::RateLimit => RAMPS_S.iter().map(|r| of([*r, FIRST_LAG_S, 0.0])).collect(),
        DriveKind::GrowingFalling | DriveKind::UpDown => {
            let pairs = RAMPS_S.iter().flat_map(|a| RAMPS_S.iter().map(move |b| (*a, *b)));
            pairs.map(|(a, b)| of([a, b, FIRST_LAG_S])).collect()
        }
        DriveKind::SecondOrder => {
            let natural = FREQUENCIES_HZ.iter().map(|f| 1.0 / (TAU * f));
            natural.flat_map(|t| DAMPINGS.iter().map(move |d| (t, *d))).map(|(t, d)| of([t, 2.0 * d * t, 0.0])).collect()
        }
    }
}

/// A drive with limits below the largest power of the campaign [N·m·m/s].
pub(crate) fn limited(drive: DriveModel, largest: TorqueLimit) -> Vec<DriveModel> {
    LIMITS.iter().map(|share| DriveModel { limit: largest.scaled(*share), ..drive }).collect()
}

/// A drive with its dead times, beside which others are tried.
#[derive(Debug, Clone, Copy)]
pub(crate) struct KnownDrive<'a> {
    pub(crate) drive: &'a DriveModel,
    /// Of each log [s].
    pub(crate) dead_time_s: &'a [f64],
}

/// The best of `drives` and the best dead time of each log. Parameters other than a lag are refined.
///
/// Beside a drive that is known already, fewer readings and the dead times that keep the whole delay are enough, and one that is clearly worse
/// is dropped: its deviance is then infinite.
pub(crate) fn search(logs: &[GridLog], noise: &Noise, drives: &[DriveModel], beside: Option<KnownDrive>) -> GridResult {
    let measured = logs.iter().any(|l| l.log.input != TorqueInput::Command);
    let [least_s, most_s] = if measured { AFTER_FEEDBACK_S } else { DEAD_TIMES_S };
    let steps = ((most_s - least_s) / DEAD_TIME_STEPS_S[0]).round() as usize;
    let readings = if beside.is_some() { FEW_READINGS } else { ENOUGH_READINGS };
    let coarse = |drive: &DriveModel, k: usize| -> Vec<f64> {
        match beside {
            None => (0..=steps).map(|n| least_s + n as f64 * DEAD_TIME_STEPS_S[0]).collect(),
            Some(beside) => {
                let same_delay_s = beside.dead_time_s[k] + beside.drive.mean_lag_s() - drive.mean_lag_s();
                (-2i32..=2).map(|n| (same_delay_s + f64::from(n) * BESIDE_STEP_S).clamp(least_s, most_s)).collect()
            }
        }
    };
    let profile = |log: &GridLog, torque: &EffectiveTorque, dead_times: &[f64], readings: usize| -> (f64, f64) {
        dead_times
            .iter()
            .map(|d| (residual(log, torque, *d, noise, readings), *d))
            .fold((f64::INFINITY, 0.0), |best, tried| if tried.0 < best.0 { tried } else { best })
    };
    let of_drive = |drive: &DriveModel, readings: usize, dead_times: &dyn Fn(usize) -> Vec<f64>| -> GridResult {
        let best: Vec<(f64, f64)> = logs
            .iter()
            .enumerate()
            .map(|(k, log)| profile(log, &log.log.torque(drive, CampaignDrift::default()), &dead_times(k), readings))
            .collect();
        GridResult { deviance: best.iter().map(|b| b.0).sum(), drive: *drive, dead_time_s: best.iter().map(|b| b.1).collect() }
    };
    let better = |best: GridResult, tried: GridResult| if tried.deviance < best.deviance { tried } else { best };
    let found: Vec<GridResult> = drives.par_iter().map(|drive| of_drive(drive, readings, &|k| coarse(drive, k))).collect();
    let usual = DriveModel::first_order(0.05);
    let mut best = found.into_iter().reduce(better).unwrap_or_else(|| of_drive(&usual, readings, &|k| coarse(&usual, k)));
    let near = |centre: &[f64], k: usize, steps: i32| -> Vec<f64> {
        (-steps..=steps).map(|n| (centre[k] + f64::from(n) * DEAD_TIME_STEPS_S[1]).clamp(least_s, most_s)).collect()
    };
    if let Some(beside) = beside
        && best.deviance > CLEARLY_WORSE * of_drive(beside.drive, readings, &|k| vec![beside.dead_time_s[k]]).deviance
    {
        return GridResult { deviance: f64::INFINITY, ..best };
    }
    let plain = best.drive.kind == DriveKind::FirstOrder && best.drive.limit == TorqueLimit::None;
    if !plain && drives.len() > 1 {
        // a pattern search: each parameter in turn, longer and shorter by ever smaller factors
        for factor in REFINING {
            let has = best.drive.has();
            for parameter in (0..PARAMETERS).filter(|p| has[*p]) {
                let (centre, drive) = (best.dead_time_s.clone(), best.drive);
                let tried = [factor, 1.0 / factor].map(|factor: f64| {
                    let mut step = [0.0; PARAMETERS];
                    step[parameter] = if parameter == LIMIT { factor.ln() } else { drive.times_s[parameter] * (factor - 1.0) };
                    drive.moved(step)
                });
                let tried: Vec<GridResult> = tried.par_iter().map(|drive| of_drive(drive, readings, &|k| near(&centre, k, 2))).collect();
                best = tried.into_iter().fold(best, better);
            }
        }
    }
    let centre = best.dead_time_s.clone();
    of_drive(&best.drive, ENOUGH_READINGS, &|k| near(&centre, k, 4))
}

/// ‖y − Xc‖² of the best small model for one log.
fn residual(log: &GridLog, lagged: &EffectiveTorque, dead_time_s: f64, noise: &Noise, readings: usize) -> f64 {
    const WIDTH: usize = COLUMNS + 1;
    let mut gram = [[0.0f64; WIDTH]; WIDTH];
    let mut used = 0;
    let limit = lagged.limit();
    for (segment, speed_mps) in log.segments.iter().zip(&log.speed_mps) {
        if used > readings {
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
            let u = limit.delivered_nm(v, sign * cursor.at(0.5 * (from + reading.t_s) - dead_time_s).torque_nm);
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
