//! Delays and drive of a fit, as `table1.json` holds them.

use crate::map::files::identified_drive::{CampaignChange, IdentifiedDrive};
use crate::map::files::named;
use crate::map::files::status::{ActuatorInput, DelayStatus};
use serde::{Deserialize, Serialize};

/// A delay with its uncertainty.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct DelayEstimate {
    /// The delay [s].
    pub value_s: f64,
    /// Standard error [s]; absent when the value was given.
    pub std_err_s: Option<f64>,
    /// Its status.
    #[serde(with = "named")]
    pub status: DelayStatus,
}

/// The drive between commanded and effective torque: dead time, then a first-order lag, or another drive.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Actuator {
    /// Dead time of the drive [s], the mean over the logs.
    pub dead_time: DelayEstimate,
    /// Time constant of the first-order lag [s], shared by the logs.
    pub lag: DelayEstimate,
    /// The input that the fit used.
    pub input: ActuatorInput,
    /// The drive, where it is more than a first-order lag; the lag is then that of the nearest one.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub drive: Option<IdentifiedDrive>,
    /// What changed during the campaign, where it is clear.
    #[serde(skip_serializing_if = "Vec::is_empty", default)]
    pub changes: Vec<CampaignChange>,
    /// The same per log: a command's stamp is late by its sampling phase, differently in each log.
    pub per_log: Vec<LogActuator>,
}

impl Actuator {
    /// The drive where it is more than a first-order lag, and what changed during the campaign: label and text of each line.
    pub(crate) fn drive_lines(&self) -> Vec<(&'static str, String)> {
        let drive = self.drive.iter().flat_map(IdentifiedDrive::lines);
        drive.chain(self.changes.iter().flat_map(CampaignChange::lines)).collect()
    }
}

/// Delays of one log.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LogActuator {
    /// SHA-256 of the log.
    pub sha256: String,
    /// File name of the log.
    pub file: String,
    /// Dead time by this log, without the clock offset.
    pub dead_time: DelayEstimate,
    /// How far the speed sources' clock is ahead of the torque command's [s] (positive: speed is stamped too early).
    pub clock_offset: DelayEstimate,
}
