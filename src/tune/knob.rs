//! The settings that the search changes, each over a ladder of values.
//!
//! The gains belong together: with Kp the speed lags by 1/Kp, which the lag time of the preview makes up for; Ki is on the scale of Kp². So
//! the ladders are those of Kp, of lag time · Kp, and of Ki/Kp².

use crate::controller::ControllerSettings;
use crate::controller::or_word::Or;
use crate::controller::words::Ending;

/// To a multiple of `step`, as the decimal that a person would write.
fn rounded_to(value: f64, step: f64) -> f64 {
    (value / step).round() / (1.0 / step).round()
}

/// A setting, or the ratio of two, that the search changes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Knob {
    /// Kp [1/s].
    Kp,
    /// Lag time of the preview times Kp.
    LagTimesKp,
    /// Ki over Kp².
    KiOverKp2,
    /// Least preview distance [m].
    LeastDistance,
    /// Lowest desired speed near the end [m/s].
    Creep,
    /// End threshold of the plain finish [m].
    EndThreshold,
    /// Deceleration from which the guard brakes, over that of the plan.
    GuardOverPlan,
    /// Acceleration of the plan [m/s²].
    PlanAccel,
    /// Deceleration of the plan [m/s²]; the guard follows.
    PlanDecel,
}

/// Speed and accelerations of the plan, as a share of those of the start.
pub(crate) const SLOWER: [f64; 5] = [0.85, 0.7, 0.55, 0.45, 0.35];
/// The same for a faster plan.
pub(crate) const FASTER: [f64; 4] = [1.15, 1.3, 1.5, 1.75];

impl Knob {
    /// Gains and preview, in the order in which they are tried.
    pub(crate) const GAINS: [Self; 7] =
        [Self::Kp, Self::LagTimesKp, Self::KiOverKp2, Self::Creep, Self::EndThreshold, Self::LeastDistance, Self::GuardOverPlan];

    /// The same, and the accelerations of the plan.
    pub(crate) const ALL: [Self; 9] = [
        Self::Kp,
        Self::LagTimesKp,
        Self::PlanDecel,
        Self::PlanAccel,
        Self::KiOverKp2,
        Self::Creep,
        Self::EndThreshold,
        Self::LeastDistance,
        Self::GuardOverPlan,
    ];

