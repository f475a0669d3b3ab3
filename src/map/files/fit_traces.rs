//! `fit_traces.json`: the signals of a fit along the runs, thinned for people to look at. Nothing is computed from it.

use crate::map::files::format::{FIT_TRACES_FORMAT, parse_file};
use crate::map::{CsvRef, Gear, Result};
use serde::{Deserialize, Serialize};

/// `fit_traces.json`: traces of the runs, residuals, and the likelihood of other delays.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FitTraces {
    /// Always `pivot-cal/fit_traces`.
    pub(crate) format: String,
    /// Version of this layout.
    pub(crate) format_version: u32,
    /// Version of the program that wrote the file.
    pub(crate) tool_version: String,
    /// Identifier of the generation, that of the Table 1 behind the file; empty in files of versions before it.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub(crate) generation: String,
    /// The `table1.json` of the same fit.
    pub(crate) table1: CsvRef,
    /// Names of the verdicts, by which [`RunTrace::verdicts`] numbers them.
    pub(crate) verdicts: Vec<String>,
    /// Traces of the runs, in the order of the report's rows. At most 500: beyond that those with the largest residual.
    pub(crate) runs: Vec<RunTrace>,
    /// Residuals over speed and torque, per gear.
    pub(crate) residual_cells: Vec<ResidualCells>,
    /// Residuals over time, per log.
    pub(crate) residual_times: Vec<ResidualTimes>,
    /// Likelihood of other delays; absent if it has no finite value.
    pub(crate) delay: Option<DelayLikelihood>,
}

/// One run over time, from 0.2 s before it to 0.2 s after it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct RunTrace {
    /// Row of the run in the report of `table1.json`, from 0.
    pub row: usize,
    /// Times after the log's first sample [s].
    pub t_s: Vec<f64>,
    /// Speed by the encoder with its scale and delay taken out [m/s], gear frame.
    pub speed_mps: Vec<f64>,
    /// Speed simulated open loop by a surface fitted without the run [m/s], gear frame; null if the fit used nothing.
    pub simulated_mps: Vec<Option<f64>>,
    /// Torque after dead time and lag [N·m], gear frame.
    pub effective_nm: Vec<f64>,
    /// Wheel angle [°], left positive.
    pub angle_deg: Vec<f64>,
    /// Torque command [N·m], gear frame: time of each change [s] and the value from then on; the first holds at the trace's start.
    pub command: Vec<[f64; 2]>,
    /// From [s], to [s] and number of each verdict.
    pub verdicts: Vec<(f64, f64, usize)>,
}

/// Residual acceleration by the cells of Table 1: measured minus modelled, over windows of about 0.1 s.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct ResidualCells {
    /// Gear.
    pub gear: Gear,
    /// Mean [m/s²] per torque and speed break of Table 1; null without windows.
    pub mean_mps2: Vec<Vec<Option<f64>>>,
    /// Root mean square [m/s²].
    pub rms_mps2: Vec<Vec<Option<f64>>>,
    /// Number of windows.
    pub count: Vec<Vec<u32>>,
}

/// Residual acceleration of one log over time, windows as in [`ResidualCells`], evenly thinned out.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct ResidualTimes {
    /// File name of the log.
    pub log: String,
    /// Times after the log's first sample [s].
    pub t_s: Vec<f64>,
    /// Residuals [m/s²].
    pub residual_mps2: Vec<f64>,
}

/// −2·ln of the likelihood ratio against the best pair of delays. Under the model's assumptions 5.99 bounds the joint 95 % region, 3.84 the
/// 95 % interval of one delay alone. Source: Wilks 1938, *The large-sample distribution of the likelihood ratio*.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct DelayLikelihood {
    /// Shift of every log's dead time against its estimate [s].
    pub dead_time_shift_s: Vec<f64>,
    /// Lags [s].
    pub lag_s: Vec<f64>,
    /// One row per lag, one column per shift.
    pub deviance: Vec<Vec<f64>>,
    /// Over all dead times that a drive may have, at the estimated lag, per log.
    pub per_log: Vec<DeadTimeLikelihood>,
}

/// The likelihood of one log's dead time at the estimated lag.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct DeadTimeLikelihood {
    /// File name of the log.
    pub log: String,
    /// The dead time that the fit found, clock offset included [s].
    pub found_s: f64,
    /// Dead times [s].
    pub dead_time_s: Vec<f64>,
    /// −2·ln of the likelihood ratio against the best of them.
    pub deviance: Vec<f64>,
}

impl FitTraces {
    /// Reads the JSON text.
    ///
    /// # Errors
    /// Not JSON, another format, an unknown version, a missing or misplaced field.
    pub fn from_json(text: &str) -> Result<Self> {
        parse_file(text, FIT_TRACES_FORMAT)
    }

    /// The JSON text, indented, with arrays of numbers on one line and a final line end.
    ///
    /// # Errors
    /// None in practice; serialisation is fallible by its signature.
    pub fn to_json(&self) -> Result<String> {
        crate::map::files::json_text::to_text(self)
    }
}
