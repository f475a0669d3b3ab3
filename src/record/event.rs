//! Messy things that happen during a run.

use serde::{Deserialize, Serialize};

/// Something that happens during a run's hold.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RunEvent {
    /// What happens.
    pub kind: EventKind,
    /// When, after the torque was applied [s]. Default 0.5.
    #[serde(default = "default_at_s")]
    pub at_s: f64,
    /// For how long [s]. Default 0.5.
    #[serde(default = "default_duration_s")]
    pub duration_s: f64,
    /// Grip of a wet patch [N·m]. Default 10.
    #[serde(default = "default_grip_nm")]
    pub grip_nm: f64,
    /// Force of a hand push along the wheel [N], + in the gear's direction. Default 150.
    #[serde(default = "default_force_n")]
    pub force_n: f64,
    /// Angle to which the wheel is turned away [°]. Default 60.
    #[serde(default = "default_angle_deg")]
    pub angle_deg: f64,
}

fn default_at_s() -> f64 {
    0.5
}
fn default_duration_s() -> f64 {
    0.5
}
fn default_grip_nm() -> f64 {
    10.0
}
fn default_force_n() -> f64 {
    150.0
}
fn default_angle_deg() -> f64 {
    60.0
}

/// Kinds of events.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum EventKind {
    /// The emergency stop is pressed; the run ends.
    EmergencyStop,
    /// The floor takes little torque: the wheel slips.
    WetPatch,
    /// Somebody pushes.
    HandPush,
    /// The wheel is steered away under torque.
    SteerAway,
}

impl RunEvent {
    /// Whether it is under way at `t_s` after the torque was applied.
    pub(crate) fn is_on(&self, t_s: f64) -> bool {
        t_s >= self.at_s && t_s < self.at_s + self.duration_s
    }
}
