//! The speed over which the extra friction near standstill fades (Stribeck's), the one parameter of the physics form that is not linear.
//!
//! Its profile likelihood: for each speed, the form's linear parameters and the delays are solved for in the whitened sums. The speed with
//! the least sum of squares is used, with a weak log-normal prior around the default speed. Without it, a vehicle with hardly any extra
//! friction would by chance get a narrow spike at standstill or a hump over half the speeds. The form's own column for an inexact speed
//! is then almost zero; the posterior includes the remaining uncertainty.

use crate::fit::solve::normal_equations::Gram;
use crate::fit::surface::design::{STRIBECK_MPS, friction};
use crate::fit::surface::lattice::Lattice;
use crate::map::Gear;
use faer::linalg::solvers::Solve;
use faer::{Col, Mat};

/// Speeds tried [m/s]: even in their logarithm, from and to; the upper end is a third of the fastest measured if that is less.
const FROM_MPS: f64 = 0.02;
const TO_MPS: f64 = 0.4;
const TRIED: usize = 25;
/// Standard deviation of the prior in the speed's logarithm, around [`STRIBECK_MPS`]: a factor of two.
const PRIOR_STD: f64 = std::f64::consts::LN_2;

/// The most probable speed [m/s], over the sums of each gear; `prior_std` are the prior standard deviations of their nuisance columns.
pub(crate) fn speed(lattice: &Lattice, grams: &[(Gear, &Gram)], prior_std: &[f64]) -> f64 {
    let wholes: Vec<Mat<f64>> = grams.iter().map(|(_, gram)| gram.whole()).collect();
    let to = TO_MPS.min(lattice.fastest_mps() / 3.0).max(FROM_MPS);
    let step = (to / FROM_MPS).ln() / (TRIED - 1) as f64;
    let prior = |speed_mps: f64| ((speed_mps / STRIBECK_MPS).ln() / PRIOR_STD).powi(2);
    let cost = |speed_mps: f64| prior(speed_mps) + wholes.iter().map(|whole| left(lattice, whole, prior_std, speed_mps)).sum::<f64>();
    let tried: Vec<(f64, f64)> = (0..TRIED)
        .map(|k| FROM_MPS * (step * k as f64).exp())
        .map(|speed_mps| (speed_mps, cost(speed_mps)))
        .filter(|(_, cost)| cost.is_finite())
        .collect();
    tried.into_iter().min_by(|a, b| a.1.total_cmp(&b.1)).map_or(STRIBECK_MPS, |best| best.0)
}

/// Minus the part of one gear's squares that the physics form explains with this speed: the sum of squares without a constant.
fn left(lattice: &Lattice, whole: &Mat<f64>, prior_std: &[f64], stribeck_mps: f64) -> f64 {
    let base = lattice.columns();
    let largest = lattice.torque_nm.iter().fold(0.0f64, |m, u| m.max(u.abs()));
    let ones = vec![1.0; lattice.speed_mps.len()];
    let along_torque = [|_: f64| 1.0, |u: f64| u, |u: f64| u.max(0.0)];
    let [one, speed, stribeck, _] = friction(lattice, stribeck_mps);
    let fastest = lattice.fastest_mps();
    let square = lattice.along_speed(|s| (s / fastest).powi(2));
    let columns = [(&one, 0), (&speed, 0), (&square, 0), (&stribeck, 0), (&ones, 1), (&ones, 2), (&speed, 1)];
    let size = columns.len() + prior_std.len();
    let transform = Mat::from_fn(base + prior_std.len(), size, |r, c| match (r.checked_sub(base), columns.get(c)) {
        (None, Some((along_speed, kind))) => {
            let (i, j) = (r / lattice.torque_nm.len(), r % lattice.torque_nm.len());
            along_speed[i] * along_torque[*kind](lattice.torque_nm[j] / largest)
        }
        (Some(n), None) if c - columns.len() == n => 1.0,
        _ => 0.0,
    });
    let sums = whole.submatrix(0, 0, base + prior_std.len(), base + prior_std.len());
    let half = transform.transpose() * sums;
    let mut matrix = &half * &transform;
    for k in 0..size {
        matrix[(k, k)] += match k.checked_sub(columns.len()) {
            Some(n) => 1.0 / (prior_std[n] * prior_std[n]),
            None => 1e-9 * matrix[(k, k)] + 1e-12,
        };
    }
    let last = whole.ncols() - 1;
    let right = transform.transpose() * Col::from_fn(base + prior_std.len(), |r| whole[(r, last)]);
    let Ok(factor) = matrix.llt(faer::Side::Lower) else { return f64::INFINITY };
    let answer = factor.solve(&right);
    -(0..size).map(|k| answer[k] * right[k]).sum::<f64>()
}
