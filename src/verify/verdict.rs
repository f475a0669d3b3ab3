//! The verdict: the content of `verify.json`.

use crate::control::HeadingLawSettings;
use crate::controller::ControllerFile;
use crate::map::{Check, parse_file};
use crate::scene::SceneFile;
use crate::verify::basis::Basis;
use crate::verify::controller_command::ControllerCommand;
use crate::verify::gate::{Gate, Limit, LimitCheck};
use crate::verify::metric::MetricSummary;
use crate::verify::perturbations::Spread;
use crate::verify::recorded_pivots::RecordedPivots;
use crate::verify::replayed::ReplayedRun;
use crate::verify::round_trip::{RoundTripLimit, RoundTripVerdict};
use crate::verify::scenario::Class;
use serde::{Deserialize, Serialize};

/// Value of the `format` field of a `verify.json`.
pub(crate) const FORMAT: &str = "pivot-cal/verify";

/// Beginning of a note on what went wrong with the controller itself.
const CONTROLLER_FAULT: &str = "the controller broke: ";
/// Runs of a scenario whose controller broke that are described.
const SHOWN_FAULTS: usize = 3;

/// Whether a scenario or a map keeps its limits.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Status {
    /// Every limit is kept.
    Pass,
    /// A limit is broken.
    Fail,
    /// It could not be run; a note gives the reason. This is not a failure. Of a scenario only.
    NotTested,
    /// A check of the campaign or the fit is an objection, and nobody has overruled it. Of a map only.
    Rejected,
    /// Too little was driven, in the campaign or in the verdict, to judge. Of a map only.
    NotJudged,
}

/// `verify.json`. The same maps, settings and seed give the same bytes: it holds no time of day.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MapVerdict {
    /// Always `pivot-cal/verify`.
    pub format: String,
    /// Version of this layout.
    pub format_version: u32,
    /// Version of the program that wrote it.
    pub tool_version: String,
    /// Identifier of the generation, that of the Table 1 behind the file; empty in files of versions before it.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub generation: String,
    /// Whether the map passes: no check is an objection, the round trip and every tested scenario pass, and enough was tested.
    pub status: Status,
    /// The verdict as one line: pass with its scope, or the cause with figure and limit.
    #[serde(default)]
    pub reason: String,
    /// What the pass is narrowed to by what was not tested.
    #[serde(default)]
    pub scope: Vec<String>,
    /// The checks on the campaign and the fit of Table 1.
    #[serde(default)]
    pub checks: Vec<Check>,
    /// Names of the objections that a person has overruled.
    #[serde(default)]
    pub accepted: Vec<String>,
    /// What the verdict is based on beside its runs; absent in files of versions before it.
    #[serde(default)]
    pub(crate) basis: Option<Basis>,
    /// Failures and skipped scenarios, in words.
    pub notes: Vec<String>,
    /// SHA-256 of the Table 2 files that were judged, forward first.
    pub table2_csv_sha256: Vec<String>,
    /// Mismatches that were accepted with `--force`.
    pub forced: Vec<String>,
    /// The plant.
    pub plant: PlantSummary,
    /// Draws per scenario.
    pub draws: usize,
    /// Draws of the comparison.
    pub comparison_draws: usize,
    /// Seed.
    pub seed: u64,
    /// How far the draws vary the plant.
    pub spread: Spread,
    /// Settings of the controller as a file, with its hash; absent in files of versions before them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub controller_settings: Option<ControllerFile>,
    /// The process that was judged in place of the bundled controller; then the settings are those of the plan that it was judged by.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub controller_command: Option<ControllerCommand>,
    /// Settings of the controller, as used.
    pub controller: serde_json::Value,
    /// The limit of the round trip.
    pub round_trip_limit: RoundTripLimit,
    /// The limits of the scenarios.
    pub limits: Vec<Limit>,
    /// The round trip, per gear.
    pub round_trip: Vec<RoundTripVerdict>,
    /// The scenarios.
    pub scenarios: Vec<ScenarioVerdict>,
    /// The map compared with other laws.
    pub comparison: Option<LawComparison>,
    /// SHA-256 of the lateral table in the folder, if there is one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lateral_sha256: Option<String>,
    /// SHA-256 of the settings of the vehicle that drove the manoeuvres, if there are any.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub manoeuvre_vehicle_sha256: Option<String>,
    /// Recorded runs replayed by the plant, if logs were given.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub replayed: Vec<ReplayedRun>,
    /// Recorded pivots in operation, per log and gear, if logs were given.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub pivots: Vec<RecordedPivots>,
}

/// The plant that was driven.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct PlantSummary {
    /// `identified` (a fitted Table 1) or `physical`.
    pub kind: String,
    /// Dead time of its drive [s].
    pub dead_time_s: f64,
    /// Time constant of its drive [s].
    pub lag_s: f64,
    /// Torque limit of its drive [N·m].
    pub torque_limit_nm: f64,
    /// Torque that sets the resting wheel in motion [N·m].
    pub breakaway_nm: f64,
    /// Step of the torque command [N·m], where it was given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub torque_step_nm: Option<f64>,
    /// Dead band of the torque command [N·m], where it was given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub torque_dead_band_nm: Option<f64>,
    /// Largest rate of the torque [N·m/s], found or given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rate_limit_nm_s: Option<f64>,
    /// Step of the speed readings [m/s], found or given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub speed_step_mps: Option<f64>,
}