    /// The values that are tried, rising.
    pub(crate) fn ladder(self) -> &'static [f64] {
        match self {
            Self::Kp => &[0.5, 0.7, 1.0, 1.25, 1.5, 2.0, 2.5, 3.0, 3.5, 4.0, 5.0, 6.0, 8.0],
            Self::LagTimesKp => &[0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.1, 1.2, 1.35, 1.5],
            Self::KiOverKp2 => &[0.0, 0.02, 0.055, 0.1, 0.2],
            Self::LeastDistance => &[0.0, 0.005, 0.01, 0.02, 0.03],
            Self::Creep => &[0.02, 0.03, 0.045, 0.06, 0.08, 0.1],
            Self::EndThreshold => &[0.002, 0.004, 0.006, 0.008, 0.011, 0.015, 0.02, 0.03, 0.04],
            Self::GuardOverPlan => &[1.1, 1.25, 1.5, 2.0, 3.0],
            Self::PlanAccel | Self::PlanDecel => &[0.04, 0.06, 0.08, 0.11, 0.14, 0.18, 0.22, 0.28, 0.34, 0.4],
        }
    }

    /// Whether the settings have it: an addition that is off stays off.
    pub(crate) fn applies(self, to: &ControllerSettings) -> bool {
        match self {
            Self::Creep => to.finish.finish == Ending::RollOut,
            Self::EndThreshold => to.finish.finish == Ending::Threshold,
            Self::GuardOverPlan => to.additions.guard_from_mps2.value().is_some(),
            _ => true,
        }
    }

    /// Its value.
    pub(crate) fn get(self, of: &ControllerSettings) -> f64 {
        let kp = of.speed_loop.proportional_per_s.max(1e-3);
        match self {
            Self::Kp => of.speed_loop.proportional_per_s,
            Self::LagTimesKp => of.preview.lag_s * kp,
            Self::KiOverKp2 => of.speed_loop.integral_per_s2 / (kp * kp),
            Self::LeastDistance => of.preview.least_distance_m,
            Self::Creep => of.finish.creep_speed_mps,
            Self::EndThreshold => of.finish.end_threshold_m,
            Self::PlanAccel => of.planning.accel_mps2,
            Self::PlanDecel => of.planning.decel_mps2,
            Self::GuardOverPlan => of.additions.guard_from_mps2.value().unwrap_or(f64::INFINITY) / of.planning.decel_mps2,
        }
    }

    /// The settings with another value; the values that a ratio ties to it follow.
    pub(crate) fn set(self, of: &ControllerSettings, value: f64) -> ControllerSettings {
        let mut to = of.clone();
        match self {
            Self::Kp => {
                let (lag, ki) = (Self::LagTimesKp.get(of), Self::KiOverKp2.get(of));
                to.speed_loop.proportional_per_s = value;
                to = Self::KiOverKp2.set(&Self::LagTimesKp.set(&to, lag), ki);
            }
            Self::LagTimesKp => to.preview.lag_s = rounded_to(value / of.speed_loop.proportional_per_s.max(1e-3), 1e-3).min(3.0),
            Self::KiOverKp2 => to.speed_loop.integral_per_s2 = rounded_to(value * of.speed_loop.proportional_per_s.powi(2), 1e-3).min(50.0),
            Self::LeastDistance => to.preview.least_distance_m = value,
            Self::Creep => to.finish.creep_speed_mps = value,
            Self::EndThreshold => to.finish.end_threshold_m = value,
            Self::PlanAccel => to.planning.accel_mps2 = value,
            Self::PlanDecel => {
                let guard = Self::GuardOverPlan.get(of);
                to.planning.decel_mps2 = value;
                if guard.is_finite() {
                    to = Self::GuardOverPlan.set(&to, guard);
                }
            }
            Self::GuardOverPlan => {
                to.additions.guard_from_mps2 = Or::number(rounded_to(value * of.planning.decel_mps2, 1e-3));
            }
        }
        to
    }

    /// The neighbours of its value on the ladder.
    pub(crate) fn neighbours(self, of: &ControllerSettings) -> impl Iterator<Item = f64> {
        let (ladder, value) = (self.ladder(), self.get(of));
        let below = ladder.iter().rev().find(|v| **v < value * (1.0 - 1e-3) - 1e-9).copied();
        let above = ladder.iter().find(|v| **v > value * (1.0 + 1e-3) + 1e-9).copied();
        below.into_iter().chain(above)
    }
}

/// The settings with a plan of `share` of the speed and of the accelerations; what a guard adds to the deceleration stays in proportion.
pub(crate) fn with_plan(of: &ControllerSettings, share: f64) -> ControllerSettings {
    let mut to = of.clone();
    let scaled = |value: f64, [low, high]: [f64; 2]| rounded_to(share * value, 1e-3).clamp(low, high);
    let guard = Knob::GuardOverPlan.get(of);
    to.planning.cruise_speed_mps = scaled(of.planning.cruise_speed_mps, [0.02, 5.0]);
    to.planning.accel_mps2 = scaled(of.planning.accel_mps2, [0.01, 10.0]);
    to.planning.decel_mps2 = scaled(of.planning.decel_mps2, [0.01, 10.0]);
    to.planning.start_speed_mps = of.planning.start_speed_mps.min(to.planning.cruise_speed_mps);
    if guard.is_finite() { Knob::GuardOverPlan.set(&to, guard) } else { to }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_ratio_ties_follows_and_neighbours_are_the_next_rungs() {
        let start = ControllerSettings::default();
        let faster = Knob::Kp.set(&start, 6.0);
        assert!((faster.preview.lag_s - 0.15).abs() < 1e-9 && (faster.speed_loop.integral_per_s2 - 2.0).abs() < 1e-9);
        assert_eq!(Knob::Kp.neighbours(&start).collect::<Vec<_>>(), [2.5, 3.5]);
        assert_eq!(Knob::LagTimesKp.neighbours(&start).collect::<Vec<_>>(), [0.8, 1.0]);
        let slower = with_plan(&start, 0.5);
        assert_eq!(slower.additions.guard_from_mps2.value(), Some(0.25));
        assert!((slower.planning.cruise_speed_mps - 0.3).abs() < 1e-9);
    }
}
