//! The conventional law, for comparison: PID on the heading error → speed command → PI → acceleration → constant-gain torque.
//!
//! `v_c` = Kp·ψ + Ki·Σ ψ·Δt − Kd·ω, limited to 0…`v_max`; ψ is the remaining turn, positive before the end, and ω the turning rate. Then
//! follow the speed loop of the map's law with the same acceleration limits, and τ = k·a within the same torque limit.

use crate::Gear;
use crate::drive_law::{DriveInputs, DriveLaw};
use crate::messages::{DriveStep, PivotRequest, Pose};
use crate::numeric::wrapped;
use crate::speed_loop::{SpeedLoop, SpeedLoopSettings};
use crate::torque_map::{ConstantGain, TorqueFromAccel};

/// Gains of the conventional law.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct HeadingLawSettings {
    /// Control period [s]. Default 0.02.
    pub period_s: f64,
    /// Kp of the heading [m/s per rad].
    pub heading_proportional: f64,
    /// Ki of the heading [m/s per rad·s].
    pub heading_integral: f64,
    /// Kd of the heading [m/s per rad/s].
    pub heading_derivative: f64,
    /// Highest speed command [m/s]: the cruise speed of the plan.
    pub max_speed_mps: f64,
    /// Gains and limits of the speed loop.
    pub speed_loop: SpeedLoopSettings,
    /// Below this speed [m/s] the wheel counts as resting.
    pub standstill_mps: f64,
    /// The end is reached when the remaining turn is less than this [rad] and the wheel nearly rests, or when the turn is complete.
    /// Default 0.3°.
    pub end_threshold_rad: f64,
    /// Torque per acceleration.
    pub torque: ConstantGain,
}

/// The law with its state.
#[derive(Debug, Clone)]
pub struct HeadingLaw {
    settings: HeadingLawSettings,
    heading_rad: f64,
    turned_rad: f64,
    sum_rad_s: f64,
    speed_loop: SpeedLoop,
    saturated: bool,
}

impl HeadingLaw {
    /// A law with these gains.
    pub fn new(settings: HeadingLawSettings) -> Self {
        Self { settings, heading_rad: 0.0, turned_rad: 0.0, sum_rad_s: 0.0, speed_loop: SpeedLoop::default(), saturated: false }
    }
}

impl DriveLaw for HeadingLaw {
    fn start(&mut self, _request: &PivotRequest, pose: Pose) {
        *self = Self::new(self.settings);
        self.heading_rad = pose.heading_rad;
    }

    fn step(&mut self, request: &PivotRequest, inputs: &DriveInputs) -> Option<DriveStep> {
        let settings = &self.settings;
        let turned_now_rad = wrapped(inputs.pose.heading_rad - self.heading_rad) * request.direction.sign();
        if !turned_now_rad.is_finite() {
            return None;
        }
        self.heading_rad = inputs.pose.heading_rad;
        self.turned_rad += turned_now_rad;
        let left_rad = request.turn_rad - self.turned_rad;
        let rate_rad_s = turned_now_rad / settings.period_s;
        let sum_rad_s = self.sum_rad_s + left_rad * settings.period_s;
        let wanted_mps =
            settings.heading_proportional * left_rad + settings.heading_integral * sum_rad_s - settings.heading_derivative * rate_rad_s;
        let target_speed_mps = wanted_mps.max(0.0).min(settings.max_speed_mps);
        if target_speed_mps == wanted_mps {
            self.sum_rad_s = sum_rad_s;
        }
        let speed_mps = inputs.speed_mps;
        let (accel_mps2, limited) =
            self.speed_loop.step(&settings.speed_loop, target_speed_mps - speed_mps, self.saturated, settings.period_s);
        let found = settings.torque.torque(request.gear, speed_mps, accel_mps2)?;
        let torque_nm = if speed_mps < settings.standstill_mps && accel_mps2 <= 0.0 { 0.0 } else { found.torque_nm };
        self.saturated = found.torque_nm != settings.torque.gain_nm_per_mps2 * accel_mps2;
        let nearly_standing = speed_mps < 2.0 * settings.standstill_mps;
        let end_reached = (left_rad < settings.end_threshold_rad && nearly_standing) || left_rad <= 0.0;
        Some(DriveStep {
            torque_nm,
            target_speed_mps,
            speed_mps,
            accel_mps2,
            arc_m: self.turned_rad / request.turn_rad * request.path.length_m(),
            limited,
            outside_table: false,
            end_reached,
        })
    }

    fn braking_torque_nm(&self, gear: Gear, speed_mps: f64, decel_mps2: f64) -> f64 {
        self.settings.torque.torque(gear, speed_mps, -decel_mps2).map_or(0.0, |found| found.torque_nm)
    }
}
