//! Settings of the search.

use crate::controller::ControllerFile;
use crate::verify::VerifySettings;

/// What the search may do with the plan: cruise speed, acceleration and deceleration.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) enum PlanFreedom {
    /// Nothing: gains and preview only.
    Keep,
    /// Make it slower if no gains keep the gate on it.
    #[default]
    Slower,
    /// Also make it faster, as far as the gate is kept.
    Any,
}

impl PlanFreedom {
    /// The names on the command line.
    pub(crate) const NAMES: [(&'static str, Self); 3] = [("keep", Self::Keep), ("slower", Self::Slower), ("any", Self::Any)];
}

/// Settings of the search.
#[derive(Debug, Clone)]
pub(crate) struct TuneSettings {
    /// The controller that the search starts from.
    pub(crate) start: ControllerFile,
    /// Perturbed plants per scenario and candidate. Default 60; the result is judged with those of `verify`.
    pub(crate) draws: usize,
    /// Share of each limit that is to be left, 0 to 0.9. Default 0.15: the largest of 60 draws is then about the 99th percentile of many.
    pub(crate) reserve: f64,
    /// What may be done with the plan.
    pub(crate) plan: PlanFreedom,
    /// Scenarios, gate, spread, seed, and the draws of the final judgement.
    pub(crate) verify: VerifySettings,
}
