//! Where the wheel will be once a command acts, and how hard it then has to brake to stop at the end.
//!
//! What is commanded now acts `reaction_s` later. By then a wheel of speed v under the acceleration a of the last command does
//! v' = max(v + a·T, 0) and has covered ½·(v + v')·T; with s' left it needs the deceleration v'²/(2·s') to stop at the end. This is the classical
//! stopping distance; the step ahead over the dead time is Smith's predictor in its simplest form (Source: Åström & Hägglund, *Advanced PID
//! Control*, §8.2).

use serde::Serialize;

/// The wheel at the time when a command that is given now acts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Arrival {
    /// Speed [m/s], 0 or more.
    pub(super) speed_mps: f64,
    /// What is left of the path [m]; negative past the end.
    pub(super) left_m: f64,
}

impl Arrival {
    /// From the speed [m/s], the acceleration [m/s²] of the last command, what is left [m], and the reaction time [s].
    pub(super) fn after(reaction_s: f64, speed_mps: f64, accel_mps2: f64, left_m: f64) -> Self {
        let now_mps = speed_mps.max(0.0);
        let later_mps = (now_mps + accel_mps2 * reaction_s).max(0.0);
        Self { speed_mps: later_mps, left_m: left_m - 0.5 * (now_mps + later_mps) * reaction_s }
    }

    /// Deceleration that stops the wheel at the end [m/s²], positive; as if a millimetre were left where less is.
    pub(super) fn needed_mps2(self) -> f64 {
        self.speed_mps * self.speed_mps / (2.0 * self.left_m.max(1e-3))
    }
}

/// Brakes for the end when the speed loop would not.
///
/// The speed loop follows the planned speeds with a lag and an error; where the wheel is heavier or rolls easier than the map says, it comes to
/// the end too fast. The guard looks at what is left alone: its error shrinks with the distance.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct StoppingGuard {
    /// It acts when stopping at the end needs more than this deceleration [m/s²]. Default 0.5: a quarter above the plan's 0.4, so that a wheel
    /// that follows the plan never feels it.
    pub from_mps2: f64,
}

impl Default for StoppingGuard {
    fn default() -> Self {
        Self { from_mps2: 0.5 }
    }
}

impl StoppingGuard {
    /// The highest acceleration [m/s²] that still stops at the end; infinity while the guard need not act.
    pub(super) fn ceiling_mps2(self, arrival: Arrival) -> f64 {
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
    fn the_guard_sleeps_on_the_plan_and_wakes_above_it() {
        let guard = StoppingGuard::default();
        let on_plan = Arrival { speed_mps: 0.4, left_m: 0.2 };
        assert_eq!(guard.ceiling_mps2(on_plan), f64::INFINITY);
        assert!((guard.ceiling_mps2(Arrival { speed_mps: 0.5, ..on_plan }) + 0.625).abs() < 1e-12);
        // it will stand before the command acts: nothing to brake
        assert_eq!(guard.ceiling_mps2(Arrival::after(0.2, 0.1, -2.0, 0.0)), f64::INFINITY);
    }

    proptest! {
        #[test]
        fn no_number_makes_it_drive(v in any::<f64>(), a in any::<f64>(), left in any::<f64>()) {
            let ceiling = StoppingGuard::default().ceiling_mps2(Arrival::after(0.1, v, a, left));
            prop_assert!(ceiling < 0.0 || ceiling == f64::INFINITY);
        }
    }
}
