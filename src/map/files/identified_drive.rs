//! The drive that a fit found between commanded and effective torque, what it does not deliver, and what changed during the campaign.

use serde::{Deserialize, Serialize};

/// Families of drives between the torque command and the torque at the wheel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum DriveFamily {
    /// A first-order lag.
    FirstOrder,
    /// A rate limit, with one slope or with two, and a lag behind it.
    RateLimit,
    /// A second-order lag, which may oscillate.
    SecondOrder,
    /// Whatever the drive is: the torque feedback is the torque.
    Feedback,
}

/// What a limit bounds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum LimitKind {
    /// The torque [N·m], in either direction.
    Torque,
    /// The driving torque times the wheel's speed [N·m·m/s].
    Power,
    /// The speed [m/s]: a governor.
    Speed,
}

/// A limit of the torque that is delivered.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct DriveLimit {
    /// What it bounds.
    pub kind: LimitKind,
    /// The bound, in the unit of its kind.
    pub value: f64,
    /// Its standard error; absent where only the torque feedback shows the limit.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub std_err: Option<f64>,
}

impl DriveLimit {
    /// The largest driving torque that is delivered at a speed [N·m]; without end below a limit of the speed.
    pub fn most_nm(&self, speed_mps: f64) -> f64 {
        match self.kind {
            LimitKind::Torque => self.value,
            LimitKind::Power => self.value / speed_mps.max(1e-6),
            LimitKind::Speed => f64::INFINITY,
        }
    }
}

/// Another drive that was fitted to the same data.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ComparedDrive {
    /// In words, with its parameters.
    pub drive: String,
    /// By how much worse it predicts runs that were left out (−2·ln L).
    pub worse: f64,
    /// Standard error of that over the runs.
    pub std_err: f64,
}

/// Changes from the middle to the end of the campaign, or of each log, before which the vehicle may have cooled down.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct CampaignChange {
    /// Whether it restarts with each log.
    pub of_each_log: bool,
    /// Change of the acceleration under the same torque [m/s²]; 0 where none is clear.
    pub accel_mps2: f64,
    /// Its standard error [m/s²].
    pub accel_std_err_mps2: f64,
    /// Relative change of the torque under the same command; 0 where none is clear.
    pub torque_share: f64,
    /// Its standard error.
    pub torque_share_std_err: f64,
}

/// The drive beyond its dead time.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct IdentifiedDrive {
    /// Its family.
    pub family: DriveFamily,
    /// The lag, alone or behind a rate limit [s].
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub lag_s: Option<f64>,
    /// Largest rise and largest fall of the torque [N·m/s].
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub slopes_nm_s: Option<[f64; 2]>,
    /// Whether the first slope is that of a torque whose magnitude grows, the second of one whose magnitude falls. Otherwise up and down.
    #[serde(skip_serializing_if = "std::ops::Not::not", default)]
    pub slopes_by_magnitude: bool,
    /// Natural frequency of a second-order lag [Hz].
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub frequency_hz: Option<f64>,
    /// Damping of a second-order lag, 1 where it is critical.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub damping: Option<f64>,
    /// What it does not deliver.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub limit: Option<DriveLimit>,
    /// Time for which torque that was asked for was not delivered, by the torque feedback [s].
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub undelivered_s: Option<f64>,
    /// Other drives that were fitted, each worse.
    #[serde(skip_serializing_if = "Vec::is_empty", default)]
    pub compared: Vec<ComparedDrive>,
}
