//! The values that turn raw readings into speeds on one clock, and commands into torques.

use crate::fit::drive_form::campaign_drift::CampaignDrift;
use crate::fit::drive_form::drive_model::DriveModel;

/// The values that turn raw readings into speeds on one clock, and commands into torques. Estimated with the surface.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Calibration {
    /// T_d of each log [s].
    pub(crate) dead_time_s: Vec<f64>,
    /// The drive between command and effective torque.
    pub(crate) drive: DriveModel,
    /// What changes during the campaign.
    pub(crate) drift: CampaignDrift,
    /// Encoder reading over true speed.
    pub(crate) encoder_scale: f64,
    /// How much later the encoder reads than the yaw rate [s].
    pub(crate) encoder_delay_s: f64,
}
