//! What is random: a disturbance, an offset per stretch, noise in every reading; and the filter that whitens by it.
//!
//! State [v, d, b]: the part of the speed that the surface does not explain, an Ornstein-Uhlenbeck acceleration d (standard deviation σ_d,
//! time constant τ_d), a constant acceleration b of the stretch (σ_b). v̇ = d + b, v jumps a little where a step of the torque comes early or late
//! (`step_timing.rs`), and a reading is v plus white noise. The innovations of
//! this filter divided by √S are white; since the filter is linear, running the speed and every regressor through the same gains turns
//! generalised least squares into ordinary least squares (Ljung, *System Identification*, prediction error methods).

use faer::traits::pulp::{Arch, Simd, WithSimd};

/// The random part of the model.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Noise {
    /// σ_d [m/s²].
    pub(crate) disturbance_mps2: f64,
    /// τ_d [s].
    pub(crate) disturbance_time_s: f64,
    /// σ_b [m/s²].
    pub(crate) offset_mps2: f64,
    /// Standard deviation of a reading of each witness [m/s]: encoder, yaw rate.
    pub(crate) reading_mps: [f64; 2],
    /// Standard deviation of the speed where a stretch starts from rest, over what is assumed before the data have told
    /// ([`Segment::start_std`](crate::fit::motion::segment::Segment)).
    pub(crate) start_scale: f64,
}

impl Noise {
    /// 1/σ² of a reading of each witness [s²/m²].
    fn precisions(&self) -> [f64; 2] {
        self.reading_mps.map(|std| 1.0 / (std * std))
    }
}

/// Prior standard deviation of the speed where a stretch does not start from rest [m/s].
pub(crate) const UNKNOWN_SPEED_MPS: f64 = 3.0;

/// One reading in a stretch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Reading {
    /// Time on the reference witness's clock [s].
    pub(crate) t_s: f64,
    /// Speed in the gear's frame, scale and bias taken out [m/s].
    pub(crate) speed_mps: f64,
    /// 0 encoder, 1 yaw rate; of several readings, that of the first.
    pub(crate) witness: u8,
    /// Index of the sample in its witness's series; of several, of the first.
    pub(crate) sample: u32,
    /// How many readings of each witness it is the mean of.
    pub(crate) of: [u8; 2],
    /// Variance that the unsure time of steps adds to the speed since the reading before [m²/s²].
    pub(crate) shaken_mps_2: f64,
}

impl Reading {
    /// One reading of one witness.
    pub(crate) fn single(t_s: f64, speed_mps: f64, witness: u8, sample: u32) -> Self {
        let of = if witness == 0 { [1, 0] } else { [0, 1] };
        Self { t_s, speed_mps, witness, sample, of, shaken_mps_2: 0.0 }
    }

    /// Its variance [m²/s²], given 1/σ² of a reading of each witness.
    fn variance(&self, precisions: [f64; 2]) -> f64 {
        1.0 / (f64::from(self.of[0]) * precisions[0] + f64::from(self.of[1]) * precisions[1])
    }
}

/// Gains of the filter at one reading.
#[derive(Debug, Clone, Copy)]
struct Step {
    /// Integral of d over the step, dt, and the decay of d.
    drift: f64,
    dt: f64,
    decay: f64,
    gain: [f64; 3],
    /// 1/√S.
    inverse_root: f64,
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

/// The filter over one stretch: its gains do not depend on the data.
#[derive(Debug, Clone)]
pub(crate) struct Filter {
    steps: Vec<Step>,
}

impl Filter {
    /// Over readings, from `start_s` on.
    pub(crate) fn over(readings: &[Reading], start_s: f64, noise: &Noise, start_std_mps: f64) -> Self {
        let mut p = start_covariance(noise, start_std_mps);
        let mut last = start_s;
        let precisions = noise.precisions();
        let steps = readings
            .iter()
            .map(|reading| {
                let dt = (reading.t_s - last).max(0.0);
                last = reading.t_s;
                let (drift, decay) = predict(&mut p, noise, dt, reading);
                let (gain, over_s) = measure(&mut p, reading.variance(precisions));
                Step { drift, dt, decay, gain, inverse_root: over_s.sqrt() }
            })
            .collect();
        Self { steps }
    }

