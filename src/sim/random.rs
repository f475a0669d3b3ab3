//! Random numbers: one independent stream per source, all from one seed.
//!
//! Each random source draws from its own PCG64 sub-stream, so that a new sensor or a lost message changes no other source.
//! Source: O'Neill (2014), *PCG: A Family of Simple Fast Space-Efficient Statistically Good Algorithms for Random Number Generation*.

use rand_distr::{Distribution, StandardNormal, StandardUniform};
use rand_pcg::Pcg64;

/// The random sources; the number is the PCG stream.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum Stream {
    /// The slow disturbance of the plant.
    Disturbance = 1,
    /// The values drawn once per run: offset, friction.
    Run = 2,
    /// The drive wheel's encoder.
    Encoder = 3,
    /// The gyro.
    Gyro = 4,
    /// The steering angle sensor.
    SteeringAngle = 5,
    /// The localisation.
    Pose = 6,
    /// The drive's torque feedback.
    TorqueFeedback = 7,
    /// The log's torque command messages.
    CommandMessages = 8,
    /// The log's gear messages.
    GearMessages = 9,
    /// The log's emergency stop messages.
    EstopMessages = 10,
    /// The log's odometry messages.
    OdometryMessages = 11,
    /// The order of a campaign's runs.
    Campaign = 12,
    /// Hand dither of the torque.
    Dither = 13,
}

/// The generator of one stream.
#[derive(Debug, Clone)]
pub struct Random(Pcg64);

impl Random {
    /// The generator of `stream` under `seed`.
    pub fn new(seed: u64, stream: Stream) -> Self {
        Self(Pcg64::new(u128::from(seed).wrapping_mul(0x9E37_79B9_7F4A_7C15_F39C_C060_5CED_C835), stream as u128))
    }

    /// A draw from the normal distribution with mean 0 and standard deviation 1.
    pub fn normal(&mut self) -> f64 {
        StandardNormal.sample(&mut self.0)
    }

    /// A draw from the uniform distribution over [0, 1).
    pub fn uniform(&mut self) -> f64 {
        StandardUniform.sample(&mut self.0)
    }
}

/// x⁺ = ρ·x + σ·√(1 − ρ²)·n with ρ = exp(−T/τ): an Ornstein-Uhlenbeck process, held over intervals of [`RandomDisturbance::INTERVAL_S`].
/// This is the exact discretisation, so that its standard deviation is σ at every instant.
#[derive(Debug, Clone)]
pub(crate) struct RandomDisturbance {
    random: Random,
    std_dev: f64,
    decay: f64,
    kick: f64,
    value: f64,
    every: u32,
    left: u32,
}

impl RandomDisturbance {
    /// Hold time of a value [s]: short compared with any time constant in use, long compared with the step.
    pub(crate) const INTERVAL_S: f64 = 0.01;

    /// A process with standard deviation `std_dev` and time constant `time_s`, stepped every `step_s`.
    pub(crate) fn new(seed: u64, std_dev: f64, time_s: f64, step_s: f64) -> Self {
        let every = (Self::INTERVAL_S / step_s).round().max(1.0);
        let decay = if time_s > 0.0 { (-every * step_s / time_s).exp() } else { 0.0 };
        let mut random = Random::new(seed, Stream::Disturbance);
        let value = if std_dev > 0.0 { std_dev * random.normal() } else { 0.0 };
        Self { random, std_dev, decay, kick: std_dev * (1.0 - decay * decay).sqrt(), value, every: every as u32, left: every as u32 }
    }

    /// The value of this step; advances the time by one step.
    #[inline]
    pub(crate) fn step(&mut self) -> f64 {
        if self.std_dev > 0.0 {
            if self.left == 0 {
                self.left = self.every;
                self.value = self.decay * self.value + self.kick * self.random.normal();
            }
            self.left -= 1;
        }
        self.value
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn streams_of_one_seed_differ_and_repeat() {
        let draw = |stream| Random::new(7, stream).normal();
        assert_eq!(draw(Stream::Gyro), draw(Stream::Gyro));
        assert_ne!(draw(Stream::Gyro), draw(Stream::Encoder));
        assert_ne!(draw(Stream::Gyro), Random::new(8, Stream::Gyro).normal());
    }

    #[test]
    fn the_disturbance_has_the_given_deviation_and_correlation() {
        let mut process = RandomDisturbance::new(1, 0.2, 0.5, 0.01);
        let x: Vec<f64> = (0..200_000).map(|_| process.step()).collect();
        let mean_of = |f: &dyn Fn(usize) -> f64| (0..x.len() - 50).map(f).sum::<f64>() / (x.len() - 50) as f64;
        let variance = mean_of(&|k| x[k] * x[k]);
        // 2000 s are 2000 correlation lengths: three standard errors are about 10 %
        assert!((variance.sqrt() / 0.2 - 1.0).abs() < 0.1, "standard deviation {}", variance.sqrt());
        let correlation = mean_of(&|k| x[k] * x[k + 50]) / variance;
        assert!((correlation - (-1.0_f64).exp()).abs() < 0.1, "correlation after one time constant {correlation}");
    }
}
