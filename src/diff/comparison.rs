//! The result of a comparison of two maps: its settings, verdict and findings.

use crate::diff::sheet::Table;
use crate::map::Gear;
use serde::Serialize;

/// How a comparison judges.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub(crate) struct DiffSettings {
    /// Expected share of false ones among the cells called significant; the probability of finding anything when nothing changed.
    /// Default 0.05.
    pub false_discovery_rate: f64,
    /// A significant change matters when it is worth more than this acceleration [m/s²]. Default 0.15: the speed loop removes it with a
    /// speed error of 0.05 m/s, the limit of the closed-loop verdict's round trip.
    pub matters_mps2: f64,
}

impl Default for DiffSettings {
    fn default() -> Self {
        Self { false_discovery_rate: 0.05, matters_mps2: 0.15 }
    }
}

/// The outcome.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum DiffVerdict {
    /// No cell differs by more than chance explains.
    Same,
    /// Cells differ by more than chance explains.
    Changed,
    /// The maps cannot be compared.
    Incompatible,
}

/// Result of a comparison.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct MapComparison {
    /// The first file.
    pub a: String,
    /// The second file.
    pub b: String,
    /// Which table was compared.
    pub table: Table,
    /// The verdict.
    pub verdict: DiffVerdict,
    /// Significant cells whose change matters.
    pub matters: usize,
    /// Why the maps are incompatible; empty otherwise.
    pub reasons: Vec<String>,
    /// Notes for the reader.
    pub notes: Vec<String>,
    /// DiffSettings, as used.
    pub settings: DiffSettings,
    /// Largest p that is significant; absent when none is.
    pub threshold_p: Option<f64>,
    /// Per gear.
    pub maps: Vec<MapDiff>,
}

/// The comparison of one gear. Changes are b − a, at the breaks of a within the range of both.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct MapDiff {
    /// Gear.
    pub gear: Gear,
    /// Wheel angle [°].
    pub wheel_angle_deg: f64,
    /// Whether b was interpolated at the breaks of a.
    pub interpolated: bool,
    /// Cells that were compared.
    pub compared: usize,
    /// Cells of a that were skipped: outside b, extrapolated or unreachable in one of them.
    pub left_out: usize,
    /// Significant cells.
    pub significant: usize,
    /// Significant cells whose change matters.
    pub matters: usize,
    /// Root mean square of the change, over the compared cells.
    pub rms_change: f64,
    /// Root mean square of z; 1 by chance.
    pub rms_z: f64,
    /// The significant changes, largest |z| first.
    pub largest: Vec<Significant>,
    /// Row breaks of a.
    pub rows: Vec<f64>,
    /// Column breaks of a.
    pub columns: Vec<f64>,
    /// Change per cell; null where it was skipped.
    pub change: Vec<Vec<Option<f64>>>,
    /// Standard error of the change.
    pub std_err: Vec<Vec<Option<f64>>>,
    /// Change over its standard error.
    pub z: Vec<Vec<Option<f64>>>,
}

/// A significant change.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub(crate) struct Significant {
    /// Row break: torque [N·m] in Table 1, speed [m/s] in Table 2.
    pub row: f64,
    /// Column break: speed [m/s] in Table 1, acceleration [m/s²] in Table 2.
    pub column: f64,
    /// Value in a.
    pub a: f64,
    /// Value in b.
    pub b: f64,
    /// b − a.
    pub change: f64,
    /// Its standard error.
    pub std_err: f64,
    /// Change over standard error.
    pub z: f64,
    /// Two-sided p of z.
    pub p: f64,
    /// The change as an acceleration [m/s²]: itself in Table 1; in Table 2 over the slope of torque in acceleration.
    pub accel_mps2: f64,
}

impl MapComparison {
    /// The verdict in one sentence.
    pub(crate) fn sentence(&self) -> String {
        let (compared, significant): (usize, usize) =
            self.maps.iter().fold((0, 0), |sum, map| (sum.0 + map.compared, sum.1 + map.significant));
        match self.verdict {
            DiffVerdict::Same => format!("Same: none of {compared} cells differs by more than chance explains."),
            DiffVerdict::Changed => format!(
                "Changed: {significant} of {compared} cells differ by more than chance explains, {} of them by more than {} m/s².",
                self.matters, self.settings.matters_mps2
            ),
            DiffVerdict::Incompatible => "Incompatible: the maps cannot be compared.".to_owned(),
        }
    }
}
