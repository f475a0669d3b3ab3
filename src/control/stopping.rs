//! The wheel's place when a command acts, and the deceleration that then stops it at the end.
//!
//! A command acts after the reaction time T; until then the commands of the last T act, with mean a. Then the speed is
//! v' = max(v + a·T, 0), the covered distance ½·(v + v')·T, and with s' remaining the deceleration v'²/(2·s') stops the wheel at the end.
//! This is the classical stopping distance with a predictor of the dead time (Source: Smith 1959; Åström & Hägglund, *Advanced PID
//! Control*, §8.2).

use crate::{Error, Result};

/// The wheel at the time when a command that is given now acts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Arrival {
    /// Speed [m/s], 0 or more.
    pub speed_mps: f64,
    /// Remaining path [m]; negative past the end.
    pub left_m: f64,
}

/// The remaining path counts as at least this [m].
const LEAST_LEFT_M: f64 = 5e-3;

impl Arrival {
    /// From the speed [m/s], the mean pending acceleration [m/s²], the remaining path [m], and the reaction time [s].
    pub fn after(reaction_s: f64, speed_mps: f64, accel_mps2: f64, left_m: f64) -> Self {
        let now_mps = speed_mps.max(0.0);
        let later_mps = (now_mps + accel_mps2 * reaction_s).max(0.0);
        Self { speed_mps: later_mps, left_m: left_m - 0.5 * (now_mps + later_mps) * reaction_s }
    }

    /// Deceleration that stops the wheel at the end [m/s²], positive; computed with at least 5 mm remaining, so that noise
    /// does not command more than the brakes can give.
    pub fn needed_mps2(self) -> f64 {
        self.speed_mps * self.speed_mps / (2.0 * self.left_m.max(LEAST_LEFT_M))
    }
}

/// Largest number of periods of a reaction time: 1.28 s at 50 Hz.
const MOST_PERIODS: usize = 64;

/// The pending accelerations: commanded, not yet acting.
#[derive(Debug, Clone)]
pub struct UnderWay {
    accel_mps2: [f64; MOST_PERIODS],
    next: usize,
    periods: usize,
}

impl UnderWay {
    /// Checks that the commands of a reaction time [s] can be kept.
    ///
    /// # Errors
    /// More periods than are kept.
    pub fn checked(reaction_s: f64, period_s: f64) -> Result<()> {
        if reaction_s / period_s < MOST_PERIODS as f64 + 0.5 {
            return Ok(());
        }
        Err(Error::Setting { field: "reaction_s", value: reaction_s, allowed: "0 to 64 control periods" })
    }

    /// None pending; `reaction_s` is rounded to whole periods, and cut at `MOST_PERIODS`.
    pub fn new(reaction_s: f64, period_s: f64) -> Self {
        // a negative float or NaN becomes 0
        let periods = ((reaction_s / period_s + 0.5) as usize).min(MOST_PERIODS);
        Self { accel_mps2: [0.0; MOST_PERIODS], next: 0, periods }
    }

    /// Adds a command [m/s²].
    pub fn push(&mut self, accel_mps2: f64) {
        if let Some(place) = self.accel_mps2.get_mut(self.next) {
            *place = accel_mps2;
        }
        self.next = if self.next + 1 < self.periods { self.next + 1 } else { 0 };
    }

    /// Mean of the commands of the last reaction time [m/s²].
    pub fn mean_mps2(&self) -> f64 {
        let sum: f64 = self.accel_mps2.iter().take(self.periods).sum();
        if self.periods > 0 { sum / self.periods as f64 } else { 0.0 }
    }
}

/// Remaining path [m]: the localisation, smoothed with the speed.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Left {
    left_m: f64,
}

impl Left {
    /// Share of the difference to the localisation that is corrected per period: its noise is divided by three, and an error of the speed
    /// of 2 % costs 1 mm at 0.6 m/s.
    const SHARE: f64 = 0.2;

    /// At the start of a path of `length_m`.
    pub(crate) fn new(length_m: f64) -> Self {
        Self { left_m: length_m }
    }

