//! Settings of the estimator.

use crate::fit::KnownCalibration;
use crate::map::DriveFamily;
use serde::{Deserialize, Serialize};

/// A time of a campaign.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum CampaignTime {
    /// Its mean.
    #[default]
    Mean,
    /// Its end.
    End,
}

/// Settings of the estimator; an ordinary log needs only the defaults.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FitSettings {
    /// Dead time of the drive [s] when it is known; estimated otherwise. What the logs show beyond it is an offset of the clocks.
    pub dead_time_s: Option<f64>,
    /// The family of the drive when it is known; chosen by the data otherwise.
    pub drive: Option<DriveFamily>,
    /// Time constant of the drive's lag [s] when it is known; estimated otherwise.
    pub lag_s: Option<f64>,
    /// Coefficients of the surface along speed. Default 20, on knots uniform in ln(1 + V/0.12): 15 cannot follow a wave of 0.6 m/s
    /// at 1 m/s, and 22 are not nearer to the truth.
    pub speed_nodes: usize,
    /// Coefficients of the surface along torque, about. Default 17: as fine as the usual steps of a campaign; between them are no data.
    pub torque_nodes: usize,
    /// Time after a step of the effective torque that the surface does not use [s]. Default 0: dead time and lag explain it, cells that are
    /// only passed through after a step have no other data, and a cut there splits the run and loses most of the information on the delays.
    pub transient_s: f64,
    /// Most iterations on a sample of the data with noise and encoder free, then on everything. Default 6 and 8; on everything two or three
    /// are usual.
    pub iterations: [usize; 2],
    /// Speed breaks of the table [m/s]; by default every 0.05 from 0 to the fastest measured.
    pub speed_breaks_mps: Option<Vec<f64>>,
    /// Torque breaks of the table [N·m]; by default the tested levels.
    pub torque_breaks_nm: Option<Vec<f64>>,
    /// The time of the campaign whose map is made, where friction or torque changed clearly. Default: the middle.
    pub at: CampaignTime,
    /// Share of the table's cells between the measured extremes that must be measured or interpolated; below it the fit is rejected.
    /// Default 0.3.
    pub least_coverage: f64,
    /// Delays and encoder calibration known from runs at other wheel angles of the same logs; default none. Not a setting of a file.
    #[serde(skip)]
    #[doc(hidden)]
    pub known: Option<KnownCalibration>,
}

impl Default for FitSettings {
    fn default() -> Self {
        Self {
            dead_time_s: None,
            drive: None,
            lag_s: None,
            speed_nodes: 20,
            torque_nodes: 17,
            transient_s: 0.0,
            iterations: [6, 8],
            speed_breaks_mps: None,
            torque_breaks_nm: None,
            at: CampaignTime::Mean,
            least_coverage: 0.3,
            known: None,
        }
    }
}
