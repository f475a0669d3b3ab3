//! How far a figure is from its limit.

use crate::verify::{LimitCheck, Metric, ScenarioVerdict, Statistic};
use serde::Serialize;

/// A limit of the gate in one scenario, and what is left of it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct LimitMargin {
    /// The scenario.
    pub(crate) scenario: String,
    /// The metric.
    pub(crate) metric: Metric,
    /// Its statistic.
    pub(crate) statistic: Statistic,
    /// The figure.
    pub(crate) value: f64,
    /// The limit.
    pub(crate) limit: f64,
    /// Share of the limit that is left; negative if it is broken. Of a share of runs that must be reached, 1 if it is, as it cannot be exceeded.
    pub(crate) margin: f64,
}

/// A share of runs that is missed by 1 % weighs as much as another limit that is broken by this [share].
const MISSED_RUNS: f64 = 10.0;

impl LimitMargin {
    /// `None` for a figure that no run has.
    fn new(scenario: &str, check: &LimitCheck) -> Option<Self> {
        let value = check.value?;
        let (limit, margin) = match (check.at_most, check.at_least) {
            (Some(most), _) if most > 0.0 => (most, 1.0 - value / most),
            (Some(most), _) => (most, if value <= most { 1.0 } else { -1.0 }),
            (None, Some(least)) if value >= least => (least, 1.0),
            (None, Some(least)) => (least, MISSED_RUNS * (value - least) / least.abs().max(1e-9)),
            (None, None) => return None,
        };
        Some(Self { scenario: scenario.to_owned(), metric: check.metric, statistic: check.statistic, value, limit, margin })
    }

    /// Whether both are of one limit, of whatever scenario.
    pub(crate) fn is_of_the_limit(&self, other: &Self) -> bool {
        (self.metric, self.statistic) == (other.metric, other.statistic) && (self.limit - other.limit).abs() < 1e-12
    }

    /// The margins of all limits, the smallest first.
    pub(crate) fn all(verdicts: &[ScenarioVerdict]) -> Vec<Self> {
        let mut all: Vec<Self> = verdicts.iter().flat_map(|v| v.checks.iter().filter_map(|c| Self::new(&v.name, c))).collect();
        all.sort_by(|a, b| a.margin.total_cmp(&b.margin));
        all
    }

    /// The limit, the figure and what is left, in words.
    pub(crate) fn sentence(&self) -> String {
        let (name, value) = (&self.scenario, self.metric.with_unit(self.value));
        let side = if self.margin < 0.0 { "broken" } else { "kept" };
        let limit = self.metric.with_unit(self.limit);
        format!("{} ({}) of {name} is {value}, limit {limit}, {side}", self.metric.title(), self.statistic.title())
    }
}

/// Of each limit the scenario that is nearest to it; `margins` begin with the smallest.
pub(crate) fn nearest_limits(margins: &[LimitMargin]) -> Vec<LimitMargin> {
    let mut nearest: Vec<LimitMargin> = Vec::new();
    for margin in margins {
        if !nearest.iter().any(|n| n.is_of_the_limit(margin)) {
            nearest.push(margin.clone());
        }
    }
    nearest
}
