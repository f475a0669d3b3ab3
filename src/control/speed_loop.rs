//! Formula (2): from the speed error to the desired acceleration.
//!
//! e(k) = `v_p` − v;  a = Kp·e(k) + Ki·Σ e(i)·Δt, limited; while the limit (or the drive's) holds, the sum is held (anti-windup by
//! conditional integration. Source: Åström & Hägglund, *Advanced PID Control*, §3.5).

/// Gains and limits of the speed loop.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct SpeedLoopSettings {
    /// Kp [1/s]. Default 3.
    pub proportional_per_s: f64,
    /// Ki [1/s²]. Default 0.5, which is 0.01 per sample at 50 Hz in a sum without Δt.
    pub integral_per_s2: f64,
    /// Lowest desired acceleration [m/s²]. Default −2.5.
    pub min_accel_mps2: f64,
    /// Highest desired acceleration [m/s²]. Default 1.5.
    pub max_accel_mps2: f64,
}

impl Default for SpeedLoopSettings {
    fn default() -> Self {
        Self { proportional_per_s: 3.0, integral_per_s2: 0.5, min_accel_mps2: -2.5, max_accel_mps2: 1.5 }
    }
}

/// The loop's memory.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SpeedLoop {
    /// Σ e·Δt [m].
    sum_m: f64,
}

impl SpeedLoop {
    /// Desired acceleration [m/s²] for an error [m/s], and whether it is at a limit. `saturated`: the drive gave less than was asked for in
    /// the last period. An error that is not a number counts as none.
    pub fn step(&mut self, settings: &SpeedLoopSettings, error_mps: f64, saturated: bool, period_s: f64) -> (f64, bool) {
        let error = if error_mps.is_finite() { error_mps } else { 0.0 };
        let sum = self.sum_m + error * period_s;
        let wanted = settings.proportional_per_s * error + settings.integral_per_s2 * sum;
        let accel = if wanted > settings.max_accel_mps2 {
            settings.max_accel_mps2
        } else if wanted < settings.min_accel_mps2 {
            settings.min_accel_mps2
        } else {
            wanted
        };
        let limited = accel != wanted;
        if !limited && !saturated {
            self.sum_m = sum;
        }
        (accel, limited)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_output_is_proportional_plus_the_sum() {
        let mut state = SpeedLoop::default();
        let settings = SpeedLoopSettings::default();
        let first = state.step(&settings, 0.1, false, 0.02).0;
        let second = state.step(&settings, 0.1, false, 0.02).0;
        assert!((first - (0.3 + 0.5 * 0.002)).abs() < 1e-12);
        assert!((second - (0.3 + 0.5 * 0.004)).abs() < 1e-12);
    }

    #[test]
    fn the_sum_is_held_at_a_limit_and_while_the_drive_gives_less() {
        let mut state = SpeedLoop::default();
        let settings = SpeedLoopSettings::default();
        for _ in 0..100 {
            assert_eq!(state.step(&settings, 9.0, false, 0.02), (1.5, true));
            assert_eq!(state.step(&settings, -9.0, false, 0.02), (-2.5, true));
            state.step(&settings, 0.1, true, 0.02);
        }
        assert_eq!(state, SpeedLoop::default());
        assert_eq!(state.step(&settings, f64::NAN, false, 0.02), (0.0, false));
    }
}
