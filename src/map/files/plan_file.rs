//! `plan.json`: the runs that `pivot-cal plan` proposes after a Table 1, for the report. Nothing is computed from it.

use crate::map::files::format::{FORMAT_VERSION, parse_file};
use crate::map::files::json_text;
use crate::map::files::table1_file::Table1File;
use crate::map::{Gear, Result};
use serde::{Deserialize, Serialize};

/// The `format` field of a `plan.json`.
const FORMAT: &str = "pivot-cal/plan";

/// `plan.json`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct PlanFile {
    /// Always `pivot-cal/plan`.
    pub format: String,
    /// Version of this layout.
    pub format_version: u32,
    /// Version of the program that wrote the file.
    pub tool_version: String,
    /// Identifier of the generation, that of the Table 1 behind the file; empty in files of versions before it.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub generation: String,
    /// SHA-256 of the `table1.json` that it was made from.
    pub table1_sha256: String,
    /// The proposal.
    pub plan: Proposal,
}

/// A campaign still to drive, the most useful runs first.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Proposal {
    /// The time that may be driven [s]; 0 in a file without it.
    #[serde(default)]
    pub budget_s: f64,
    /// Expected time of the runs [s].
    pub seconds: f64,
    /// Number of runs, repeats counted.
    pub runs: u32,
    /// Root mean square over the cells of the torque's standard error [N·m]: now, ...
    pub std_err_nm: f64,
    /// ... and expected after the runs.
    pub std_err_after_nm: f64,
    /// The runs, by falling gain per second.
    pub entries: Vec<PlanEntry>,
}

/// A run, how often it is driven, and why.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PlanEntry {
    /// The run.
    #[serde(flatten)]
    pub run: PlannedRun,
    /// How often.
    pub repeats: u32,
    /// Time of one run with everything around it [s].
    pub seconds: f64,
    /// Reduction of the standard error by the first of these runs, root mean square over the cells [N·m], ...
    pub gain_nm: f64,
    /// ... as a share of the standard error before that run [%], ...
    pub gain_percent: f64,
    /// ... and per second of driving [N·m/s]; 0 in a file without it.
    #[serde(default)]
    pub gain_nm_per_s: f64,
    /// The cells that gain most, and their standard error before.
    pub reason: String,
}

/// A run that could be driven: from rest, or after a spin-up. In a campaign file the keys have the same names.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct PlannedRun {
    /// Gear.
    pub gear: Gear,
    /// Torque [N·m], gear frame.
    pub torque_nm: f64,
    /// Speed from which it is applied [m/s]; 0 is from rest.
    pub start_speed_mps: f64,
    /// Torque of the spin-up to that speed [N·m]; absent from rest.
    pub spin_up_nm: Option<f64>,
    /// The level ends at this speed [m/s], ...
    #[serde(default)]
    pub speed_limit_mps: f64,
    /// ... after a spin-up below this one [m/s], ...
    #[serde(default)]
    pub end_speed_mps: f64,
    /// ... and after this time [s]. These three are 0 in a file without them.
    #[serde(default)]
    pub hold_s: f64,
}

impl PlanFile {
    /// Of a proposal made from the `table1.json` of that SHA-256.
    pub(crate) fn new(table1: &Table1File, table1_sha256: String, plan: Proposal) -> Self {
        Self {
            format: FORMAT.to_owned(),
            format_version: FORMAT_VERSION,
            tool_version: env!("CARGO_PKG_VERSION").to_owned(),
            generation: table1.generation.clone(),
            table1_sha256,
            plan,
        }
    }

    /// The text of `plan.json`, with a final line end.
    ///
    /// # Errors
    /// None in practice; serialisation is fallible by its signature.
    pub(crate) fn to_json(&self) -> Result<String> {
        json_text::to_text(self)
    }

    /// Reads the text of a `plan.json`.
    ///
    /// # Errors
    /// Not JSON, another format, an unknown version, a missing or misplaced field.
    pub(crate) fn from_json(text: &str) -> Result<Self> {
        parse_file(text, FORMAT)
    }
}

impl PlannedRun {
    /// Its start, in words.
    pub fn start(&self) -> String {
        match self.spin_up_nm {
            Some(torque_nm) => format!("from {:.2} m/s reached with {torque_nm:.1} N·m", self.start_speed_mps),
            None => "from rest".to_owned(),
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn file() -> PlanFile {
        let run = PlannedRun {
            gear: Gear::Reverse,
            torque_nm: -24.1,
            start_speed_mps: 0.7,
            spin_up_nm: Some(40.0),
            speed_limit_mps: 0.9,
            end_speed_mps: 0.03,
            hold_s: 2.5,
        };
        let entry = PlanEntry {
            run,
            repeats: 2,
            seconds: 1.6,
            gain_nm: 0.1,
            gain_percent: 7.3,
            gain_nm_per_s: 0.0625,
            reason: "few runs".to_owned(),
        };
        let plan = Proposal { budget_s: 30.0, seconds: 3.2, runs: 2, std_err_nm: 1.4, std_err_after_nm: 1.2, entries: vec![entry] };
        let table1 = Table1File::from_json(include_str!("../../../maps/table1.json")).unwrap();
        PlanFile::new(&table1, "0".repeat(64), plan)
    }

    #[test]
    fn a_proposal_survives_its_file_and_a_run_says_how_it_starts() {
        let read = PlanFile::from_json(&file().to_json().unwrap()).unwrap();
        assert_eq!(read, file());
        assert_eq!(read.plan.entries[0].run.start(), "from 0.70 m/s reached with 40.0 N·m");
    }

    #[test]
    fn a_file_without_the_way_of_driving_can_still_be_shown() {
        let mut json: serde_json::Value = serde_json::from_str(&file().to_json().unwrap()).unwrap();
        let entry = json["plan"]["entries"][0].as_object_mut().unwrap();
        for field in ["speed_limit_mps", "end_speed_mps", "hold_s", "gain_nm_per_s"] {
            entry.remove(field).unwrap();
        }
        assert_eq!(PlanFile::from_json(&json.to_string()).unwrap().plan.entries[0].run.hold_s, 0.0);
        json["plan"]["entries"][0].as_object_mut().unwrap().remove("torque_nm");
        assert!(PlanFile::from_json(&json.to_string()).is_err());
    }
}
