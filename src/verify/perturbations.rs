//! The perturbed plants of the Monte Carlo set. Every scenario and every law has the same draws, so that they can be compared.

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

/// Number of the random stream; differs from those of the simulator.
const STREAM: u128 = 0x7065_7274;

/// `count` varied plants, each with the seed of its world.
///
/// # Errors
/// A plant that cannot be varied.
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

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::map::Vehicle;
    use crate::sim::{MotionSettings, PhysicalSettings};

    fn plant() -> WorldSettings {
        let vehicle =
            Vehicle { wheelbase_m: 0.9, wheel_radius_m: 0.12, test_angle_deg: 90.0, torque_limit_nm: None, torque_full_scale_nm: None };
        WorldSettings::physical(vehicle, PhysicalSettings::default())
    }

    #[test]
    fn fewer_draws_are_the_first_of_more_and_another_seed_gives_others() {
        let drawn = |count, seed| draws(&plant(), &Spread::default(), count, seed).unwrap();
        assert_eq!(drawn(3, 1), drawn(9, 1)[..3]);
        assert!(drawn(3, 1).iter().zip(drawn(3, 2)).all(|(a, b)| a.1 != b.1 && a.0 != b.0));
    }

    #[test]
    fn the_plants_fill_their_spread_and_stay_within_it() {
        let lag_s = plant().drive.lag_s;
        let factors: Vec<f64> = draws(&plant(), &Spread::default(), 400, 1).unwrap().iter().map(|d| d.0.drive.lag_s / lag_s).collect();
        let (low, high) = factors.iter().fold((f64::INFINITY, 0.0_f64), |(low, high), &f| (low.min(f), high.max(f)));
        // 400 uniform draws miss a twentieth of their range with a probability of 1e-9
        assert!((0.8..0.82).contains(&low) && (1.18..=1.2).contains(&high), "{low} {high}");
        let none = Spread { inertia: 0.0, friction: 0.0, lag: 0.0, dead_time: 0.0, noise: 0.0 };
        let MotionSettings::Physical(same) = draws(&plant(), &none, 1, 1).unwrap()[0].0.motion.clone() else { panic!("not physical") };
        assert_eq!(same, PhysicalSettings::default());
    }
}
