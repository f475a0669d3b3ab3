//! A check: one figure of a campaign or its fit against its limit, what it means, and what to do.

use serde::{Deserialize, Serialize};

/// The outcome of a check, from good to bad.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum CheckOutcome {
    /// The figure keeps its limit.
    Passed,
    /// The map may be used, with care.
    Warning,
    /// The map must not be used unless a person overrules the check.
    Objection,
}

impl CheckOutcome {
    /// The outcome of a figure with one limit for a warning and one for an objection, and the limit that counts. A figure that is no number
    /// is an objection.
    pub(crate) fn graded(figure: f64, [warning, objection]: [f64; 2]) -> (Self, f64) {
        if figure <= warning {
            (Self::Passed, warning)
        } else if figure <= objection {
            (Self::Warning, warning)
        } else {
            (Self::Objection, objection)
        }
    }
}

/// One figure against its limit. `table1.json` and `verify.json` hold them.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Check {
    /// Its name, as `verify --accept` takes it.
    pub name: String,
    /// Its outcome.
    pub outcome: CheckOutcome,
    /// The figure, in `unit`.
    pub figure: f64,
    /// The limit, in `unit`: the broken one, otherwise the one that is reached first.
    pub limit: f64,
    /// Unit of figure and limit; a count has the name of what is counted.
    pub unit: String,
    /// What was found, in words, with figure and limit.
    pub meaning: String,
    /// What to do; empty when the check is passed.
    pub advice: String,
}

impl Check {
    /// A check that its figure passes; [`Self::broken`] makes it another.
    pub(crate) fn passed(name: impl Into<String>, (figure, limit, unit): (f64, f64, &str), meaning: String) -> Self {
        let (name, unit) = (name.into(), unit.to_owned());
        let round = |value: f64| (value * 1e4).round() / 1e4;
        Self { name, outcome: CheckOutcome::Passed, figure: round(figure), limit: round(limit), unit, meaning, advice: String::new() }
    }

    /// The same check with a worse outcome and what to do about it.
    pub(crate) fn broken(self, outcome: CheckOutcome, advice: impl Into<String>) -> Self {
        Self { outcome, advice: advice.into(), ..self }
    }

    /// The same check with this outcome; the advice is for one that is not passed.
    pub(crate) fn judged(self, outcome: CheckOutcome, advice: impl Into<String>) -> Self {
        if outcome == CheckOutcome::Passed { self } else { self.broken(outcome, advice) }
    }

    /// Whether it is an objection.
    pub fn objects(&self) -> bool {
        self.outcome == CheckOutcome::Objection
    }

    /// What was found and, if it is not passed, what to do: one line.
    pub fn text(&self) -> String {
        if self.advice.is_empty() { self.meaning.clone() } else { format!("{}; {}", self.meaning, self.advice) }
    }
}
