//! The steering (EPS): wheel angle target → rate limit, first-order lag, faults → wheel angle.
//!
//! `δ̇ = clamp((δ_target − δ)/T, ±rate)`, solved exactly over a step: a ramp while the limit is active, then an exponential.

use crate::sim::error::{Result, within};
use crate::units::RAD_PER_DEG;
use serde::{Deserialize, Serialize};

/// Settings of the steering.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SteeringSettings {
    /// Largest rate of the wheel angle [°/s]. Default 60.
    pub rate_deg_s: f64,
    /// Time constant near the target [s]. Default 0.08.
    pub lag_s: f64,
    /// Mechanical stop [°], in both directions. Default 100.
    pub limit_deg: f64,
}

impl Default for SteeringSettings {
    fn default() -> Self {
        Self { rate_deg_s: 60.0, lag_s: 0.08, limit_deg: 100.0 }
    }
}

impl SteeringSettings {
    /// Checks every number.
    ///
    /// # Errors
    /// The first field that is out of its range.
    pub fn check(&self) -> Result<()> {
        within("steering.rate_deg_s", self.rate_deg_s, 0.1..=3600.0, "0.1 to 3600")?;
        within("steering.lag_s", self.lag_s, 0.0..=5.0, "0 to 5")?;
        within("steering.limit_deg", self.limit_deg, 1.0..=180.0, "1 to 180")
    }
}

/// Wheel angle [rad] over one step.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct AngleStep {
    /// At its start.
    pub start_rad: f64,
    /// Half way.
    pub mid_rad: f64,
    /// At its end.
    pub end_rad: f64,
}

/// The steering's state.
#[derive(Debug, Clone)]
pub(crate) struct Steering {
    rate_rad_s: f64,
    lag_s: f64,
    limit_rad: f64,
    angle_rad: f64,
    stuck: bool,
    rate_factor: f64,
    half_step_s: f64,
    half_step_decay: f64,
}

/// Within this distance the wheel is set exactly to its target [rad]: otherwise the exponential would never end.
const ARRIVED_RAD: f64 = 1e-7;

impl Steering {
    /// A wheel straight ahead, stepped every `step_s`.
    ///
    /// # Errors
    /// A setting is out of its range.
    pub(crate) fn new(settings: &SteeringSettings, step_s: f64) -> Result<Self> {
        settings.check()?;
        let half_step_s = 0.5 * step_s;
        Ok(Self {
            rate_rad_s: settings.rate_deg_s * RAD_PER_DEG,
            lag_s: settings.lag_s,
            limit_rad: settings.limit_deg * RAD_PER_DEG,
            angle_rad: 0.0,
            stuck: false,
            rate_factor: 1.0,
            half_step_s,
            half_step_decay: if settings.lag_s > 0.0 { (-half_step_s / settings.lag_s).exp() } else { 0.0 },
        })
    }

    /// Sets the wheel angle directly (limited to the mechanical stop).
    pub(crate) fn place(&mut self, angle_rad: f64) {
        self.angle_rad = angle_rad.clamp(-self.limit_rad, self.limit_rad);
    }

    /// Locks or releases the wheel.
    pub(crate) fn set_stuck(&mut self, stuck: bool) {
        self.stuck = stuck;
    }

    /// Multiplies the rate limit: 0.1 is a slow steering, 1 a normal one.
    pub(crate) fn set_rate_factor(&mut self, factor: f64) {
        self.rate_factor = factor.max(0.0);
    }

    /// Current wheel angle [rad].
    #[inline]
    pub(crate) fn angle_rad(&self) -> f64 {
        self.angle_rad
    }

    /// Advances one step toward `target_rad` (a NaN target holds the wheel); `None` if the wheel did not move.
    #[inline]
    pub(crate) fn step(&mut self, target_rad: f64) -> Option<AngleStep> {
        if self.angle_rad == target_rad || self.stuck || target_rad.is_nan() {
            return None;
        }
        let target = target_rad.clamp(-self.limit_rad, self.limit_rad);
        let start_rad = self.angle_rad;
        if start_rad == target {
            return None;
        }
        let mid_rad = self.half_step(start_rad, target);
        let mut end_rad = self.half_step(mid_rad, target);
        if (target - end_rad).abs() < ARRIVED_RAD {
            end_rad = target;
        }
        self.angle_rad = end_rad;
        Some(AngleStep { start_rad, mid_rad, end_rad })
    }

    fn half_step(&self, angle_rad: f64, target_rad: f64) -> f64 {
        let (rate, dt) = (self.rate_rad_s * self.rate_factor, self.half_step_s);
        let error = target_rad - angle_rad;
        let limited_beyond = rate * self.lag_s;
        if error.abs() <= limited_beyond {
            return target_rad - error * self.half_step_decay;
        }
        // far from the end of the ramp no division is needed
        if error.abs() - limited_beyond > 2.0 * rate * dt {
            return angle_rad + error.signum() * rate * dt;
        }
        let ramp_s = if rate > 0.0 { (error.abs() - limited_beyond) / rate } else { f64::INFINITY };
        if ramp_s >= dt {
            return angle_rad + error.signum() * rate * dt;
        }
        let left = if self.lag_s > 0.0 { limited_beyond * (-(dt - ramp_s) / self.lag_s).exp() } else { 0.0 };
        target_rad - error.signum() * left
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use std::f64::consts::FRAC_PI_2;

    #[test]
    fn the_wheel_ramps_then_settles_exactly_at_its_target() {
        let mut steering = Steering::new(&SteeringSettings { rate_deg_s: 60.0, lag_s: 0.1, limit_deg: 100.0 }, 1e-3).unwrap();
        for _ in 0..1000 {
            steering.step(FRAC_PI_2);
        }
        assert!((steering.angle_rad() - 60.0 * RAD_PER_DEG).abs() < 1e-9, "one second at 60°/s");
        // the ramp ends 60°/s · 0.1 s = 6° before the target, after 84°/60°/s = 1.4 s; then 6°·exp(−t/0.1 s)
        for _ in 0..600 {
            steering.step(FRAC_PI_2);
        }
        let left_deg = (FRAC_PI_2 - steering.angle_rad()) / RAD_PER_DEG;
        assert!((left_deg - 6.0 * (-2.0_f64).exp()).abs() < 1e-6, "{left_deg}");
        for _ in 0..3000 {
            steering.step(FRAC_PI_2);
        }
        assert_eq!(steering.angle_rad(), FRAC_PI_2);
    }

    #[test]
    fn a_stuck_wheel_stays_and_a_slow_one_takes_longer() {
        let mut steering = Steering::new(&SteeringSettings::default(), 1e-3).unwrap();
        steering.set_stuck(true);
        assert_eq!(steering.step(1.0), None);
        steering.set_stuck(false);
        steering.set_rate_factor(0.5);
        for _ in 0..1000 {
            steering.step(FRAC_PI_2);
        }
        assert!((steering.angle_rad() - 30.0 * RAD_PER_DEG).abs() < 1e-9);
    }

    #[test]
    fn the_mechanical_stop_holds_the_wheel() {
        let mut steering = Steering::new(&SteeringSettings::default(), 1e-3).unwrap();
        for _ in 0..10_000 {
            steering.step(3.0);
        }
        assert_eq!(steering.angle_rad(), 100.0 * RAD_PER_DEG);
    }
}
