//! Loads on the front wheel, and the integration of its motion.

use crate::sim::Gear;
use crate::sim::drive::TorqueStep;
use crate::sim::pose::SpeedStep;

/// Loads on the wheel over one step, vehicle frame, referred to the wheel.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Load {
    /// Torque from the drive to the floor.
    pub torque: TorqueStep,
    /// Slope and pushes as torque at the wheel [N·m], + forward.
    pub external_nm: f64,
    /// Friction of the brake [N·m], ≥ 0.
    pub brake_nm: f64,
    /// Gear engaged; `None` is neutral.
    pub gear: Option<Gear>,
}

/// v̇ = a(stage, v): one step of the classical Runge-Kutta method. Stages 0, 1, 2 are the start, middle and end of the step; the speed at
/// the middle comes from the continuous extension of third order. Returns the speeds and the acceleration at the end.
///
/// Source: Hairer, Nørsett & Wanner, *Solving Ordinary Differential Equations I*, II.1 and II.6.
#[inline]
pub(crate) fn runge_kutta(step_s: f64, start_mps: f64, mut accel: impl FnMut(usize, f64) -> f64) -> (SpeedStep, f64) {
    let half = 0.5 * step_s;
    let k1 = accel(0, start_mps);
    let k2 = accel(1, start_mps + half * k1);
    let k3 = accel(1, start_mps + half * k2);
    let k4 = accel(2, start_mps + step_s * k3);
    let mid_mps = start_mps + step_s * (5.0 * k1 + 4.0 * (k2 + k3) - k4) * (1.0 / 24.0);
    let end_mps = start_mps + step_s * (k1 + 2.0 * (k2 + k3) + k4) * (1.0 / 6.0);
    (SpeedStep { start_mps, mid_mps, end_mps }, k4)
}
