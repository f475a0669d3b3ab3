//! The Kalman filter of the noise model: one forward recursion, which gives gains, likelihood, filtered and smoothed speeds.

use crate::fit::noise::model::{Noise, Reading};

/// Gains of the filter at one reading, with the step that leads to it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Gains {
    /// Integral of d over the step [s].
    pub(crate) drift: f64,
    /// The step [s].
    pub(crate) dt: f64,
    /// Decay of d over the step.
    pub(crate) decay: f64,
    /// K: the change of v, d and b per innovation.
    pub(crate) gain: [f64; 3],
    /// 1/S.
    pub(crate) over_s: f64,
    /// First row of the covariance before the reading.
    predicted: [f64; 3],
}

/// How a step moves the state: v by `drift`·d + `dt`·b, d by the factor `decay`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct StepAhead {
    /// Integral of d over the step [s].
    pub(crate) drift: f64,
    /// The step [s].
    pub(crate) dt: f64,
    /// Decay of d over the step.
    pub(crate) decay: f64,
}

type Covariance = [[f64; 3]; 3];

fn start_covariance(noise: &Noise, start_std_mps: f64) -> Covariance {
    let mut p = [[0.0; 3]; 3];
    p[0][0] = start_std_mps * start_std_mps;
    p[1][1] = noise.disturbance_mps2 * noise.disturbance_mps2;
    p[2][2] = noise.offset_mps2 * noise.offset_mps2;
    p
}

/// Predicts the covariance over the time `dt` that leads to a reading; returns (∫decay, decay).
fn predict(p: &mut Covariance, noise: &Noise, dt: f64, reading: &Reading) -> (f64, f64) {
    let tau = noise.disturbance_time_s;
    let x = dt / tau;
    let decay = (-x).exp();
    let drift = tau * (1.0 - decay);
    let variance = noise.disturbance_mps2 * noise.disturbance_mps2;
    // ∫∫ of the disturbance's covariance; the series avoids cancellation for short steps
    let q_vv = if x < 1e-2 {
        variance * tau * tau * x * x * x * (2.0 / 3.0 - 0.5 * x)
    } else {
        variance * tau * tau * (2.0 * x - 3.0 + 4.0 * decay - decay * decay)
    };
    let q_vd = variance * tau * (1.0 - decay) * (1.0 - decay);
    let q_dd = variance * (1.0 - decay * decay);
    // F·P·Fᵀ + Q with F = [[1, drift, dt], [0, decay, 0], [0, 0, 1]], written out
    let [[vv, vd, vb], [_, dd, db], [_, _, bb]] = *p;
    let (vd1, vb1) = (vd + drift * dd + dt * db, vb + drift * db + dt * bb);
    let vv1 = vv + drift * vd + dt * vb + drift * vd1 + dt * vb1 + q_vv + reading.shaken_mps_2;
    let (vd2, db2) = (decay * vd1 + q_vd, decay * db);
    *p = [[vv1, vd2, vb1], [vd2, decay * decay * dd + q_dd, db2], [vb1, db2, bb]];
    (drift, decay)
}

/// Measures v with variance `r`; returns (gain, 1/S).
fn measure(p: &mut Covariance, r: f64) -> ([f64; 3], f64) {
    let [[vv, vd, vb], [_, dd, db], [_, _, bb]] = *p;
    let over_s = 1.0 / (vv + r);
    let gain = [vv * over_s, vd * over_s, vb * over_s];
    // (1 − k_v)·P of the first row is r/S·P: no cancellation, however vague the prior
    let kept = r * over_s;
    let (dd1, db1, bb1) = (dd - gain[1] * vd, db - gain[1] * vb, bb - gain[2] * vb);
    *p = [[kept * vv, kept * vd, kept * vb], [kept * vd, dd1, db1], [kept * vb, db1, bb1]];
    (gain, over_s)
}

/// The recursion of the covariance over one stretch, reading by reading.
pub(crate) struct Recursion<'a> {
    noise: &'a Noise,
    precisions: [f64; 2],
    covariance: Covariance,
    last_s: f64,
}

impl<'a> Recursion<'a> {
    /// From `start_s` on, where the speed is known to `start_std_mps`.
    pub(crate) fn new(start_s: f64, noise: &'a Noise, start_std_mps: f64) -> Self {
        Self { noise, precisions: noise.precisions(), covariance: start_covariance(noise, start_std_mps), last_s: start_s }
    }

