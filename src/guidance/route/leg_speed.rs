//! The speed along a leg of several segments, each with its set speed.
//!
//! The published rule: the start speed of a segment that continues in the same direction is its own set speed, its end speed that of the next
//! one; only at corners with a turn the fixed small speeds hold. So the speed changes within the last decelerating distance before a joint.
//! Two departures keep the planned accelerations: a ramp is longer than its distance if it would need more, and the speed at a joint is
//! lower than the set speed where the segments before or after it are too short to reach it or to slow down from it.

use crate::control::Error;
use crate::control::numeric::sqrt;
use crate::guidance::route::segment_speed::SegmentSpeed;
use serde::Serialize;

/// Speeds of a leg.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct LegSpeed {
    /// Length of each segment [m] with its speeds.
    segments: Vec<(f64, SegmentSpeed)>,
}

/// Half the change of the squared speed per metre [m/s²] of a ramp with the given speeds and distance.
fn ramp_mps2(from_mps: f64, to_mps: f64, over_m: f64) -> f64 {
    0.5 * (to_mps * to_mps - from_mps * from_mps).abs() / over_m
}

impl LegSpeed {
    /// The speeds of segments given by length [m] and set speed [m/s], `None` for that of `usual`, which also holds the speeds at the leg's
    /// ends and the distances of the ramps.
    ///
    /// # Errors
    /// A set speed outside 0.05 to 5 m/s, or other numbers of `usual` out of their range.
    pub(crate) fn new(segments: &[(f64, Option<f64>)], usual: &SegmentSpeed) -> Result<Self, Error> {
        usual.checked()?;
        let rise = ramp_mps2(usual.start_mps, usual.cruise_mps, usual.accelerating_m).max(0.05);
        let fall = ramp_mps2(usual.cruise_mps, usual.switch_mps, usual.decelerating_m).max(0.05);
        let set: Vec<f64> = segments.iter().map(|s| s.1.unwrap_or(usual.cruise_mps)).collect();
        // speeds at the starts of the segments and at the end of the last one
        let mut at: Vec<f64> = set.clone();
        if let Some(&first) = set.first() {
            at[0] = usual.start_mps.min(first);
            at.push(usual.switch_mps.min(set[set.len() - 1]));
        }
        for k in 0..segments.len() {
            at[k + 1] = at[k + 1].min(sqrt(at[k] * at[k] + 2.0 * rise * segments[k].0));
        }
        for k in (0..segments.len()).rev() {
            at[k] = at[k].min(sqrt(at[k + 1] * at[k + 1] + 2.0 * fall * segments[k].0));
        }
        let speed = |k: usize| {
            let (start_mps, cruise_mps, switch_mps) = (at[k].min(set[k]), set[k], at[k + 1]);
            let longer = |from: f64, to: f64, over_m: f64, most: f64| over_m.max(ramp_mps2(from, to, 1.0) / most);
            SegmentSpeed {
                start_mps,
                accelerating_m: longer(start_mps, cruise_mps, usual.accelerating_m, rise),
                cruise_mps,
                decelerating_m: longer(cruise_mps, switch_mps, usual.decelerating_m, if switch_mps > cruise_mps { rise } else { fall }),
                switch_mps,
            }
            .checked()
        };
        let planned: Result<Vec<_>, Error> = (0..segments.len()).map(|k| Ok((segments[k].0, speed(k)?))).collect();
        Ok(Self { segments: planned? })
    }

    /// Speed [m/s] at `s_m` from the start of the leg. The speed of its end is reached `stop_m` before the end, at most half of the last
    /// segment before it, and kept.
    pub(crate) fn speed_at(&self, s_m: f64, stop_m: f64) -> f64 {
        let mut from_m = 0.0;
        for (k, (length_m, speed)) in self.segments.iter().enumerate() {
            let last = k + 1 == self.segments.len();
            if s_m < from_m + length_m || last {
                let stop_m = if last { stop_m.min(0.5 * length_m) } else { 0.0 };
                return speed.speed_at(s_m - from_m, length_m - stop_m);
            }
            from_m += length_m;
        }
        0.0
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn leg(segments: &[(f64, Option<f64>)]) -> LegSpeed {
        LegSpeed::new(segments, &SegmentSpeed::default()).unwrap()
    }

    #[test]
    fn at_a_joint_the_next_segments_set_speed_is_reached_and_at_corners_the_fixed_speeds_hold() {
        let leg = leg(&[(6.0, None), (4.0, Some(0.4)), (6.0, Some(0.9))]);
        let near = |s: f64, v: f64| assert!((leg.speed_at(s, 0.0) - v).abs() < 1e-9, "{s} m: {} for {v}", leg.speed_at(s, 0.0));
        near(0.0, 0.15);
        near(3.0, 0.8);
        near(5.0, 0.8);
        near(6.0, 0.4);
        near(8.0, 0.4);
        near(10.0, 0.9);
        near(14.0, 0.9);
        near(16.0, 0.12);
        // with a stopping distance the speed of the corner is kept over it
        assert!((leg.speed_at(15.9, 0.2) - 0.12).abs() < 1e-9 && (leg.speed_at(15.8, 0.2) - 0.12).abs() < 1e-9);
        assert!(leg.speed_at(15.7, 0.2) > 0.12 && (leg.speed_at(10.0, 0.2) - 0.9).abs() < 1e-9);
        // the ramp lies before the joint
        assert!(leg.speed_at(5.5, 0.0) < 0.8 && leg.speed_at(5.5, 0.0) > 0.4 && leg.speed_at(9.9, 0.0) > 0.4);
    }

    #[test]
    fn equal_set_speeds_give_one_speed_over_the_joint() {
        let (one, two) = (leg(&[(8.0, None)]), leg(&[(4.0, None), (4.0, Some(0.8))]));
        assert!((0..=80).all(|k| (one.speed_at(0.1 * f64::from(k), 0.0) - two.speed_at(0.1 * f64::from(k), 0.0)).abs() < 1e-9));
    }

    #[test]
    fn no_ramp_needs_more_than_the_planned_accelerations() {
        for segments in [
            vec![(6.0, Some(2.0)), (0.3, Some(0.1)), (3.0, Some(1.5))],
            vec![(0.2, None), (0.2, None), (0.2, Some(0.3)), (0.2, None)],
            vec![(3.0, Some(0.05)), (1.0, Some(1.0)), (0.5, Some(0.2))],
        ] {
            let leg = leg(&segments);
            let length: f64 = segments.iter().map(|s| s.0).sum();
            let steps = (length / 0.005) as usize;
            for k in 0..steps {
                let (from, to) = (leg.speed_at(0.005 * k as f64, 0.0), leg.speed_at(0.005 * (k + 1) as f64, 0.0));
                let accel = 0.5 * (to * to - from * from) / 0.005;
                assert!((-0.3129..=0.386).contains(&accel), "{segments:?} at {k}: {accel}");
            }
        }
    }

    #[test]
    fn a_set_speed_out_of_range_is_an_error() {
        let error = LegSpeed::new(&[(5.0, Some(7.0))], &SegmentSpeed::default()).unwrap_err();
        assert_eq!(error.to_string(), "cruise_mps is 7; allowed: 0.05 to 5");
    }
}
