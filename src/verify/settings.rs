//! Settings of the verification.

use crate::controller::ControllerFile;
use crate::sim;
use crate::verify::Result;
use crate::verify::controller_command::ControllerCommand;
use crate::verify::gate::Gate;
use crate::verify::perturbations::Spread;
use crate::verify::scenario::Scenario;

/// Settings of the verification.
#[derive(Debug, Clone, PartialEq)]
pub struct VerifySettings {
    /// The scenarios. Default all.
    pub scenarios: Vec<Scenario>,
    /// Perturbed plants per scenario. Default 200: the two worst then determine the 99th percentile.
    pub draws: usize,
    /// Perturbed plants in the comparison. Default 20; 0 skips the comparison.
    pub comparison_draws: usize,
    /// How far they are perturbed.
    pub spread: Spread,
    /// Seed of everything random. Default 1.
    pub seed: u64,
    /// The limits.
    pub gate: Gate,
    /// Names of checks whose objections a person overrules. Default none.
    pub accept: Vec<String>,
    /// Settings of the controller that drives. Default `data/controllers/default.toml`.
    pub controller: ControllerFile,
    /// A process of the user's that drives instead; the settings of the controller are then the plan that it is judged by. Default none.
    pub controller_command: Option<ControllerCommand>,
    /// A vehicle whose sensors, steering, and step, dead band and rate limits of the torque act beside the identified motion. Default none.
    #[doc(hidden)]
    pub given_vehicle: Option<sim::WorldSettings>,
    /// The plant; `None`, the default, is the one that Table 1 identified.
    #[doc(hidden)]
    pub plant: Option<sim::WorldSettings>,
}

impl VerifySettings {
    /// The defaults.
    ///
    /// # Errors
    /// None in practice: the built-in gate and controller are parsed.
    pub fn new() -> Result<Self> {
        Ok(Self {
            scenarios: Scenario::all(),
            draws: 200,
            comparison_draws: 20,
            spread: Spread::default(),
            seed: 1,
            gate: Gate::with(None)?,
            accept: Vec::new(),
            controller: ControllerFile::bundled()?,
            controller_command: None,
            given_vehicle: None,
            plant: None,
        })
    }
}

/// Outputs beside the verdict. Default none.
#[derive(Clone, Copy, Default)]
pub(crate) struct Wanted<'a> {
    /// The runs over time, for the report.
    pub traces: bool,
    /// A log of each nominal run.
    pub logs: bool,
    /// A log of each manoeuvre's worst perturbed run.
    pub worst_logs: bool,
    /// Called after every simulated run, from any thread, with the total number of runs.
    pub progress: Option<&'a (dyn Fn(usize) + Sync)>,
}

/// The log of a nominal run.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct RunLog {
    /// Name of the scenario.
    pub name: String,
    /// Bytes of an MCAP file of standard ROS 2 messages.
    pub bytes: Vec<u8>,
}
