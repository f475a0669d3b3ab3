//! Lateral: turns the front wheel to its angle, holds it, returns it, and monitors the steering.

use crate::angle::RAD_PER_DEG;
use crate::messages::{AngleStatus, LateralTask, SteeringFault};

/// Tolerances and times of the lateral module.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct LateralSettings {
    /// Control period [s]. Default 0.02.
    pub period_s: f64,
    /// The wheel is at its target within this [rad]. Default 1.5°: above the bias and noise of a usual steering sensor.
    pub tolerance_rad: f64,
    /// … for this long [s], so that it is not only passing through. Default 0.1.
    pub settle_s: f64,
    /// While driving, the wheel is lost if it is further than this [rad] from its target. Default 5°.
    pub lost_rad: f64,
    /// Largest plausible angle in either direction [rad]. Default 110°: a usual stop is at 100°.
    pub plausible_rad: f64,
    /// An angle that moves less than this [rad] … Default 0.8°, above the noise.
    pub stuck_rad: f64,
    /// … for this long [s] away from its target is stuck. Default 1.
    pub stuck_s: f64,
    /// Longest time to a target [s]. Default 10: 180° at 30°/s takes 6 s, the rest is reserve.
    pub slow_s: f64,
}

impl Default for LateralSettings {
    fn default() -> Self {
        Self {
            period_s: 0.02,
            tolerance_rad: 1.5 * RAD_PER_DEG,
            settle_s: 0.1,
            lost_rad: 5.0 * RAD_PER_DEG,
            plausible_rad: 110.0 * RAD_PER_DEG,
            stuck_rad: 0.8 * RAD_PER_DEG,
            stuck_s: 1.0,
            slow_s: 10.0,
        }
    }
}

/// The lateral module with its state.
#[derive(Debug, Clone)]
pub(crate) struct Lateral {
    settings: LateralSettings,
    task: LateralTask,
    target_rad: f64,
    /// Wheel angle at its last movement [rad].
    still_at_rad: f64,
    still_s: f64,
    under_way_s: f64,
    settled_s: f64,
    reached: bool,
}

impl Lateral {
    /// A module at rest, its target straight ahead.
    pub(crate) fn new(settings: LateralSettings) -> Self {
        let mut start = Self {
            settings,
            task: LateralTask::Rest,
            target_rad: 0.0,
            still_at_rad: f64::NAN,
            still_s: 0.0,
            under_way_s: 0.0,
            settled_s: 0.0,
            reached: false,
        };
        start.forget();
        start
    }

    fn forget(&mut self) {
        (self.still_at_rad, self.still_s, self.under_way_s, self.settled_s, self.reached) = (f64::NAN, 0.0, 0.0, 0.0, false);
    }

    /// One period: the task, the measured angle [rad] → the target angle [rad] and the wheel's status.
    pub(crate) fn step(&mut self, task: LateralTask, angle_rad: f64) -> (f64, AngleStatus) {
        if task != self.task {
            self.task = task;
            self.forget();
            match task {
                LateralTask::Hold(target) | LateralTask::Restore(target) if target.is_finite() => self.target_rad = target,
                LateralTask::Rest => self.target_rad = 0.0,
                LateralTask::Hold(_) | LateralTask::Restore(_) | LateralTask::Freeze => {}
            }
        }
        (self.target_rad, self.watch(angle_rad))
    }

