//! `plan.json`: the runs that `pivot-cal plan` proposes after a Table 1, for the report. Nothing is computed from it.

use crate::map::format::{FORMAT_VERSION, expect_format};
use crate::map::{Gear, Result, json_text};
use serde::{Deserialize, Serialize};

/// What the `format` field of a `plan.json` says.
const FORMAT: &str = "pivot-cal/plan";

/// `plan.json`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PlanFile {
    /// Always `pivot-cal/plan`.
    pub format: String,
    /// Version of this layout, [`crate::map::FORMAT_VERSION`].
    pub format_version: u32,
    /// Version of the program that wrote the file.
    pub tool_version: String,
    /// SHA-256 of the `table1.json` that it was made from.
    pub table1_sha256: String,
    /// The proposal.
    pub plan: Proposal,
}

/// A campaign still to drive, the most useful runs first.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Proposal {
    /// What the runs are expected to take [s].
    pub seconds: f64,
    /// Number of runs, repeats counted.
    pub runs: u32,
    /// Root mean square over the cells of the torque's standard error [N·m]: now, ...
    pub std_err_nm: f64,
    /// ... and expected after the runs.
    pub std_err_after_nm: f64,
    /// The runs, by falling gain per second.
    pub entries: Vec<PlannedRun>,
}

/// A run, and how often it is driven.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PlannedRun {
    /// Gear.
    pub gear: Gear,
    /// Torque [N·m], gear frame.
    pub torque_nm: f64,
    /// Speed from which it is applied [m/s]; 0 is from rest.
    pub start_speed_mps: f64,
    /// Torque of the spin-up to that speed [N·m]; absent from rest.
    pub spin_up_nm: Option<f64>,
    /// How often.
    pub repeats: u32,
    /// Time of one run with everything around it [s].
    pub seconds: f64,
    /// What the first of these runs takes off the standard error, root mean square over the cells [N·m], ...
    pub gain_nm: f64,
    /// ... and as share of what it was before that run [%].
    pub gain_percent: f64,
    /// Why.
    pub reason: String,
}

impl PlanFile {
    /// Of the proposal `plan`, an object with the fields of [`Proposal`], after the `table1.json` of that SHA-256.
    ///
    /// # Errors
    /// An object of other fields.
    pub fn new(table1_sha256: String, plan: serde_json::Value) -> Result<Self> {
        Ok(Self {
            format: FORMAT.to_owned(),
            format_version: FORMAT_VERSION,
            tool_version: env!("CARGO_PKG_VERSION").to_owned(),
            table1_sha256,
            plan: serde_json::from_value(plan)?,
        })
    }

    /// The text of `plan.json`, with a final line end.
    ///
    /// # Errors
    /// None in practice; serialisation is fallible by its signature.
    pub fn to_json(&self) -> Result<String> {
        json_text::to_text(self)
    }

    /// Reads the text of a `plan.json`.
    ///
    /// # Errors
    /// Not JSON, another format, an unknown version, a missing or misplaced field.
    pub fn from_json(text: &str) -> Result<Self> {
        Ok(serde_json::from_value(expect_format(text, FORMAT)?)?)
    }
}

impl PlannedRun {
    /// From where it starts, in words.
    pub fn start(&self) -> String {
        match self.spin_up_nm {
            Some(torque_nm) => format!("from {:.2} m/s reached with {torque_nm:.1} N·m", self.start_speed_mps),
            None => "from rest".to_owned(),
        }
    }
}