    /// One period at `speed_mps`, at the end of which `seen_m` [m] remain by the localisation.
    pub(crate) fn step(&mut self, speed_mps: f64, seen_m: f64, period_s: f64) -> f64 {
        let rolled_m = self.left_m - speed_mps * period_s;
        let left_m = rolled_m + Self::SHARE * (seen_m - rolled_m);
        self.left_m = if left_m.is_finite() { left_m } else { seen_m };
        self.left_m
    }
}

/// Brakes for the end if the speed loop would not.
///
/// The speed loop follows the planned speeds with a lag and an error; if the wheel is heavier or rolls more easily than in the map, it
/// reaches the end too fast. The guard uses only the remaining path: its error shrinks with the distance.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct StoppingGuard {
    /// It acts when stopping at the end needs more than this deceleration [m/s²]. Default 0.5: a quarter above the plan's 0.4, so that it
    /// never acts on a wheel that follows the plan.
    pub from_mps2: f64,
}

impl Default for StoppingGuard {
    fn default() -> Self {
        Self { from_mps2: 0.5 }
    }
}

impl StoppingGuard {
    /// The highest acceleration [m/s²] that still stops at the end; infinity while the guard is inactive.
    pub(crate) fn ceiling_mps2(self, arrival: Arrival) -> f64 {
        let needed_mps2 = arrival.needed_mps2();
        if needed_mps2 > self.from_mps2 { -needed_mps2 } else { f64::INFINITY }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn braking_as_hard_as_needed_stops_at_the_end() {
        let arrival = Arrival::after(0.1, 0.5, -0.2, 0.3);
        assert!((arrival.speed_mps - 0.48).abs() < 1e-12 && (arrival.left_m - 0.251).abs() < 1e-12);
        // s = v²/(2·d)
        assert!((arrival.speed_mps.powi(2) / (2.0 * arrival.needed_mps2()) - 0.251).abs() < 1e-12);
    }

    #[test]
    fn the_guard_is_inactive_on_the_plan_and_active_above_it() {
        let guard = StoppingGuard::default();
        let on_plan = Arrival { speed_mps: 0.4, left_m: 0.2 };
        assert_eq!(guard.ceiling_mps2(on_plan), f64::INFINITY);
        assert!((guard.ceiling_mps2(Arrival { speed_mps: 0.5, ..on_plan }) + 0.625).abs() < 1e-12);
        // it will rest before the command acts: no braking
        assert_eq!(guard.ceiling_mps2(Arrival::after(0.2, 0.1, -2.0, 0.0)), f64::INFINITY);
    }

    #[test]
    fn the_commands_of_the_last_reaction_time_are_pending() {
        let mut under_way = UnderWay::new(0.1, 0.02);
        (0..5).for_each(|k| under_way.push(f64::from(k)));
        assert_eq!(under_way.mean_mps2(), 2.0);
        under_way.push(10.0);
        assert_eq!(under_way.mean_mps2(), 4.0);
        let mut none = UnderWay::new(f64::NAN, 0.02);
        none.push(1.0);
        assert_eq!(none.mean_mps2(), 0.0);
    }

    #[test]
    fn a_noisy_place_is_smoothed_and_a_wrong_speed_tolerated() {
        let mut left = Left::new(1.0);
        let mut largest: f64 = 0.0;
        for k in 1..=100 {
            let true_m = 1.0 - 0.006 * f64::from(k);
            let noise_m = if k % 2 == 0 { 0.003 } else { -0.003 };
            let found_m = left.step(0.3 * 1.02, true_m + noise_m, 0.02);
            largest = largest.max((found_m - true_m).abs());
        }
        // 2 % of 6 mm per period over the share of 0.2 is 0.6 mm, and of noise that alternates a ninth passes
        assert!(largest < 0.0011, "{largest}");
    }

    proptest! {
        #[test]
        fn no_number_makes_it_drive(v in any::<f64>(), a in any::<f64>(), left in any::<f64>()) {
            let ceiling = StoppingGuard::default().ceiling_mps2(Arrival::after(0.1, v, a, left));
            prop_assert!(ceiling < 0.0 || ceiling == f64::INFINITY);
        }
    }
}
