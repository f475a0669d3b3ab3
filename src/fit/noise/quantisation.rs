//! Readings in coarse steps. A reading r in steps of q means that the speed lies within r ± q/2. That is not white noise: neighbouring
//! readings on one step have the same error, and only the moments at which the reading changes hold much information.
//!
//! The likelihood of an interval under the filter's prediction N(m, s²) is Z = Φ(β) − Φ(α) with α, β = (r ∓ q/2 − m)/s. With g = ∂ln Z/∂m
//! and h = −∂²ln Z/∂m² the filter continues as after a reading y = m + g/h of variance 1/h − P, which has the same mean and variance
//! (assumed-density filtering; Minka 2001, *A family of algorithms for approximate Bayesian inference*). Least squares over such readings is
//! a Newton step on the interval likelihood (Gustafsson & Karlsson 2009, *Statistical results for system identification based on quantized
//! observations*), so rounds that alternate between readings and surface increase it.

use crate::fit::noise::kalman::Recursion;
use crate::fit::noise::model::{Noise, Reading};

/// Noise of the speed before it is rounded, as a share of the step: that of the sensor, and stamps with an error of a millisecond or two.
/// (With 0.03 the edges of the intervals are too sharp: a sixth more error.)
const UNROUNDED: f64 = 0.1;
/// Least information of a reading, as a share of that of a plain one: an interval that holds the whole prediction gives no information.
const LEAST_INFORMATION: f64 = 1e-4;

/// Replaces the readings of sources with coarse steps by their equivalents. `predicted_mps` is the surface's prediction of each reading,
/// `steps_mps` the step of each source, 0 for a fine one.
pub(crate) fn replace_coarse(
    readings: &mut [Reading],
    predicted_mps: &[f64],
    steps_mps: [f64; 2],
    (start_s, start_std_mps): (f64, f64),
    noise: &Noise,
) {
    let mut recursion = Recursion::new(start_s, noise, start_std_mps);
    let mut deviation = [0.0; 3];
    for (reading, predicted_mps) in readings.iter_mut().zip(predicted_mps) {
        let step_mps = steps_mps[usize::from(reading.source)];
        let ahead = recursion.ahead(reading);
        let (drift, dt, decay) = (ahead.drift, ahead.dt, ahead.decay);
        deviation = [deviation[0] + drift * deviation[1] + dt * deviation[2], decay * deviation[1], deviation[2]];
        if step_mps > 0.0 {
            let expected_mps = predicted_mps + deviation[0];
            let variance = recursion.speed_variance();
            (reading.speed_mps, reading.own_variance_mps_2) = equivalent(reading.speed_mps, step_mps, expected_mps, variance);
        }
        let (gain, _) = recursion.take(reading);
        let innovation = reading.speed_mps - predicted_mps - deviation[0];
        deviation.iter_mut().zip(gain).for_each(|(x, gain)| *x += gain * innovation);
    }
}

/// The plain reading that replaces one in steps, and its variance, where the speed is expected at N(`expected_mps`, `variance`).
fn equivalent(reading_mps: f64, step_mps: f64, expected_mps: f64, variance: f64) -> (f64, f64) {
    let sensor = (UNROUNDED * step_mps).powi(2);
    let spread = (variance + sensor).sqrt();
    let below = (reading_mps - 0.5 * step_mps - expected_mps) / spread;
    let above = (reading_mps + 0.5 * step_mps - expected_mps) / spread;
    let (slope, curvature) = derivatives(below, above);
    let plain = variance + step_mps * step_mps / 12.0;
    let information = (curvature / (spread * spread)).max(LEAST_INFORMATION / plain);
    // 1/h is S, of which the prediction's variance is a part
    let own = (1.0 / information - variance).max(sensor);
    (expected_mps + slope / spread * (own + variance), own)
}

/// g and h of ln(Φ(β) − Φ(α)) by a shift of the mean, for a standard deviation of one.
fn derivatives(below: f64, above: f64) -> (f64, f64) {
    // mirrored, so that the interval lies above the mean: differences of small tails then keep their precision
    if below + above < 0.0 {
        let (slope, curvature) = derivatives(-above, -below);
        return (-slope, curvature);
    }
    let density = |x: f64| (-0.5 * x * x).exp() / (2.0 * std::f64::consts::PI).sqrt();
    let tail = |x: f64| 0.5 * libm::erfc(x / std::f64::consts::SQRT_2);
    let probability = tail(below) - tail(above);
    if below > 6.0 || probability < 1e-12 {
        // far outside: a pull to the nearest end, as of a reading there
        return (below + 1.0 / below.max(1.0), 1.0);
    }
    let slope = (density(below) - density(above)) / probability;
    let curvature = slope * slope - (below * density(below) - above * density(above)) / probability;
    (slope, curvature.clamp(0.0, 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_interval_is_its_truncated_normal_distribution() {
        let (step, expected, variance) = (0.05, 0.43, 0.02f64.powi(2));
        let (mean, own) = equivalent(0.45, step, expected, variance);
        // the posterior by integration over the true speed
        let sensor = UNROUNDED * step;
        let weight = |v: f64| {
            let prior = (-0.5 * (v - expected).powi(2) / variance).exp();
            let phi = |x: f64| 0.5 * libm::erfc(-x / std::f64::consts::SQRT_2);
            prior * (phi((0.45 + 0.5 * step - v) / sensor) - phi((0.45 - 0.5 * step - v) / sensor))
        };
        let grid: Vec<f64> = (0..8000).map(|k| 0.3 + 4e-5 * f64::from(k)).collect();
        let total: f64 = grid.iter().map(|v| weight(*v)).sum();
        let centre = grid.iter().map(|v| v * weight(*v)).sum::<f64>() / total;
        let square = grid.iter().map(|v| (v - centre).powi(2) * weight(*v)).sum::<f64>() / total;
        let gain = variance / (variance + own);
        assert!((expected + gain * (mean - expected) - centre).abs() < 2e-4, "{mean} {own} {centre}");
        assert!(((1.0 - gain) * variance / square - 1.0).abs() < 0.02, "{} {square}", (1.0 - gain) * variance);
    }

    #[test]
    fn a_sure_prediction_inside_the_interval_learns_nothing_and_one_outside_is_pulled_in() {
        let (_, inside) = equivalent(0.45, 0.05, 0.451, 1e-8);
        assert!(inside > 0.1, "{inside}");
        let (value, own) = equivalent(0.45, 0.05, 0.60, 0.01f64.powi(2));
        assert!(own < 0.02f64.powi(2) && value < 0.49, "{value} {own}");
        // as far below as above
        let (mirrored, _) = equivalent(0.45, 0.05, 0.30, 0.01f64.powi(2));
        assert!((mirrored - 0.45 + (value - 0.45)).abs() < 1e-9);
    }
}
