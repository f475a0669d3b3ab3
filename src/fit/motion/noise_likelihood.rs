//! The noise by maximum likelihood, bounded: with priors alone the time constant of the disturbance diverges on real logs.

use crate::fit::motion::segment::Segment;
use crate::fit::noise::kalman::{deviance, smooth};
use crate::fit::noise::model::Noise;
use rayon::prelude::*;

/// Bounds of the parameters, in SI.
const MOST_DISTURBANCE_MPS2: f64 = 2.0;
/// Least disturbance, as a share of the accelerations that the torque commands: no surface is nearer to a vehicle. A filter that trusts the
/// surface more takes its speeds from it instead of the readings, and the rounds overshoot.
const LEAST_DISTURBANCE_SHARE: f64 = 2e-3;
const DISTURBANCE_TIME_S: (f64, f64) = (0.03, 1.0);
const READING_MPS: (f64, f64) = (2e-4, 0.2);
const LEAST_OFFSET_MPS2: f64 = 1e-4;
/// If starts are taken as less certain than they are, they follow the noise of the first readings, and so do the look-ups.
const START_SCALE: (f64, f64) = (0.1, 3.0);

/// The estimate, and the bounds that it met.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct NoiseEstimate {
    pub(crate) noise: Noise,
    pub(crate) at_bounds: Vec<&'static str>,
}

/// More readings than this do not make six parameters more accurate; segments are then sampled evenly.
const ENOUGH_READINGS: usize = 15_000;

/// Most likely noise of the residuals (speed minus the surface's prediction), starting from `start`.
///
/// Weak log-normal priors (a factor of 20) centred on the start hold parameters that the data do not determine. `offset_bound_mps2` bounds
/// σ_b by the possible spread of the runs, `range_mps2` is the range of accelerations that the torque commands.
pub(crate) fn estimate(
    segments: &[Segment],
    residuals: &[Vec<f64>],
    start: Noise,
    offset_bound_mps2: f64,
    range_mps2: f64,
) -> NoiseEstimate {
    let total: usize = segments.iter().map(|s| s.readings.len()).sum();
    let stride = total.div_ceil(ENOUGH_READINGS).max(1);
    let chosen: Vec<(&Segment, &Vec<f64>)> = segments.iter().zip(residuals).step_by(stride).collect();
    let has_yaw = segments.iter().any(|s| s.readings.iter().any(|r| r.source == 1));
    let bounds = [
        ((LEAST_DISTURBANCE_SHARE * range_mps2).clamp(1e-3, 0.1), MOST_DISTURBANCE_MPS2),
        DISTURBANCE_TIME_S,
        (LEAST_OFFSET_MPS2, offset_bound_mps2.max(2.0 * LEAST_OFFSET_MPS2)),
        READING_MPS,
        READING_MPS,
        START_SCALE,
    ];
    let pack = |n: &Noise| [n.disturbance_mps2, n.disturbance_time_s, n.offset_mps2, n.reading_mps[0], n.reading_mps[1], n.start_scale];
    let unpack = |x: &[f64; 6]| Noise {
        disturbance_mps2: x[0],
        disturbance_time_s: x[1],
        offset_mps2: x[2],
        reading_mps: [x[3], if has_yaw { x[4] } else { start.reading_mps[1] }],
        start_scale: x[5],
    };
    let centre = pack(&start);
    let cost = |x: &[f64; 6]| {
        let noise = unpack(x);
        // collected in order, then summed in order: the same bits for any number of threads
        let parts: Vec<f64> = chosen.par_iter().map(|(s, r)| deviance(r, &s.readings, s.start_s, &noise, s.start_std(&noise))).collect();
        let prior: f64 = x.iter().zip(centre).map(|(x, c)| ((x / c).ln() / 20f64.ln()).powi(2)).sum();
        parts.iter().sum::<f64>() + prior
    };
    let mut x = centre;
    for (value, (low, high)) in x.iter_mut().zip(bounds) {
        *value = value.clamp(low, high);
    }
    let mut best = cost(&x);
    // coordinate search in the logarithms: six smooth, nearly separate directions
    let mut reach = [0.7f64; 6];
    for _ in 0..12 {
        let mut moved = false;
        for k in 0..6 {
            if k == 4 && !has_yaw {
                continue;
            }
            let mut improved = false;
            for direction in [1.0, -1.0] {
                let mut tried = x;
                tried[k] = (x[k] * (direction * reach[k]).exp()).clamp(bounds[k].0, bounds[k].1);
                let value = cost(&tried);
                if value < best - 1e-3 {
                    (best, x, improved) = (value, tried, true);
                    break;
                }
            }
            reach[k] *= if improved { 1.2 } else { 0.4 };
            moved |= improved || reach[k] > 0.03;
        }
        if !moved {
            break;
        }
    }
    let names = ["disturbance", "disturbance time", "run offset", "encoder noise", "yaw-rate noise", "starts from rest"];
    let at_bounds = (0..6)
        // disturbances that outlast a run differ from its offset by nothing that the data show
        .filter(|&k| k != 1 && (k != 4 || has_yaw) && (x[k] <= bounds[k].0 * 1.001 || x[k] >= bounds[k].1 * 0.999))
        // an offset or a disturbance may vanish, and starts may be exact
        .filter(|&k| ![0, 2, 5].contains(&k) || x[k] >= bounds[k].1 * 0.999)
        .map(|k| names[k])
        .collect();
    NoiseEstimate { noise: unpack(&x), at_bounds }
}

/// The `share` of the segments that the surface explains best by mean square innovation, so that pushes and slips are not taken for noise.
pub(crate) fn well_explained(
    segments: &[Segment],
    residuals: &[Vec<f64>],
    white: &[Vec<f64>],
    share: f64,
) -> (Vec<Segment>, Vec<Vec<f64>>) {
    let score: Vec<f64> = white.iter().map(|w| w.iter().map(|e| e * e).sum::<f64>() / w.len().max(1) as f64).collect();
    if score.is_empty() {
        return (Vec::new(), Vec::new());
    }
    let mut sorted = score.clone();
    sorted.sort_unstable_by(f64::total_cmp);
    let limit = sorted[((sorted.len() as f64 * share) as usize).min(sorted.len() - 1)];
    let kept: Vec<usize> = (0..segments.len()).filter(|k| score[*k] <= limit).collect();
    (kept.iter().map(|k| segments[*k].clone()).collect(), kept.iter().map(|k| residuals[*k].clone()).collect())
}

/// Spread of the runs' offsets [m/s²]: the upper bound of σ_b.
pub(crate) fn offset_spread(segments: &[Segment], residuals: &[Vec<f64>], noise: &Noise) -> f64 {
    let loose = Noise { offset_mps2: 1.0, ..*noise };
    let offsets: Vec<f64> = segments
        .iter()
        .zip(residuals)
        .filter(|(s, _)| s.span_s() > 0.5)
        .map(|(s, r)| smooth(r, &s.readings, s.start_s, &loose, s.start_std(&loose)).offset_mps2)
        .collect();
    let centre = crate::signal::median(&offsets);
    let spread: Vec<f64> = offsets.iter().map(|o| (o - centre).abs()).collect();
    if spread.len() < 4 { 0.2 } else { 2.0 * 1.4826 * crate::signal::median(&spread) }
}
