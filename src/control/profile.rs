//! The speed along the arc: a trapezoid over time, a triangle when the arc is short.
//!
//! `v(s)² = min(v₀² + 2·a·s, v_c², 2·d·(S − s))`: from the start speed v₀ with acceleration a, cruise at `v_c`, down to 0 at the end S with
//! deceleration d. The smallest of the three is the trapezoid, and the triangle where the cruise speed is not reached.

use crate::numeric::sqrt;
use crate::{Error, Result};

/// Speeds and accelerations of the plan.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Profile {
    /// Speed of the first waypoint [m/s]. Default 0.1: a standing vehicle is asked to move.
    pub start_mps: f64,
    /// Highest speed [m/s]. Default 0.6.
    pub cruise_mps: f64,
    /// Acceleration [m/s²]. Default 0.4.
    pub accel_mps2: f64,
    /// Deceleration [m/s²], positive. Default 0.4.
    pub decel_mps2: f64,
}

impl Default for Profile {
    fn default() -> Self {
        Self { start_mps: 0.1, cruise_mps: 0.6, accel_mps2: 0.4, decel_mps2: 0.4 }
    }
}

impl Profile {
    /// Checks that every number is finite and possible.
    ///
    /// # Errors
    /// The first that is not.
    pub fn checked(self) -> Result<Self> {
        let check = |field, value: f64, allowed, good: bool| if good { Ok(()) } else { Err(Error::Setting { field, value, allowed }) };
        check("start_mps", self.start_mps, "above 0 to 1", self.start_mps > 0.0 && self.start_mps <= 1.0)?;
        check("cruise_mps", self.cruise_mps, "start_mps to 5", self.cruise_mps >= self.start_mps && self.cruise_mps <= 5.0)?;
        check("accel_mps2", self.accel_mps2, "0.01 to 10", (0.01..=10.0).contains(&self.accel_mps2))?;
        check("decel_mps2", self.decel_mps2, "0.01 to 10", (0.01..=10.0).contains(&self.decel_mps2)).map(|()| self)
    }

    /// Speed [m/s] at `arc_m` of an arc of `length_m`; 0 at and past the end.
    pub fn speed_at(&self, arc_m: f64, length_m: f64) -> f64 {
        let rising = self.start_mps * self.start_mps + 2.0 * self.accel_mps2 * arc_m.max(0.0);
        let falling = 2.0 * self.decel_mps2 * (length_m - arc_m).max(0.0);
        sqrt(rising.min(self.cruise_mps * self.cruise_mps).min(falling))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_arc_has_a_trapezoid_and_a_short_one_a_triangle() {
        let profile = Profile::default();
        let peak = |length_m: f64| (0..=1000).map(|k| profile.speed_at(f64::from(k) * length_m / 1000.0, length_m)).fold(0.0, f64::max);
        assert!((peak(1.445) - 0.6).abs() < 1e-12);
        // v² = v₀² + 2as = 2d(S − s) at the top: v² = (v₀² + 2aS)/2 for a = d
        assert!((peak(0.48) - f64::midpoint(0.01, 0.8 * 0.48).sqrt()).abs() < 1e-3);
        assert_eq!(profile.speed_at(1.445, 1.445), 0.0);
        assert!((profile.speed_at(0.0, 1.445) - 0.1).abs() < 1e-12);
    }
}
