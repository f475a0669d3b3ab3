//! The result of a check: findings with their places, and a report that counts them.

use serde::Serialize;
use std::fmt;

/// A rule for maps.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Rule {
    /// The file is readable in its own format.
    Readable,
    /// At least two rows and two columns.
    Size,
    /// All rows have one length.
    RaggedRow,
    /// Every cell is a finite number.
    NotANumber,
    /// Breaks increase strictly.
    AxisOrder,
    /// A place is given once.
    Duplicate,
    /// More command, more acceleration.
    NotMonotone,
    /// Neighbours that are equal, where no inverse exists.
    Plateau,
    /// A drive command does not brake, a brake command does not drive.
    Sign,
    /// Without command the wheel does not speed up.
    CoastPositive,
    /// No step far steeper than the map's others.
    Jump,
    /// The axes begin where they should, and have no gap.
    RangeGap,
    /// The torques at which a resting wheel stays at rest are given.
    DeadBand,
    /// The file is the one that the JSON beside it describes.
    HashMismatch,
}

impl fmt::Display for Rule {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Readable => "not readable",
            Self::Size => "too small",
            Self::RaggedRow => "ragged row",
            Self::NotANumber => "not a number",
            Self::AxisOrder => "axis order",
            Self::Duplicate => "duplicate entry",
            Self::NotMonotone => "not monotone",
            Self::Plateau => "plateau",
            Self::Sign => "inconsistent sign",
            Self::CoastPositive => "coast row positive",
            Self::Jump => "jump",
            Self::RangeGap => "range gap",
            Self::DeadBand => "dead band missing",
            Self::HashMismatch => "hash mismatch",
        })
    }
}

/// Severity of a finding.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Severity {
    /// Worth knowing; the map keeps its rules.
    Note,
    /// The map can be used, but probably not as intended.
    Warning,
    /// A controller that reads the map fails, or acts wrongly.
    Error,
}

impl fmt::Display for Severity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Note => "note",
            Self::Warning => "warning",
            Self::Error => "error",
        })
    }
}

/// A broken rule and its place.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct RuleBreach {
    /// The rule.
    pub rule: Rule,
    /// How much it matters.
    pub severity: Severity,
    /// Line of the file, counted from 1; absent if there is none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub line: Option<u64>,
    /// Cell of the line, counted from 1.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub column: Option<usize>,
    /// The place on the map's axes: `speed 0.1, torque 4`; empty for the whole file.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub at: String,
    /// What is wrong.
    pub what: String,
}

impl RuleBreach {
    /// A finding about the whole file.
    pub(crate) fn whole(rule: Rule, severity: Severity, what: impl Into<String>) -> Self {
        Self { rule, severity, line: None, column: None, at: String::new(), what: what.into() }
    }

    /// A finding at a place on the map's axes.
    pub(crate) fn at(rule: Rule, severity: Severity, at: impl Into<String>, what: impl Into<String>) -> Self {
        Self { at: at.into(), ..Self::whole(rule, severity, what) }
    }

    /// The same with a line, and a cell of it unless that is 0.
    pub(crate) fn on(self, line: Option<u64>, column: usize) -> Self {
        Self { line, column: (line.is_some() && column > 0).then_some(column), ..self }
    }

    /// The place in words: line, cell and axes, if known.
    pub fn place(&self) -> String {
        let line = self.line.map(|line| format!("line {line}"));
        let column = self.column.map(|column| format!("cell {column}"));
        let at = (!self.at.is_empty()).then(|| self.at.clone());
        line.into_iter().chain(column).chain(at).collect::<Vec<_>>().join(", ")
    }
}

/// How often a rule is broken.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Count {
    /// The rule.
    pub rule: Rule,
    /// How much it matters.
    pub severity: Severity,
    /// Number of findings.
    pub findings: usize,
    /// Number of places judged, if the rule is judged place by place.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub of: Option<usize>,
    /// Kind of these places.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub unit: Option<&'static str>,
}

impl fmt::Display for Count {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (self.of, self.unit) {
            (Some(of), Some(unit)) => write!(f, "{}: {} of {of} {unit}", self.rule, self.findings),
            _ => write!(f, "{}: {}", self.rule, self.findings),
        }
    }
}

/// The check of one map.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct CheckReport {
    /// The file.
    pub map: String,
    /// The format it was read as.
    pub format: String,
    /// Rows, columns or entries that were read.
    pub size: String,
    /// Whether there is nothing above a note.
    pub sound: bool,
    /// The findings, counted by rule.
    pub counts: Vec<Count>,
    /// The findings, in the order of the rules and of the file.
    pub findings: Vec<RuleBreach>,
}

impl CheckReport {
    /// Counts and orders `findings`; `judged` has for each rule how many places of which kind were judged.
    pub(crate) fn new(
        map: String,
        format: &str,
        size: String,
        mut findings: Vec<RuleBreach>,
        judged: &[(Rule, usize, &'static str)],
    ) -> Self {
        findings.sort_by_key(|f| (std::cmp::Reverse(f.severity), f.rule)); // stable: the file's order within a rule
        let mut counts: Vec<Count> = Vec::new();
        for finding in &findings {
            match counts.last_mut() {
                Some(count) if count.rule == finding.rule && count.severity == finding.severity => count.findings += 1,
                _ => {
                    let judged = judged.iter().find(|j| j.0 == finding.rule);
                    let (of, unit) = (judged.map(|j| j.1), judged.map(|j| j.2));
                    counts.push(Count { rule: finding.rule, severity: finding.severity, findings: 1, of, unit });
                }
            }
        }
        let sound = findings.iter().all(|f| f.severity == Severity::Note);
        Self { map, format: format.to_owned(), size, sound, counts, findings }
    }
}