    /// Steps to the next reading and takes it in.
    pub(crate) fn next(&mut self, reading: &Reading) -> Gains {
        let StepAhead { drift, dt, decay } = self.ahead(reading);
        let predicted = self.covariance[0];
        let (gain, over_s) = self.take(reading);
        Gains { drift, dt, decay, gain, over_s, predicted }
    }

    /// Steps to the next reading without taking it in.
    pub(crate) fn ahead(&mut self, reading: &Reading) -> StepAhead {
        let dt = (reading.t_s - self.last_s).max(0.0);
        self.last_s = reading.t_s;
        let (drift, decay) = predict(&mut self.covariance, self.noise, dt, reading);
        StepAhead { drift, dt, decay }
    }

    /// Takes in the reading stepped to; returns (gain, 1/S).
    pub(crate) fn take(&mut self, reading: &Reading) -> ([f64; 3], f64) {
        measure(&mut self.covariance, reading.variance(self.precisions))
    }

    /// Present variance of the speed [m²/s²].
    pub(crate) fn speed_variance(&self) -> f64 {
        self.covariance[0][0]
    }
}

/// The filter's state [v, d, b].
#[derive(Debug, Clone, Copy, Default)]
struct FilterState([f64; 3]);

impl FilterState {
    /// Over the step that leads to a reading.
    fn predict(&mut self, gains: &Gains) {
        let [v, d, b] = self.0;
        self.0 = [v + gains.drift * d + gains.dt * b, gains.decay * d, b];
    }

    /// Takes in a residual; returns the innovation.
    fn measure(&mut self, gains: &Gains, residual_mps: f64) -> f64 {
        let innovation = residual_mps - self.0[0];
        for (x, gain) in self.0.iter_mut().zip(gains.gain) {
            *x += gain * innovation;
        }
        innovation
    }
}

/// −2 log likelihood of a residual sequence, without its constant.
pub(crate) fn deviance(residual_mps: &[f64], readings: &[Reading], start_s: f64, noise: &Noise, start_std_mps: f64) -> f64 {
    let mut recursion = Recursion::new(start_s, noise, start_std_mps);
    let mut state = FilterState::default();
    let mut sum = 0.0;
    // one logarithm for some readings: S lies between 10⁻⁸ and 10
    for (readings, residual_mps) in readings.chunks(16).zip(residual_mps.chunks(16)) {
        let mut product = 1.0;
        for (reading, residual_mps) in readings.iter().zip(residual_mps) {
            let gains = recursion.next(reading);
            state.predict(&gains);
            let innovation = state.measure(&gains, *residual_mps);
            product *= gains.over_s;
            sum += innovation * innovation * gains.over_s;
        }
        sum -= product.ln();
    }
    sum
}

/// Deviation from the surface over a stretch.
#[derive(Debug, Clone, Default)]
pub(crate) struct Deviation {
    /// v at each reading [m/s].
    pub(crate) speed_mps: Vec<f64>,
    /// b of the stretch [m/s²].
    pub(crate) offset_mps2: f64,
}

/// The filter's results for a residual sequence, one entry per reading.
#[derive(Debug, Clone, Default)]
pub(crate) struct Filtered {
    /// v as expected from the readings before [m/s], and its standard deviation.
    pub(crate) expected_mps: Vec<f64>,
    pub(crate) expected_std_mps: Vec<f64>,
    /// v with the reading taken in [m/s].
    pub(crate) speed_mps: Vec<f64>,
    /// Innovations over √S.
    pub(crate) white: Vec<f64>,
    /// b of the stretch [m/s²].
    pub(crate) offset_mps2: f64,
}

/// The filter over a residual sequence.
pub(crate) fn filter(residual_mps: &[f64], readings: &[Reading], start_s: f64, noise: &Noise, start_std_mps: f64) -> Filtered {
    let mut recursion = Recursion::new(start_s, noise, start_std_mps);
    let mut state = FilterState::default();
    let room = || Vec::with_capacity(readings.len());
    let mut found = Filtered { expected_mps: room(), expected_std_mps: room(), speed_mps: room(), white: room(), offset_mps2: 0.0 };
    for (reading, residual_mps) in readings.iter().zip(residual_mps) {
        let gains = recursion.next(reading);
        state.predict(&gains);
        found.expected_mps.push(state.0[0]);
        found.expected_std_mps.push(gains.predicted[0].sqrt());
        let innovation = state.measure(&gains, *residual_mps);
        found.speed_mps.push(state.0[0]);
        found.white.push(innovation * gains.over_s.sqrt());
    }
    found.offset_mps2 = state.0[2];
    found
}

