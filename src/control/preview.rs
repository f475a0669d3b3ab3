//! Formula (1): how far ahead the controller looks.

/// `d_p = v·t_lag + ½·a·t_lag² + d_min`, never less than `d_min`.
///
/// What the vehicle does now was commanded `t_lag` ago; so the speed it is asked for is the one planned where it will be.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Preview {
    /// Preset lag time [s]. Default 0.30.
    pub lag_s: f64,
    /// Preset minimum distance [m]. Default 0.01.
    pub min_m: f64,
}

impl Default for Preview {
    fn default() -> Self {
        Self { lag_s: 0.30, min_m: 0.01 }
    }
}

impl Preview {
    /// Preview distance [m] at speed v [m/s] and acceleration a [m/s²], gear frame. The minimum when either is not a number.
    pub fn distance_m(self, speed_mps: f64, accel_mps2: f64) -> f64 {
        let ahead = speed_mps * self.lag_s + 0.5 * accel_mps2 * self.lag_s * self.lag_s;
        self.min_m + if ahead > 0.0 { ahead } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_preview_is_the_lag_times_the_speed_and_never_less_than_its_minimum() {
        let preview = Preview::default();
        assert!((preview.distance_m(0.6, 0.4) - (0.18 + 0.018 + 0.01)).abs() < 1e-12);
        assert_eq!(preview.distance_m(0.1, -2.5), 0.01);
        assert_eq!(preview.distance_m(f64::NAN, 0.0), 0.01);
    }
}
