//! The usual ways: differentiate the speed, then bin it or fit a surface. All are given the true delays.

use super::drive::{Drive, Sample};
use super::grid::Grid;
use std::collections::BTreeMap;

/// A point of a differenced log: speed [m/s], effective torque [N·m], acceleration [m/s²], and its run.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Point {
    pub(crate) speed_mps: f64,
    pub(crate) torque_nm: f64,
    pub(crate) accel_mps2: f64,
    pub(crate) run: usize,
}

/// Speeds below this count as standing [m/s].
const STANDING_MPS: f64 = 0.015;
/// Bins settle for so long after a step [s].
const SETTLE_S: f64 = 0.3;

/// Bins and a settle mask: a moving mean of five, a central difference, 0.3 s left out after each step, the mean of each bin; empty bins
/// take the line between their neighbours along torque, or the nearest speed's.
pub(crate) fn bins(drive: &Drive) -> Grid {
    let samples = drive.fused();
    let mean: Vec<f64> = (0..samples.len())
        .map(|k| {
            let around = &samples[k.saturating_sub(2)..(k + 3).min(samples.len())];
            around.iter().map(|s| s.fused_mps).sum::<f64>() / around.len() as f64
        })
        .collect();
    let mut sums: BTreeMap<(usize, i64), (f64, f64)> = BTreeMap::new();
    for k in 1..samples.len() - 1 {
        let s = &samples[k];
        if mean[k] > STANDING_MPS && s.since_step_s > SETTLE_S {
            let accel = (mean[k + 1] - mean[k - 1]) / (samples[k + 1].t_s - samples[k - 1].t_s);
            let cell = sums.entry(((mean[k] / 0.05).round() as usize, (s.torque_nm / 1.5).round() as i64)).or_insert((0.0, 0.0));
            *cell = (cell.0 + accel, cell.1 + 1.0);
        }
    }
    let speeds: Vec<f64> = (0..=23).map(|i| f64::from(i) * 0.05).collect();
    let levels: Vec<i64> = {
        let mut all: Vec<i64> = sums.keys().map(|k| k.1).collect();
        all.sort_unstable();
        all.dedup();
        all
    };
    let torques: Vec<f64> = levels.iter().map(|j| *j as f64 * 1.5).collect();
    let rows: Vec<Option<Vec<f64>>> = (0..speeds.len())
        .map(|i| {
            let known: Vec<(f64, f64)> =
                levels.iter().zip(&torques).filter_map(|(j, u)| sums.get(&(i, *j)).map(|(sum, n)| (*u, sum / n))).collect();
            (known.len() > 1).then(|| torques.iter().map(|u| along(&known, *u)).collect())
        })
        .collect();
    let filled = (0..speeds.len())
        .map(|i| {
            let nearest = (0..rows.len()).filter(|k| rows[*k].is_some()).min_by_key(|k| k.abs_diff(i)).unwrap_or(i);
            rows[nearest].clone().unwrap_or_else(|| vec![0.0; torques.len()])
        })
        .collect();
    Grid::new(speeds, torques, filled)
}

/// The line between known neighbours; beyond the ends the outer value, continued by the row's mean slope.
fn along(known: &[(f64, f64)], u: f64) -> f64 {
    let ((first, low), (last, high)) = (known[0], known[known.len() - 1]);
    if u <= first || u >= last {
        let (x, y) = if u <= first { (first, low) } else { (last, high) };
        return y + (u - x) * (high - low) / (last - first);
    }
    let upper = known.partition_point(|(x, _)| *x < u).clamp(1, known.len() - 1);
    let ((x0, y0), (x1, y1)) = (known[upper - 1], known[upper]);
    y0 + (u - x0) / (x1 - x0) * (y1 - y0)
}

/// Savitzky and Golay's filter, 11 samples, second order, over the whole log: across steps and stops.
pub(crate) fn savitzky_golay(drive: &Drive) -> Vec<Point> {
    let samples = drive.fused();
    (5..samples.len() - 5).filter_map(|k| point(&samples[k - 5..=k + 5], &samples[k])).collect()
}

/// A parabola through ±0.15 s around each sample, within its run and between steps of the effective torque, without the first 0.12 s after a
/// step: the lag still bends them, and no parabola follows.
pub(crate) fn local_quadratic(drive: &Drive) -> Vec<Point> {
    let samples = drive.fused();
    let mut pieces: Vec<std::ops::Range<usize>> = Vec::new();
    for k in (0..samples.len()).filter(|k| samples[*k].since_step_s > 0.12) {
        let joins = k > 0 && samples[k].run == samples[k - 1].run && samples[k - 1].since_step_s > 0.12;
        match pieces.last_mut() {
            Some(piece) if joins => piece.end = k + 1,
            _ => pieces.push(k..k + 1),
        }
    }
    let mut points = Vec::new();
    for piece in pieces.into_iter().filter(|p| samples[p.start].run.is_some() && p.len() >= 6) {
        for k in piece.clone() {
            let window = k.saturating_sub(7).max(piece.start)..(k + 8).min(piece.end);
            points.extend(point(&samples[window], &samples[k]));
        }
    }
    points
}

/// Value and slope at `at` of the least-squares parabola through `window`, while moving.
fn point(window: &[Sample], at: &Sample) -> Option<Point> {
    let mut normal = [[0.0; 4]; 3];
    for s in window {
        let x = (s.t_s - at.t_s) / 0.1;
        let row = [1.0, x, x * x];
        for a in 0..3 {
            for b in 0..3 {
                normal[a][b] += row[a] * row[b];
            }
            normal[a][3] += row[a] * s.fused_mps;
        }
    }
    for a in 0..3 {
        if normal[a][a].abs() < 1e-9 {
            return None;
        }
        for b in 0..3 {
            if a != b {
                let factor = normal[b][a] / normal[a][a];
                for c in 0..4 {
                    normal[b][c] -= factor * normal[a][c];
                }
            }
        }
    }
    let speed_mps = normal[0][3] / normal[0][0];
    let accel_mps2 = normal[1][3] / normal[1][1] / 0.1;
    (speed_mps > STANDING_MPS).then_some(Point { speed_mps, torque_nm: at.torque_nm, accel_mps2, run: at.run.unwrap_or(0) })
}
