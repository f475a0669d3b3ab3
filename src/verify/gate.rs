//! The gate: the limits that a map must keep, and the reason for each. The default is `data/gate.toml`.

use crate::verify::metric::{Metric, MetricSummary, Statistic};
use crate::verify::round_trip::RoundTripLimit;
use crate::verify::scenario::Class;
use crate::verify::{Error, Result};
use serde::{Deserialize, Serialize};

const DEFAULT: &str = include_str!("../../data/gate.toml");

/// All limits.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Gate {
    /// Of the round trip.
    pub round_trip: RoundTripLimit,
    /// Of the scenarios' metrics.
    #[serde(default, rename = "limit")]
    pub limits: Vec<Limit>,
}

/// A gate file: only the differences from the default.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Overrides {
    round_trip: Option<RoundTripLimit>,
    #[serde(default)]
    limit: Vec<Limit>,
}

/// One limit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Limit {
    /// For scenarios of this class.
    pub class: Class,
    /// Metric.
    pub metric: Metric,
    /// Statistic of the metric.
    pub statistic: Statistic,
    /// Largest value that passes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub at_most: Option<f64>,
    /// Smallest value that passes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub at_least: Option<f64>,
    /// Reason.
    #[serde(default)]
    pub reason: String,
}

/// An applied limit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LimitCheck {
    /// Metric.
    pub metric: Metric,
    /// Statistic of the metric.
    pub statistic: Statistic,
    /// The value; absent when no run has one.
    pub value: Option<f64>,
    /// Largest value that passes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub at_most: Option<f64>,
    /// Smallest value that passes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub at_least: Option<f64>,
    /// Whether it passes. A value that no run has passes: a separate limit checks that runs end as expected.
    pub pass: bool,
}

impl Gate {
    /// The default limits; those of `overrides` (TOML) replace them.
    ///
    /// # Errors
    /// Text that is not a gate: an unknown key, class, metric or statistic, or a limit without exactly one finite bound.
    pub fn with(overrides: Option<&str>) -> Result<Self> {
        let mut gate: Self = toml::from_str(DEFAULT)?;
        if let Some(text) = overrides {
            let file: Overrides = toml::from_str(text)?;
            gate.round_trip = file.round_trip.unwrap_or(gate.round_trip);
            for limit in file.limit {
                match gate.limits.iter_mut().find(|l| (l.class, l.metric, l.statistic) == (limit.class, limit.metric, limit.statistic)) {
                    Some(old) => *old = limit,
                    None => gate.limits.push(limit),
                }
            }
        }
        let bad = gate.limits.iter().find(|l| match (l.at_most, l.at_least) {
            (Some(bound), None) | (None, Some(bound)) => !bound.is_finite(),
            _ => true,
        });
        match bad {
            Some(limit) => Err(Error::GateLimit { metric: limit.metric.title().to_owned() }),
            None => Ok(gate),
        }
    }

    /// Applies the limits of a class.
    pub(crate) fn check(&self, class: Class, summaries: &[MetricSummary]) -> Vec<LimitCheck> {
        self.limits
            .iter()
            .filter(|limit| limit.class == class)
            .map(|limit| {
                let summary = summaries.iter().find(|s| s.metric == limit.metric);
                let value = summary.and_then(|s| s.figure(limit.statistic));
                let pass = value.is_none_or(|v| limit.at_most.is_none_or(|m| v <= m) && limit.at_least.is_none_or(|m| v >= m));
                LimitCheck {
                    metric: limit.metric,
                    statistic: limit.statistic,
                    value,
                    at_most: limit.at_most,
                    at_least: limit.at_least,
                    pass,
                }
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn every_default_limit_has_its_reason() {
        let gate = Gate::with(None).unwrap();
        assert!(gate.limits.iter().all(|l| l.reason.len() > 20) && gate.round_trip.reason.len() > 20);
    }

    #[test]
    fn a_file_replaces_the_limits_that_it_names_and_no_other() {
        let text = "[[limit]]\nclass = \"turn\"\nmetric = \"heading_error_deg\"\nstatistic = \"p99\"\nat_most = 3.0\n";
        let (default, own) = (Gate::with(None).unwrap(), Gate::with(Some(text)).unwrap());
        assert_eq!(default.limits.len(), own.limits.len());
        assert_eq!(own.limits.iter().zip(&default.limits).filter(|(a, b)| a != b).count(), 1);
    }

    #[test]
    fn a_misspelt_or_boundless_limit_is_refused() {
        let text = "[[limit]]\nclass = \"turn\"\nmetric = \"heading_error_deg\"\nstatistic = \"p99\"\n";
        assert!(matches!(Gate::with(Some(text)), Err(Error::GateLimit { .. })));
        let error = Gate::with(Some(&text.replace("heading_error_deg", "heading_eror_deg"))).unwrap_err().to_string();
        assert!(error.contains("heading_error_deg"), "{error}");
    }
}