/// Fixed-interval smoothing of a residual sequence, by Bryson and Frazier's adjoint recursion (Bierman 1973): with λ running backwards from
/// zero, λ ← Hᵀ·(−e/S) + (I − K·H)ᵀ·λ at a reading and λ ← Fᵀ·λ between readings, the smoothed state is x⁻ − P⁻·λ. Nothing is inverted.
pub(crate) fn smooth(residual_mps: &[f64], readings: &[Reading], start_s: f64, noise: &Noise, start_std_mps: f64) -> Deviation {
    let mut recursion = Recursion::new(start_s, noise, start_std_mps);
    let mut state = FilterState::default();
    // gains, predicted speed and e/S of each reading
    let mut passed = Vec::with_capacity(readings.len());
    for (reading, residual_mps) in readings.iter().zip(residual_mps) {
        let gains = recursion.next(reading);
        state.predict(&gains);
        let predicted_mps = state.0[0];
        let innovation = state.measure(&gains, *residual_mps);
        passed.push((gains, predicted_mps, innovation * gains.over_s));
    }
    let mut speed_mps = vec![0.0; passed.len()];
    let mut adjoint = [0.0; 3];
    for (speed, (at, predicted_mps, innovation_over_s)) in speed_mps.iter_mut().zip(&passed).rev() {
        let [kv, kd, kb] = at.gain;
        adjoint[0] -= innovation_over_s + kv * adjoint[0] + kd * adjoint[1] + kb * adjoint[2];
        *speed = predicted_mps - (at.predicted[0] * adjoint[0] + at.predicted[1] * adjoint[1] + at.predicted[2] * adjoint[2]);
        adjoint = [adjoint[0], at.drift * adjoint[0] + at.decay * adjoint[1], at.dt * adjoint[0] + adjoint[2]];
    }
    Deviation { speed_mps, offset_mps2: state.0[2] }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fit::noise::simulated::{NOISE, simulated};

    #[test]
    fn the_likelihood_prefers_the_true_noise() {
        let (readings, values) = simulated(3000, 5);
        let at = |noise: Noise| deviance(&values, &readings, 0.0, &noise, 3e-3);
        let truth = at(NOISE);
        assert!(truth < at(Noise { disturbance_mps2: 0.2, ..NOISE }));
        assert!(truth < at(Noise { disturbance_mps2: 0.05, ..NOISE }));
        assert!(truth < at(Noise { reading_mps: [0.012, 0.016], ..NOISE }));
    }

    #[test]
    fn the_filter_ends_where_the_smoother_does_and_knows_nothing_of_what_follows() {
        let (readings, values) = simulated(500, 11);
        let filtered = filter(&values, &readings, 0.0, &NOISE, 3e-3);
        let smoothed = smooth(&values, &readings, 0.0, &NOISE, 3e-3);
        assert!((filtered.speed_mps[499] - smoothed.speed_mps[499]).abs() < 1e-12);
        assert!((filtered.offset_mps2 - smoothed.offset_mps2).abs() < 1e-12);
        let shorter = filter(&values[..200], &readings[..200], 0.0, &NOISE, 3e-3);
        assert_eq!(shorter.speed_mps, filtered.speed_mps[..200]);
    }

    #[test]
    fn smoothing_comes_nearer_to_the_truth_than_a_reading() {
        let (readings, values) = simulated(2000, 7);
        let smoothed = smooth(&values, &readings, 0.0, &NOISE, 3e-3);
        let rough: f64 = values.windows(3).map(|w| (w[0] - 2.0 * w[1] + w[2]).powi(2)).sum();
        let fine: f64 = smoothed.speed_mps.windows(3).map(|w| (w[0] - 2.0 * w[1] + w[2]).powi(2)).sum();
        let miss = values.iter().zip(&smoothed.speed_mps).map(|(a, b)| (a - b).powi(2)).sum::<f64>() / values.len() as f64;
        assert!(fine < 0.02 * rough && miss.sqrt() < 0.01 && miss.sqrt() > 0.004, "{fine} {rough} {}", miss.sqrt());
    }
}