    /// Replaces each column of `matrix` (row-major, one row per measurement, `columns` wide) by its whitened innovations.
    pub(crate) fn whiten(&self, matrix: &mut [f64], columns: usize) {
        self.whiten_from(0, matrix, columns, &mut States::new(columns));
    }

    /// The same for the rows from measurement `from` on, `states` being what the rows before have left: zero for a column that was zero there.
    pub(crate) fn whiten_from(&self, from: usize, matrix: &mut [f64], columns: usize, states: &mut States) {
        Arch::new().dispatch(Rows { steps: &self.steps[from..], matrix, columns, states });
    }

    /// The transpose of whitening one column, applied to `white`: its inner product with any column is that of `white` with the whitened column.
    pub(crate) fn whiten_transposed(&self, white: &[f64]) -> Vec<f64> {
        let mut transposed = vec![0.0; white.len()];
        let (mut v, mut d, mut b) = (0.0, 0.0, 0.0);
        for ((step, white), out) in self.steps.iter().zip(white).zip(&mut transposed).rev() {
            let [kv, kd, kb] = step.gain;
            *out = step.inverse_root * white + kv * v + kd * d + kb * b;
            v -= *out;
            d = step.drift * v + step.decay * d;
            b += step.dt * v;
        }
        transposed
    }
}

/// The filter's states between two rows, for each column.
pub(crate) struct States {
    v: Vec<f64>,
    d: Vec<f64>,
    b: Vec<f64>,
}

impl States {
    /// Zeros for at most so many columns.
    pub(crate) fn new(columns: usize) -> Self {
        Self { v: vec![0.0; columns], d: vec![0.0; columns], b: vec![0.0; columns] }
    }
}

/// The loop over rows and columns, compiled for the vectors of the machine. Columns do not mix, so their width does not change a bit.
struct Rows<'a> {
    steps: &'a [Step],
    matrix: &'a mut [f64],
    columns: usize,
    states: &'a mut States,
}

impl WithSimd for Rows<'_> {
    type Output = ();

    #[allow(clippy::inline_always)] // only what is inlined is compiled for those vectors
    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let States { v, d, b } = self.states;
        for (step, row) in self.steps.iter().zip(self.matrix.chunks_exact_mut(self.columns)) {
            let [kv, kd, kb] = step.gain;
            for (((z, v), d), b) in row.iter_mut().zip(&mut *v).zip(&mut *d).zip(&mut *b) {
                let ahead = *v + step.drift * *d + step.dt * *b;
                let faded = step.decay * *d;
                let innovation = *z - ahead;
                *v = ahead + kv * innovation;
                *d = faded + kd * innovation;
                *b += kb * innovation;
                *z = innovation * step.inverse_root;
            }
        }
    }
}

/// [`Filter::whiten`] over readings.
pub(crate) fn whiten(matrix: &mut [f64], columns: usize, readings: &[Reading], start_s: f64, noise: &Noise, start_std_mps: f64) {
    Filter::over(readings, start_s, noise, start_std_mps).whiten(matrix, columns);
}

