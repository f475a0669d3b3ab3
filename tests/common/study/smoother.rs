//! A smooth surface through differenced points: a plain form and a penalised lattice, its penalty chosen on runs left out.

use super::differencing::Point;
use super::grid::Grid;
use faer::linalg::solvers::Solve;
use faer::{Col, Mat};

const SPEEDS: usize = 12;
const TORQUES: usize = 14;
const PLAIN: usize = 8;
const WARP_MPS: f64 = 0.12;

struct Frame {
    fastest_mps: f64,
    lowest_nm: f64,
    highest_nm: f64,
}

impl Frame {
    /// Columns that are not zero at a point: index and value.
    fn row(&self, v: f64, u: f64) -> Vec<(usize, f64)> {
        let w = ((1.0 + v.max(0.0) / WARP_MPS).ln() / (1.0 + self.fastest_mps / WARP_MPS).ln()).min(1.0);
        let (x, y) = (v / self.fastest_mps, u / self.highest_nm);
        let stribeck = v / 0.08;
        let plain: [f64; PLAIN] = [1.0, y, y.max(0.0), w, x, x * x, x * y, (-stribeck * stribeck).exp()];
        let mut row: Vec<(usize, f64)> = plain.into_iter().enumerate().collect();
        let place = |share: f64, n: usize| {
            let at = share.clamp(0.0, 1.0) * (n - 1) as f64;
            let i = (at as usize).min(n - 2);
            (i, at - i as f64)
        };
        let (i, p) = place(w, SPEEDS);
        let (j, q) = place((u - self.lowest_nm) / (self.highest_nm - self.lowest_nm), TORQUES);
        for (di, wi) in [(0, 1.0 - p), (1, p)] {
            for (dj, wj) in [(0, 1.0 - q), (1, q)] {
                row.push((PLAIN + (i + di) * TORQUES + j + dj, wi * wj));
            }
        }
        row
    }
}

/// The surface.
pub(crate) fn surface(points: &[Point]) -> Grid {
    let fold = |f: fn(f64, f64) -> f64, g: fn(&Point) -> f64| points.iter().map(g).fold(g(&points[0]), f);
    let frame = Frame {
        fastest_mps: fold(f64::max, |p| p.speed_mps),
        lowest_nm: fold(f64::min, |p| p.torque_nm),
        highest_nm: fold(f64::max, |p| p.torque_nm),
    };
    let halves = [0, 1].map(|half| equations(&frame, points.iter().filter(|p| p.run % 2 == half)));
    let penalties: Vec<f64> = (-2..=6).map(|k| 10f64.powi(k)).collect();
    let judged = |penalty: f64| -> f64 {
        (0..2)
            .map(|half| {
                let theta = solve(&halves[half], penalty);
                points
                    .iter()
                    .filter(|p| p.run % 2 != half)
                    .map(|p| (p.accel_mps2 - value(&frame, &theta, p.speed_mps, p.torque_nm)).powi(2))
                    .sum::<f64>()
            })
            .sum()
    };
    let scored: Vec<(f64, f64)> = penalties.into_iter().map(|l| (judged(l), l)).collect();
    let best = scored.iter().min_by(|a, b| a.0.total_cmp(&b.0)).map_or(1.0, |s| s.1);
    let whole = (&halves[0].0 + &halves[1].0, &halves[0].1 + &halves[1].1);
    // twice the data deserve the same penalty: it is the prior's
    let theta = solve(&whole, best);
    let speeds: Vec<f64> = (0..=60).map(|k| frame.fastest_mps * (f64::from(k) / 60.0).powi(2)).collect();
    let torques: Vec<f64> = (0..=60).map(|k| frame.lowest_nm + (frame.highest_nm - frame.lowest_nm) * f64::from(k) / 60.0).collect();
    let rows = speeds.iter().map(|v| torques.iter().map(|u| value(&frame, &theta, *v, *u)).collect()).collect();
    Grid::new(speeds, torques, rows)
}

fn value(frame: &Frame, theta: &Col<f64>, v: f64, u: f64) -> f64 {
    frame.row(v, u).iter().map(|(k, b)| b * theta[*k]).sum()
}

fn equations<'a>(frame: &Frame, points: impl Iterator<Item = &'a Point>) -> (Mat<f64>, Col<f64>) {
    let size = PLAIN + SPEEDS * TORQUES;
    let (mut matrix, mut right) = (Mat::zeros(size, size), Col::zeros(size));
    for p in points {
        let row = frame.row(p.speed_mps, p.torque_nm);
        for (a, x) in &row {
            for (b, y) in &row {
                matrix[(*a, *b)] += x * y;
            }
            right[*a] += x * p.accel_mps2;
        }
    }
    (matrix, right)
}

/// Second differences along both axes under one penalty; a faint ridge leaves the plain form its part.
fn solve((matrix, right): &(Mat<f64>, Col<f64>), penalty: f64) -> Col<f64> {
    let mut m = matrix.clone();
    let node = |i: usize, j: usize| PLAIN + i * TORQUES + j;
    for i in 0..SPEEDS {
        for j in 0..TORQUES {
            m[(node(i, j), node(i, j))] += 1e-2 * penalty;
            let mut bend = |three: [usize; 3]| {
                for (a, x) in three.into_iter().zip([1.0, -2.0, 1.0]) {
                    for (b, y) in three.into_iter().zip([1.0, -2.0, 1.0]) {
                        m[(a, b)] += penalty * x * y;
                    }
                }
            };
            if i > 0 && i + 1 < SPEEDS {
                bend([node(i - 1, j), node(i, j), node(i + 1, j)]);
            }
            if j > 0 && j + 1 < TORQUES {
                bend([node(i, j - 1), node(i, j), node(i, j + 1)]);
            }
        }
    }
    for k in 0..PLAIN {
        m[(k, k)] += 1e-6 * (matrix[(k, k)] + 1.0);
    }
    m.llt(faer::Side::Lower).map_or_else(|_| Col::zeros(m.nrows()), |factor| factor.solve(right))
}