/// One scenario judged.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ScenarioVerdict {
    /// Name.
    pub name: String,
    /// Description.
    pub what: String,
    /// Class; it determines the limits.
    pub class: Class,
    /// Judgement.
    pub status: Status,
    /// Wheel angle of a pivot at another angle than the test angle [°].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub wheel_angle_deg: Option<f64>,
    /// Perturbed plants that were driven; absent in files of versions before it, and where it was not tested.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub draws: Option<usize>,
    /// What a pass is about, if it is not about the map: a manoeuvre whose torque did not come from it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub about: Option<String>,
    /// The scene file of a manoeuvre of the user's, with its hash.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub scene: Option<SceneFile>,
    /// Notes: why it was not tested, and assumptions.
    pub notes: Vec<String>,
    /// The metrics.
    pub metrics: Vec<MetricSummary>,
    /// The applied limits.
    pub checks: Vec<LimitCheck>,
}

/// The map compared with other laws, on the same plant and the same draws.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LawComparison {
    /// The scenario that all of them drive.
    pub scenario: String,
    /// The laws.
    pub laws: Vec<LawSummary>,
    /// Gain of the constant-gain map and of the conventional law [N·m per m/s²].
    pub constant_gain_nm_per_mps2: f64,
    /// Tuned gains of the conventional law.
    pub conventional: ConventionalGains,
    /// Median start jerk of the map over that of the conventional law; the goal is at most 1/3.
    pub start_jerk_ratio: Option<f64>,
    /// Median speed tracking RMS of the map over that of the perfect inverse; the goal is at most 1.15.
    pub speed_rms_ratio: Option<f64>,
}

/// One law of the comparison.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LawSummary {
    /// `map`, `perfect inverse`, `constant gain`, `conventional`.
    pub name: String,
    /// The metrics.
    pub metrics: Vec<MetricSummary>,
}

/// Tuned gains of the conventional law.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ConventionalGains {
    /// Kp of the heading [m/s per rad].
    pub heading_proportional: f64,
    /// Ki of the heading [m/s per rad·s].
    pub heading_integral: f64,
    /// Kd of the heading [m/s per rad/s].
    pub heading_derivative: f64,
    /// Kp of the speed loop [1/s].
    pub speed_proportional_per_s: f64,
    /// Ki of the speed loop [1/s²].
    pub speed_integral_per_s2: f64,
}

impl ScenarioVerdict {
    /// A scenario that could not be run.
    pub(crate) fn not_tested(name: &str, what: &str, class: Class, why: String) -> Self {
        let (name, what) = (name.to_owned(), what.to_owned());
        Self {
            name,
            what,
            class,
            status: Status::NotTested,
            wheel_angle_deg: None,
            draws: None,
            about: None,
            scene: None,
            notes: vec![why],
            metrics: Vec::new(),
            checks: Vec::new(),
        }
    }

    /// A scenario with its metrics over the nominal plant and `draws` perturbed ones, judged by the limits of its class.
    pub(crate) fn new(name: &str, what: &str, class: Class, (metrics, draws): (Vec<MetricSummary>, usize), gate: &Gate) -> Self {
        let checks = gate.check(class, &metrics);
        let status = if checks.iter().all(|c| c.pass) { Status::Pass } else { Status::Fail };
        Self {
            name: name.to_owned(),
            what: what.to_owned(),
            class,
            status,
            wheel_angle_deg: None,
            draws: Some(draws),
            about: None,
            scene: None,
            notes: Vec::new(),
            metrics,
            checks,
        }
    }
}

impl ScenarioVerdict {
    /// The verdict with what went wrong with the controller itself in its runs, as notes. Any of it is a failure of the scenario, whatever its
    /// class allows.
    #[must_use]
    pub(crate) fn with_controller_faults(mut self, faults: Vec<String>) -> Self {
        if !faults.is_empty() {
            self.status = Status::Fail;
        }
        let left_out = faults.len().saturating_sub(SHOWN_FAULTS);
        self.notes.extend(faults.into_iter().take(SHOWN_FAULTS).map(|fault| format!("{CONTROLLER_FAULT}{fault}")));
        if left_out > 0 {
            self.notes.push(format!("{CONTROLLER_FAULT}and in {left_out} more runs"));
        }
        self
    }

    /// The first thing that went wrong with the controller itself.
    pub(crate) fn controller_fault(&self) -> Option<&str> {
        self.notes.iter().find_map(|note| note.strip_prefix(CONTROLLER_FAULT))
    }
}

impl From<&HeadingLawSettings> for ConventionalGains {
    fn from(settings: &HeadingLawSettings) -> Self {
        Self {
            heading_proportional: settings.heading_proportional,
            heading_integral: settings.heading_integral,
            heading_derivative: settings.heading_derivative,
            speed_proportional_per_s: settings.speed_loop.proportional_per_s,
            speed_integral_per_s2: settings.speed_loop.integral_per_s2,
        }
    }
}

impl MapVerdict {
    /// Reads the text of a `verify.json`.
    ///
    /// # Errors
    /// Not JSON, another format, an unknown version, a missing or misplaced field.
    pub fn from_json(text: &str) -> crate::verify::Result<Self> {
        Ok(parse_file(text, FORMAT)?)
    }

    /// Whether the map passes.
    pub fn passes(&self) -> bool {
        self.status == Status::Pass
    }

    /// The text of `verify.json`, with a final line end.
    ///
    /// # Errors
    /// None in practice; serialisation is fallible by its signature.
    pub fn to_json(&self) -> crate::verify::Result<String> {
        Ok(serde_json::to_string_pretty(self)? + "\n")
    }
}
