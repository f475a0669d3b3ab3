//! The perturbed plants of the Monte Carlo: the same draws for every scenario and every law, so that differences are theirs.

use crate::sim::{Perturbation, WorldSettings};
use crate::verify::Result;
use rand_distr::{Distribution, StandardUniform};
use rand_pcg::Pcg64;
use serde::{Deserialize, Serialize};

/// How far the plant is varied: each factor uniform in 1 ± spread, independent of the others.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Spread {
    /// Inertia. Default 0.1: tanks half full to full.
    pub inertia: f64,
    /// Friction, breakaway included. Default 0.1: two to three times the run-to-run spread of a warm vehicle.
    pub friction: f64,
    /// Time constant of the drive. Default 0.2.
    pub lag: f64,
    /// Dead time of the drive. Default 0.2.
    pub dead_time: f64,
    /// Noise of plant and sensors. Default 0.5.
    pub noise: f64,
}

impl Default for Spread {
    fn default() -> Self {
        Self { inertia: 0.1, friction: 0.1, lag: 0.2, dead_time: 0.2, noise: 0.5 }
    }
}

/// Number of the random stream, apart from those of the simulator.
const STREAM: u128 = 0x7065_7274;

/// `count` varied plants, each with the seed of its world.
///
/// # Errors
/// A plant that cannot be varied so.
pub(crate) fn draws(plant: &WorldSettings, spread: &Spread, count: usize, seed: u64) -> Result<Vec<(WorldSettings, u64)>> {
    let mut random = Pcg64::new(u128::from(seed), STREAM);
    let mut factor = |spread: f64| {
        let uniform: f64 = StandardUniform.sample(&mut random);
        1.0 + spread * (2.0 * uniform - 1.0)
    };
    (0..count)
        .map(|k| {
            let by = Perturbation {
                inertia_factor: factor(spread.inertia),
                friction_factor: factor(spread.friction),
                lag_factor: factor(spread.lag),
                dead_time_factor: factor(spread.dead_time),
                noise_factor: factor(spread.noise),
                torque_limit_factor: 1.0,
            };
            Ok((plant.perturbed(&by)?, seed.wrapping_mul(1_000_003).wrapping_add(k as u64 + 1)))
        })
        .collect()
}
