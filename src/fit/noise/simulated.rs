//! Readings of the model, for tests.

use crate::fit::noise::model::{Noise, Reading};
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};

/// What is simulated.
pub(crate) const NOISE: Noise =
    Noise { disturbance_mps2: 0.1, disturbance_time_s: 0.3, offset_mps2: 0.02, reading_mps: [0.006, 0.008], start_scale: 1.0 };

/// `n` readings, 10 ms apart, of encoder and yaw rate in turn: times and values.
pub(crate) fn simulated(n: usize, seed: u64) -> (Vec<Reading>, Vec<f64>) {
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
            let source = u8::try_from(k / 10 % 2).unwrap_or(0);
            readings.push(Reading::single(f64::from(u32::try_from(k + 1).unwrap_or(0)) * dt, 0.0, source, 0));
            values.push(v + NOISE.reading_mps[usize::from(source)] * draw());
        }
    }
    (readings, values)
}