    fn watch(&mut self, angle_rad: f64) -> AngleStatus {
        let settings = self.settings;
        if angle_rad.is_nan() || angle_rad.abs() > settings.plausible_rad {
            return AngleStatus::Fault(SteeringFault::Implausible);
        }
        let off_rad = (angle_rad - self.target_rad).abs();
        if self.reached {
            let lost = off_rad > settings.lost_rad;
            return if lost { AngleStatus::Fault(SteeringFault::Lost) } else { AngleStatus::Reached };
        }
        self.under_way_s += settings.period_s;
        if off_rad <= settings.tolerance_rad {
            self.settled_s += settings.period_s;
            self.still_s = 0.0;
        } else {
            self.settled_s = 0.0;
            let moved = self.still_at_rad.is_nan() || (angle_rad - self.still_at_rad).abs() >= settings.stuck_rad;
            self.still_s = if moved { 0.0 } else { self.still_s + settings.period_s };
            if moved {
                self.still_at_rad = angle_rad;
            }
        }
        // half a period: sums of 0.02 s differ from a round number by rounding
        let over = |time_s: f64, limit_s: f64| time_s >= limit_s - 0.5 * settings.period_s;
        if over(self.settled_s, settings.settle_s) {
            self.reached = true;
            AngleStatus::Reached
        } else if over(self.still_s, settings.stuck_s) {
            AngleStatus::Fault(SteeringFault::Stuck)
        } else if over(self.under_way_s, settings.slow_s) {
            AngleStatus::Fault(SteeringFault::TooSlow)
        } else {
            AngleStatus::InProgress
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TARGET: f64 = 90.0 * RAD_PER_DEG;

    /// Steps a wheel at `angle_deg(t)` until the status is not "in progress"; also returns the elapsed time [s].
    fn outcome(task: LateralTask, angle_deg: impl Fn(f64) -> f64) -> (f64, AngleStatus) {
        let mut lateral = Lateral::new(LateralSettings::default());
        for k in 0..2000 {
            let t_s = f64::from(k) * 0.02;
            let (_, status) = lateral.step(task, angle_deg(t_s) * RAD_PER_DEG);
            if status != AngleStatus::InProgress {
                return (t_s, status);
            }
        }
        (f64::INFINITY, AngleStatus::InProgress)
    }

    #[test]
    fn a_wheel_that_turns_at_sixty_degrees_per_second_arrives() {
        let (t_s, status) = outcome(LateralTask::Hold(TARGET), |t| (60.0 * t).min(90.0));
        assert_eq!(status, AngleStatus::Reached);
        assert!((1.5..1.7).contains(&t_s), "{t_s}");
    }

    #[test]
    fn a_wheel_that_passes_through_has_not_arrived() {
        let (_, status) = outcome(LateralTask::Restore(0.0), |t| 60.0 - 60.0 * t);
        assert_eq!(status, AngleStatus::Fault(SteeringFault::Implausible));
    }

    #[test]
    fn a_stuck_wheel_is_reported_after_its_time_even_with_noise() {
        let noisy = |t: f64| 40.0 + 0.3 * (37.0 * t).sin();
        let (t_s, status) = outcome(LateralTask::Hold(TARGET), noisy);
        assert_eq!(status, AngleStatus::Fault(SteeringFault::Stuck));
        assert!((0.9..1.2).contains(&t_s), "{t_s}");
    }

    #[test]
    fn a_wheel_that_creeps_is_too_slow_and_one_outside_its_range_implausible() {
        assert_eq!(outcome(LateralTask::Hold(TARGET), |t| 2.0 * t).1, AngleStatus::Fault(SteeringFault::TooSlow));
        assert_eq!(outcome(LateralTask::Hold(TARGET), |_| 170.0), (0.0, AngleStatus::Fault(SteeringFault::Implausible)));
        assert_eq!(outcome(LateralTask::Rest, |_| f64::NAN), (0.0, AngleStatus::Fault(SteeringFault::Implausible)));
    }

    #[test]
    fn a_held_wheel_that_leaves_its_angle_is_lost() {
        let mut lateral = Lateral::new(LateralSettings::default());
        (0..20).for_each(|_| {
            lateral.step(LateralTask::Hold(TARGET), TARGET);
        });
        assert_eq!(lateral.step(LateralTask::Hold(TARGET), 86.0 * RAD_PER_DEG).1, AngleStatus::Reached);
        assert_eq!(lateral.step(LateralTask::Hold(TARGET), 84.0 * RAD_PER_DEG).1, AngleStatus::Fault(SteeringFault::Lost));
    }

    #[test]
    fn the_target_follows_the_task_and_stays_when_frozen() {
        let mut lateral = Lateral::new(LateralSettings::default());
        assert_eq!(lateral.step(LateralTask::Rest, 0.0).0, 0.0);
        assert_eq!(lateral.step(LateralTask::Hold(-TARGET), 0.0).0, -TARGET);
        assert_eq!(lateral.step(LateralTask::Freeze, 0.0).0, -TARGET);
        assert_eq!(lateral.step(LateralTask::Restore(0.3), 0.0).0, 0.3);
        assert_eq!(lateral.step(LateralTask::Restore(f64::NAN), 0.0).0, 0.3, "an angle that is none changes nothing");
    }
}
