//! Positions of the breaks of Table 2.

use crate::invert::inverse::Inverse;

/// Spacing of the default acceleration breaks [m/s²].
const ACCEL_STEP_MPS2: f64 = 0.1;

/// Largest acceleration of a wheel that grips the floor is 10 m/s²; a table beyond ten times that is none of a vehicle [m/s²].
pub(crate) const MOST_ACCEL_MPS2: f64 = 100.0;

/// Least and largest acceleration by torques within `range_nm` at any of `speeds`, with 0 between them [m/s²].
pub(crate) fn accel_range_mps2(inverse: &Inverse, speeds: &[f64], range_nm: [f64; 2]) -> [f64; 2] {
    let reach = |u: f64| speeds.iter().map(move |v| inverse.accel_mps2(*v, u));
    [reach(range_nm[0]).fold(f64::INFINITY, f64::min).min(0.0), reach(range_nm[1]).fold(f64::NEG_INFINITY, f64::max).max(0.0)]
}

/// Every 0.1 m/s² over the accelerations by torques within `range_nm` at any of `speeds`, rounded outward.
pub(crate) fn accel_breaks(inverse: &Inverse, speeds: &[f64], range_nm: [f64; 2]) -> Vec<f64> {
    let [low, high] = accel_range_mps2(inverse, speeds, range_nm);
    let first = (low / ACCEL_STEP_MPS2 + 1e-9).floor() as i64;
    let last = ((high / ACCEL_STEP_MPS2 - 1e-9).ceil() as i64).max(first + 1);
    (first..=last).map(|k| (k as f64 * ACCEL_STEP_MPS2 * 1e9).round() / 1e9).collect()
}

/// `count` breaks over `from` to `to`, dense where a function bends: equal shares of ∫ (|f″| + floor)^⅖ dx, which for a piecewise linear
/// interpolant gives each interval the same part of the squared error (de Boor, *A Practical Guide to Splines*, ch. XII).
pub(crate) fn placed(from: f64, to: f64, count: usize, curves: &[&dyn Fn(f64) -> f64]) -> Vec<f64> {
    const STEPS: usize = 400;
    let h = (to - from) / STEPS as f64;
    let bend = |k: usize| {
        let x = (from + k as f64 * h).clamp(from + h, to - h);
        curves.iter().map(|f| ((f(x - h) - 2.0 * f(x) + f(x + h)) / (h * h)).abs()).fold(0.0, f64::max)
    };
    let bends: Vec<f64> = (0..=STEPS).map(bend).collect();
    let floor = 0.05 * bends.iter().sum::<f64>() / bends.len() as f64 + 1e-12;
    let density: Vec<f64> = bends.iter().map(|b| (b + floor).powf(0.4)).collect();
    let mut total = vec![0.0];
    for k in 1..=STEPS {
        total.push(total[k - 1] + 0.5 * (density[k] + density[k - 1]));
    }
    let whole = total[STEPS];
    let mut breaks: Vec<f64> = (0..count)
        .map(|k| {
            let wanted = whole * k as f64 / (count - 1) as f64;
            let upper = total.partition_point(|t| *t < wanted).clamp(1, STEPS);
            let share = (wanted - total[upper - 1]) / (total[upper] - total[upper - 1]);
            ((from + (upper as f64 - 1.0 + share) * h) * 1e4).round() / 1e4
        })
        .collect();
    breaks[0] = from;
    breaks[count - 1] = to;
    breaks.dedup_by(|a, b| *a <= *b);
    breaks
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn breaks_gather_where_the_curve_bends() {
        let bent = |x: f64| (-x / 0.05).exp();
        let breaks = placed(0.0, 1.0, 12, &[&bent]);
        assert_eq!((breaks[0], breaks[breaks.len() - 1]), (0.0, 1.0));
        assert!(breaks.windows(2).all(|w| w[1] > w[0]));
        assert!(breaks.iter().filter(|b| **b < 0.2).count() >= 6, "{breaks:?}");
    }
}
