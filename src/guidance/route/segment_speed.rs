//! The speed along one segment: from the start speed over an accelerating distance to the cruise speed, and over a decelerating distance down to
//! the speed of the switch-over to the next segment.
//!
//! Acceleration is constant on each part, so the square of the speed is linear in the distance. A segment shorter than both distances together
//! is split into halves: one half accelerates as planned, the other decelerates as planned, and the smaller of both speeds is used. It
//! peaks in the middle if both distances are equal. The acceleration is never larger than on a long segment.

use crate::control::Error;
use crate::control::numeric::sqrt;
use serde::Serialize;

/// Speeds [m/s] and distances [m] of a segment, front wheel.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub(crate) struct SegmentSpeed {
    /// Speed at the start. Default 0.15: a resting vehicle must start.
    pub start_mps: f64,
    /// Distance from start to cruise speed. Default 0.8.
    pub accelerating_m: f64,
    /// Cruise speed. Default 0.8.
    pub cruise_mps: f64,
    /// Distance from cruise to switch-over speed. Default 1.0.
    pub decelerating_m: f64,
    /// Speed at the end, where the next segment takes over. Default 0.12.
    pub switch_mps: f64,
}

impl Default for SegmentSpeed {
    fn default() -> Self {
        Self { start_mps: 0.15, accelerating_m: 0.8, cruise_mps: 0.8, decelerating_m: 1.0, switch_mps: 0.12 }
    }
}

impl SegmentSpeed {
    /// Checks every number.
    ///
    /// # Errors
    /// The first invalid one.
    pub(crate) fn checked(self) -> Result<Self, Error> {
        let check = |field, value: f64, allowed, good: bool| if good { Ok(()) } else { Err(Error::Setting { field, value, allowed }) };
        check("cruise_mps", self.cruise_mps, "0.05 to 5", (0.05..=5.0).contains(&self.cruise_mps))?;
        check("start_mps", self.start_mps, "above 0 to cruise_mps", self.start_mps > 0.0 && self.start_mps <= self.cruise_mps)?;
        check("switch_mps", self.switch_mps, "above 0 to cruise_mps", self.switch_mps > 0.0 && self.switch_mps <= self.cruise_mps)?;
        check("accelerating_m", self.accelerating_m, "0.01 to 1000", (0.01..=1000.0).contains(&self.accelerating_m))?;
        check("decelerating_m", self.decelerating_m, "0.01 to 1000", (0.01..=1000.0).contains(&self.decelerating_m)).map(|()| self)
    }

    /// Speed [m/s] at `s_m` of a segment of `length_m`; the start speed before it, the switch-over speed past it.
    pub(crate) fn speed_at(&self, s_m: f64, length_m: f64) -> f64 {
        let (start, cruise, switch) =
            (self.start_mps * self.start_mps, self.cruise_mps * self.cruise_mps, self.switch_mps * self.switch_mps);
        let rising = start + (cruise - start) * (s_m / self.accelerating_m).max(0.0);
        let falling = switch + (cruise - switch) * ((length_m - s_m) / self.decelerating_m).max(0.0);
        sqrt(rising.min(falling).min(cruise))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_segment_cruises_and_a_short_one_is_split_in_halves() {
        let plan = SegmentSpeed { accelerating_m: 1.0, decelerating_m: 1.0, switch_mps: 0.15, ..SegmentSpeed::default() };
        assert!((plan.speed_at(0.0, 5.0) - 0.15).abs() < 1e-12 && (plan.speed_at(5.0, 5.0) - 0.15).abs() < 1e-12);
        assert!((plan.speed_at(1.0, 5.0) - 0.8).abs() < 1e-12 && (plan.speed_at(4.0, 5.0) - 0.8).abs() < 1e-12);
        // 1.2 m: the peak is in the middle, v² = 0.15² + (0.8² − 0.15²)·0.6
        let peak = (0.0225_f64 + 0.6175 * 0.6).sqrt();
        assert!((plan.speed_at(0.6, 1.2) - peak).abs() < 1e-12);
        assert!(plan.speed_at(0.5, 1.2) < peak && plan.speed_at(0.7, 1.2) < peak);
    }

    #[test]
    fn no_slow_down_where_the_next_segment_continues() {
        let plan = SegmentSpeed { switch_mps: 0.8, ..SegmentSpeed::default() };
        assert!((plan.speed_at(4.99, 5.0) - 0.8).abs() < 1e-12);
    }
}