/// −2 log likelihood of a residual sequence, without its constant.
pub(crate) fn deviance(residual_mps: &[f64], readings: &[Reading], start_s: f64, noise: &Noise, start_std_mps: f64) -> f64 {
    let mut p = start_covariance(noise, start_std_mps);
    let (mut v, mut d, mut b) = (0.0, 0.0, 0.0);
    let mut last = start_s;
    let precisions = noise.precisions();
    let mut sum = 0.0;
    // one logarithm for some readings: S lies between 10⁻⁸ and 10
    for (readings, residual_mps) in readings.chunks(16).zip(residual_mps.chunks(16)) {
        let mut product = 1.0;
        for (reading, residual) in readings.iter().zip(residual_mps) {
            let dt = (reading.t_s - last).max(0.0);
            last = reading.t_s;
            let (drift, decay) = predict(&mut p, noise, dt, reading);
            let (gain, over_s) = measure(&mut p, reading.variance(precisions));
            v += drift * d + dt * b;
            d *= decay;
            let innovation = residual - v;
            v += gain[0] * innovation;
            d += gain[1] * innovation;
            b += gain[2] * innovation;
            product *= over_s;
            sum += innovation * innovation * over_s;
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

/// What the filter tells of a residual sequence, one entry per reading.
#[derive(Debug, Clone, Default)]
pub(crate) struct Filtered {
    /// v as the readings before tell it [m/s], and its standard deviation.
    pub(crate) expected_mps: Vec<f64>,
    pub(crate) expected_std_mps: Vec<f64>,
    /// v as the reading tells it as well [m/s].
    pub(crate) speed_mps: Vec<f64>,
    /// Innovations over √S.
    pub(crate) white: Vec<f64>,
    /// b of the stretch [m/s²], as all of them tell it.
    pub(crate) offset_mps2: f64,
}

/// The filter over a residual sequence.
pub(crate) fn filter(residual_mps: &[f64], readings: &[Reading], start_s: f64, noise: &Noise, start_std_mps: f64) -> Filtered {
    let mut p = start_covariance(noise, start_std_mps);
    let mut x = [0.0; 3];
    let mut last = start_s;
    let precisions = noise.precisions();
    let room = || Vec::with_capacity(readings.len());
    let mut told = Filtered { expected_mps: room(), expected_std_mps: room(), speed_mps: room(), white: room(), offset_mps2: 0.0 };
    for (reading, residual) in readings.iter().zip(residual_mps) {
        let dt = (reading.t_s - last).max(0.0);
        last = reading.t_s;
        let (drift, decay) = predict(&mut p, noise, dt, reading);
        x = [x[0] + drift * x[1] + dt * x[2], decay * x[1], x[2]];
        told.expected_mps.push(x[0]);
        told.expected_std_mps.push(p[0][0].sqrt());
        let (gain, over_s) = measure(&mut p, reading.variance(precisions));
        let innovation = residual - x[0];
        for k in 0..3 {
            x[k] += gain[k] * innovation;
        }
        told.speed_mps.push(x[0]);
        told.white.push(innovation * over_s.sqrt());
    }
    told.offset_mps2 = x[2];
    told
}

/// Fixed-interval smoothing of a residual sequence, by Bryson and Frazier's adjoint recursion (Bierman 1973): with λ running backwards from
/// zero, λ ← Hᵀ·(−e/S) + (I − K·H)ᵀ·λ at a reading and λ ← Fᵀ·λ between readings, the smoothed state is x⁻ − P⁻·λ. Nothing is inverted.
pub(crate) fn smooth(residual_mps: &[f64], readings: &[Reading], start_s: f64, noise: &Noise, start_std_mps: f64) -> Deviation {
    /// What the way back needs of one reading.
    struct Passed {
        predicted_mps: f64,
        /// First row of the predicted covariance.
        row: [f64; 3],
        gain: [f64; 3],
        innovation_over_s: f64,
        drift: f64,
        dt: f64,
        decay: f64,
    }
    let mut p = start_covariance(noise, start_std_mps);
    let mut x = [0.0; 3];
    let precisions = noise.precisions();
    let mut passed = Vec::with_capacity(readings.len());
    let mut last = start_s;
    for (reading, residual) in readings.iter().zip(residual_mps) {
        let dt = (reading.t_s - last).max(0.0);
        last = reading.t_s;
        let (drift, decay) = predict(&mut p, noise, dt, reading);
        x = [x[0] + drift * x[1] + dt * x[2], decay * x[1], x[2]];
        let (predicted_mps, row) = (x[0], p[0]);
        let (gain, over_s) = measure(&mut p, reading.variance(precisions));
        let innovation = residual - x[0];
        for k in 0..3 {
            x[k] += gain[k] * innovation;
        }
        passed.push(Passed { predicted_mps, row, gain, innovation_over_s: innovation * over_s, drift, dt, decay });
    }
    let mut speed_mps = vec![0.0; passed.len()];
    let mut adjoint = [0.0; 3];
    for (speed, at) in speed_mps.iter_mut().zip(&passed).rev() {
        let [kv, kd, kb] = at.gain;
        adjoint[0] -= at.innovation_over_s + kv * adjoint[0] + kd * adjoint[1] + kb * adjoint[2];
        *speed = at.predicted_mps - (at.row[0] * adjoint[0] + at.row[1] * adjoint[1] + at.row[2] * adjoint[2]);
        adjoint = [adjoint[0], at.drift * adjoint[0] + at.decay * adjoint[1], at.dt * adjoint[0] + adjoint[2]];
    }
    Deviation { speed_mps, offset_mps2: x[2] }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};

    const NOISE: Noise =
        Noise { disturbance_mps2: 0.1, disturbance_time_s: 0.3, offset_mps2: 0.02, reading_mps: [0.006, 0.008], start_scale: 1.0 };

    fn simulated(n: usize, seed: u64) -> (Vec<Reading>, Vec<f64>) {
        let mut rng = rand_pcg::Pcg64::seed_from_u64(seed);
        let mut draw = || -> f64 { StandardNormal.sample(&mut rng) };
        let dt = 0.001;
        let b = NOISE.offset_mps2 * draw();
        let (mut v, mut d) = (0.0, NOISE.disturbance_mps2 * draw());
        let decay = (-dt / NOISE.disturbance_time_s).exp();
        let mut readings = Vec::new();
        let mut values = Vec::new();
        for k in 0..n * 10 {
            v += dt * (d + b);
            d = decay * d + NOISE.disturbance_mps2 * (1.0 - decay * decay).sqrt() * draw();
            if k % 10 == 9 {
                let witness = u8::try_from(k / 10 % 2).unwrap_or(0);
                readings.push(Reading::single(f64::from(u32::try_from(k + 1).unwrap_or(0)) * dt, 0.0, witness, 0));
                values.push(v + NOISE.reading_mps[usize::from(witness)] * draw());
            }
        }
        (readings, values)
    }

    #[test]
    fn innovations_of_the_true_model_are_white_with_unit_variance() {
        let (readings, mut values) = simulated(6000, 3);
        whiten(&mut values, 1, &readings, 0.0, &NOISE, 3e-3);
        let n = values.len() as f64;
        let variance = values.iter().map(|e| e * e).sum::<f64>() / n;
        let lag_one = values.windows(2).map(|w| w[0] * w[1]).sum::<f64>() / n;
        // standard errors are √(2/n) = 0.018 and 1/√n = 0.013: four of each
        assert!((variance - 1.0).abs() < 0.073, "{variance}");
        assert!(lag_one.abs() < 0.052, "{lag_one}");
    }

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
        let mut columns = values;
        whiten(&mut columns, 1, &readings, 0.0, &NOISE, 3e-3);
        assert!(columns.iter().zip(&filtered.white).all(|(a, b)| (a - b).abs() < 1e-9));
    }

    #[test]
    fn whitening_in_parts_and_transposed_is_the_same_map() {
        let (readings, values) = simulated(200, 13);
        let filter = Filter::over(&readings, 0.0, &NOISE, 3e-3);
        let mut whole: Vec<f64> = values.iter().flat_map(|v| [*v, v * v]).collect();
        let mut parts = whole.clone();
        filter.whiten(&mut whole, 2);
        let mut states = States::new(2);
        let (first, second) = parts.split_at_mut(2 * 70);
        filter.whiten_from(0, first, 2, &mut states);
        filter.whiten_from(70, second, 2, &mut states);
        assert_eq!(whole, parts);
        let transposed = filter.whiten_transposed(&values);
        let one: f64 = values.iter().zip(whole.chunks_exact(2)).map(|(v, row)| v * row[1]).sum();
        let other: f64 = transposed.iter().zip(&values).map(|(t, v)| t * v * v).sum();
        assert!((one - other).abs() < 1e-9 * one.abs(), "{one} {other}");
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
