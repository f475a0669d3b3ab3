//! The speed along one segment: from the start speed over an accelerating distance to the set speed, and over a decelerating distance to the
//! speed at its end.
//!
//! Acceleration is constant on each part, so the square of the speed is linear in the distance. A segment shorter than both distances
//! together has S/2 of each. Its ramps are scaled so that they meet in the middle, at the smaller one of the two speeds that the planned
//! accelerations reach there: neither half accelerates more than on a long segment.

use crate::control::Error;
use crate::control::numeric::sqrt;
use serde::Serialize;

/// Speeds [m/s] and distances [m] of a segment, front wheel.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct SegmentSpeed {
    /// Speed at the start. Default 0.15: a resting vehicle must start.
    pub start_mps: f64,
    /// Distance from start to set speed. Default 0.8.
    pub accelerating_m: f64,
    /// Set speed. Default 0.8.
    pub cruise_mps: f64,
    /// Distance from set speed to the speed at the end. Default 1.0.
    pub decelerating_m: f64,
    /// Speed at the end, where the next segment takes over; it may be above the set speed. Default 0.12.
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
        check("switch_mps", self.switch_mps, "above 0 to 5", self.switch_mps > 0.0 && self.switch_mps <= 5.0)?;
        check("accelerating_m", self.accelerating_m, "0.01 to 1000", (0.01..=1000.0).contains(&self.accelerating_m))?;
        check("decelerating_m", self.decelerating_m, "0.01 to 1000", (0.01..=1000.0).contains(&self.decelerating_m)).map(|()| self)
    }

    /// Speed [m/s] at `s_m` of a segment of `length_m`; the start speed before it, the end's speed past it.
    pub(crate) fn speed_at(&self, s_m: f64, length_m: f64) -> f64 {
        let (start, end) = (self.start_mps * self.start_mps, self.switch_mps * self.switch_mps);
        let (mut peak, mut rise_m, mut fall_m) = (self.cruise_mps * self.cruise_mps, self.accelerating_m, self.decelerating_m);
        if length_m < rise_m + fall_m {
            let half_m = 0.5 * length_m;
            let risen = start + (peak - start) * half_m / rise_m;
            let fallen = end + (peak - end) * half_m / fall_m;
            // not below the mean of both ends: otherwise one half would brake harder than the whole needs
            peak = risen.min(fallen).max(0.5 * (start + end));
            (rise_m, fall_m) = (half_m, half_m);
        }
        let left_m = length_m - s_m;
        let share = |of_m: f64, ramp_m: f64| match of_m {
            // a place that is not a number has the speed of the end
            of_m if of_m > 0.0 && of_m < ramp_m => of_m / ramp_m,
            of_m if of_m > 0.0 => 1.0,
            _ => 0.0,
        };
        sqrt(if left_m < fall_m { end + (peak - end) * share(left_m, fall_m) } else { start + (peak - start) * share(s_m, rise_m) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_segment_cruises() {
        let plan = SegmentSpeed { accelerating_m: 1.0, decelerating_m: 1.0, switch_mps: 0.15, ..SegmentSpeed::default() };
        assert!((plan.speed_at(0.0, 5.0) - 0.15).abs() < 1e-12 && (plan.speed_at(5.0, 5.0) - 0.15).abs() < 1e-12);
        assert!((plan.speed_at(1.0, 5.0) - 0.8).abs() < 1e-12 && (plan.speed_at(4.0, 5.0) - 0.8).abs() < 1e-12);
        assert!((plan.speed_at(-1.0, 5.0) - 0.15).abs() < 1e-12 && (plan.speed_at(6.0, 5.0) - 0.15).abs() < 1e-12);
    }

    #[test]
    fn a_short_segment_peaks_in_its_middle_with_unequal_distances_too() {
        let plan = SegmentSpeed::default();
        // 1.2 m of 0.8 m and 1.0 m: rising it reaches 0.0225 + 0.6175·0.6/0.8, falling it comes from 0.0144 + 0.6256·0.6/1.0: the smaller one
        let peak = (0.0144_f64 + 0.6256 * 0.6).sqrt();
        assert!((plan.speed_at(0.6, 1.2) - peak).abs() < 1e-12, "{} for {peak}", plan.speed_at(0.6, 1.2));
        for k in 1..=60 {
            let off_m = 0.01 * f64::from(k);
            assert!(plan.speed_at(0.6 - off_m, 1.2) < peak && plan.speed_at(0.6 + off_m, 1.2) < peak, "{off_m}");
        }
        // constant acceleration on each half, neither more than planned: half the slope of the speed's square
        let slope = |s: f64| 0.5 * (plan.speed_at(s + 0.01, 1.2).powi(2) - plan.speed_at(s, 1.2).powi(2)) / 0.01;
        assert!((slope(0.1) - slope(0.5)).abs() < 1e-9 && (slope(0.7) - slope(1.1)).abs() < 1e-9);
        assert!(slope(0.3) <= 0.6175 / 1.6 && (slope(0.9) + 0.6256 / 2.0).abs() < 1e-9);
        assert!((plan.speed_at(0.0, 1.2) - 0.15).abs() < 1e-12 && (plan.speed_at(1.2, 1.2) - 0.12).abs() < 1e-12);
    }

    #[test]
    fn no_slow_down_where_the_next_segment_continues_and_a_ramp_to_a_faster_or_slower_one() {
        let plan = SegmentSpeed { start_mps: 0.8, switch_mps: 0.8, ..SegmentSpeed::default() };
        assert!((0..=50).all(|k| (plan.speed_at(0.1 * f64::from(k), 5.0) - 0.8).abs() < 1e-12));
        // shorter than both distances as well
        assert!((0..=12).all(|k| (plan.speed_at(0.1 * f64::from(k), 1.2) - 0.8).abs() < 1e-12));
        for end_mps in [0.4_f64, 1.2] {
            let plan = SegmentSpeed { switch_mps: end_mps, ..plan };
            assert!((plan.speed_at(4.0, 5.0) - 0.8).abs() < 1e-12 && (plan.speed_at(5.0, 5.0) - end_mps).abs() < 1e-12);
            let middle = (0.5 * (0.64 + end_mps * end_mps)).sqrt();
            assert!((plan.speed_at(4.5, 5.0) - middle).abs() < 1e-12);
        }
    }
}
