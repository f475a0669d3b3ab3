//! Settings of a plan.

use serde::Serialize;

/// Settings of a plan.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PlanSettings {
    /// Time of driving [s], including turning the wheel to its angle, spin-ups and stops. Default 300.
    pub budget_s: f64,
    /// Speeds of the cells whose torque is to be estimated [m/s], rising; by default those of Table 1 that were driven. Runs go a little
    /// faster than the last. A speed of 0 is skipped: it has no readings.
    pub speed_breaks_mps: Option<Vec<f64>>,
    /// Torques of these cells [N·m], rising; by default those of Table 1. Levels lie between the first and the last, none above the
    /// vehicle's limit.
    pub torque_breaks_nm: Option<Vec<f64>>,
}

impl Default for PlanSettings {
    fn default() -> Self {
        Self { budget_s: 300.0, speed_breaks_mps: None, torque_breaks_nm: None }
    }
}
