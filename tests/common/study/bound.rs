//! The Cramér-Rao bound of A(v, u), from the sensitivity of the simulated speed to every parameter of the true vehicle.
//!
//! ṡ = A_v·s + ∂A/∂p along the true way, from s = 0 at breakaway. The readings are the speed with white noise; the speed is driven by the
//! disturbance and the run's offset as well. The filter of that model turns the sensitivities into innovations E with unit variance, and
//! the Fisher information is Σ E·Eᵀ (Ljung, *System Identification*, prediction error methods). Dead time, lag, the encoder's scale and its
//! delay count as unknown.

use super::drive::Drive;
use super::vehicle::{DISTURBANCE_MPS2, DISTURBANCE_S, ENCODER_MPS, OFFSET_MPS2, QUANTUM_MPS, Truth, YAW_MPS};
use faer::Mat;
use faer::linalg::solvers::DenseSolveCore;

/// Parameters beside those of A: dead time, lag, encoder scale, encoder delay.
const OTHERS: usize = 4;
/// Time between readings [s].
const STEP_S: f64 = 0.01;

/// The inverse of the Fisher information over the parameters of A.
pub(crate) struct Bound<'a> {
    truth: &'a Truth,
    covariance: Mat<f64>,
}

impl<'a> Bound<'a> {
    /// Over all moving samples of a drive; `None` when the information is singular.
    pub(crate) fn new(truth: &'a Truth, drive: &Drive) -> Option<Self> {
        let own = truth.parameters.len();
        let size = own + OTHERS;
        let mut information: Mat<f64> = Mat::zeros(size, size);
        let mut run = None;
        let mut sensitivity = vec![0.0; size];
        let mut filter = Filter::new(size);
        for (k, sample) in drive.samples.iter().enumerate() {
            if sample.run.is_none() {
                run = None;
                continue;
            }
            if sample.run != run {
                run = sample.run;
                sensitivity.fill(0.0);
                filter = Filter::new(size);
            }
            let (v, u) = (sample.speed_mps, sample.torque_nm);
            // readings at this moment, from what was integrated up to it
            filter.reading(&sensitivity, YAW_MPS * YAW_MPS, &mut information);
            if k % 2 == 0 {
                let mut encoder = sensitivity.clone();
                encoder[own + 2] += v;
                encoder[own + 3] -= truth.accel_mps2(v, u);
                filter.reading(&encoder, ENCODER_MPS * ENCODER_MPS + QUANTUM_MPS * QUANTUM_MPS / 12.0, &mut information);
            }
            let (by_speed, slope) = (truth.by_speed(v, u), truth.slope(v, u));
            let mut rate = truth.by_parameters(v, u);
            rate.extend([slope * sample.by_dead_time, slope * sample.by_lag, 0.0, 0.0]);
            let grown = (by_speed * STEP_S).exp();
            for (s, r) in sensitivity.iter_mut().zip(&rate) {
                *s = grown * *s + STEP_S * r;
            }
            filter.step(by_speed);
        }
        // scaled to a unit diagonal: the parameters have different units
        let scale: Vec<f64> = (0..size).map(|k| 1.0 / information[(k, k)].max(1e-300).sqrt()).collect();
        let scaled = Mat::from_fn(size, size, |a, b| scale[a] * information[(a, b)] * scale[b]);
        let inverse = scaled.llt(faer::Side::Lower).ok()?.inverse();
        Some(Self { truth, covariance: Mat::from_fn(own, own, |a, b| scale[a] * inverse[(a, b)] * scale[b]) })
    }

    /// Least standard deviation of an unbiased A(v, u) [m/s²].
    pub(crate) fn accel_std_mps2(&self, speed_mps: f64, torque_nm: f64) -> f64 {
        let c = self.truth.by_parameters(speed_mps, torque_nm);
        let sum: f64 =
            (0..c.len()).flat_map(|a| (0..c.len()).map(move |b| (a, b))).map(|(a, b)| c[a] * self.covariance[(a, b)] * c[b]).sum();
        sum.sqrt()
    }
}

/// The filter over [v, d, b], run over every column of sensitivities at once.
struct Filter {
    p: [[f64; 3]; 3],
    /// v, d and b of each column.
    state: Vec<[f64; 3]>,
}

impl Filter {
    fn new(columns: usize) -> Self {
        let mut p = [[0.0; 3]; 3];
        p[1][1] = DISTURBANCE_MPS2 * DISTURBANCE_MPS2;
        p[2][2] = OFFSET_MPS2 * OFFSET_MPS2;
        Self { p, state: vec![[0.0; 3]; columns] }
    }

    /// From one reading time to the next.
    fn step(&mut self, by_speed: f64) {
        let grown = (by_speed * STEP_S).exp();
        let decay = (-STEP_S / DISTURBANCE_S).exp();
        let drift = DISTURBANCE_S * (1.0 - decay);
        let f = [[grown, drift, STEP_S], [0.0, decay, 0.0], [0.0, 0.0, 1.0]];
        let mut half = [[0.0; 3]; 3];
        let mut next = [[0.0; 3]; 3];
        for a in 0..3 {
            for b in 0..3 {
                half[a][b] = (0..3).map(|c| f[a][c] * self.p[c][b]).sum();
            }
        }
        for a in 0..3 {
            for b in 0..3 {
                next[a][b] = (0..3).map(|c| half[a][c] * f[b][c]).sum();
            }
        }
        // short steps: the leading terms of the disturbance's integral
        let q = 2.0 * DISTURBANCE_MPS2 * DISTURBANCE_MPS2 / DISTURBANCE_S;
        next[0][0] += q * STEP_S.powi(3) / 3.0;
        next[0][1] += q * STEP_S.powi(2) / 2.0;
        next[1][0] += q * STEP_S.powi(2) / 2.0;
        next[1][1] += q * STEP_S;
        self.p = next;
        for x in &mut self.state {
            *x = [grown * x[0] + drift * x[1] + STEP_S * x[2], decay * x[1], x[2]];
        }
    }

    /// One reading: adds its information.
    fn reading(&mut self, sensitivity: &[f64], variance: f64, information: &mut Mat<f64>) {
        let s = self.p[0][0] + variance;
        let gain = [self.p[0][0] / s, self.p[1][0] / s, self.p[2][0] / s];
        let innovations: Vec<f64> = sensitivity.iter().zip(&self.state).map(|(z, x)| z - x[0]).collect();
        for (a, ea) in innovations.iter().enumerate() {
            for (b, eb) in innovations.iter().enumerate() {
                information[(a, b)] += ea * eb / s;
            }
        }
        for (x, e) in self.state.iter_mut().zip(&innovations) {
            x.iter_mut().zip(gain).for_each(|(x, g)| *x += g * e);
        }
        let first = self.p[0];
        for a in 0..3 {
            for b in 0..3 {
                self.p[a][b] -= gain[a] * first[b];
            }
        }
    }
}
