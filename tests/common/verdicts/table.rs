//! Outcomes counted: per kind, in total, and every false pass with its figures.

use crate::verdicts::judge::Outcome;
use crate::verdicts::mistakes::Mistake;
use pivot_cal::verify::Status;
use std::fmt::Write as _;

/// One case that was run.
pub(crate) struct Row {
    pub(crate) mistake: Mistake,
    pub(crate) vehicle: &'static str,
    pub(crate) outcome: Outcome,
}

/// Cases by verdict and truth.
#[derive(Default, Clone, Copy)]
struct Counts {
    cases: usize,
    wrong: usize,
    false_passes: usize,
    right_passes: usize,
    right_refused: usize,
    wrong_refused: usize,
    /// No map was made.
    without_map: usize,
}

impl Counts {
    fn of<'a>(rows: impl Iterator<Item = &'a Row>) -> Self {
        let mut counts = Self::default();
        for Row { outcome, .. } in rows {
            let (wrong, passes, made) = (outcome.is_wrong(), outcome.passes(), outcome.wrongness.is_some());
            counts.cases += 1;
            counts.without_map += usize::from(!made);
            counts.wrong += usize::from(wrong);
            counts.false_passes += usize::from(wrong && passes);
            counts.wrong_refused += usize::from(wrong && !passes);
            counts.right_passes += usize::from(made && !wrong && passes);
            counts.right_refused += usize::from(made && !wrong && !passes);
        }
        counts
    }

    fn cells(self) -> String {
        let Self { cases, wrong, false_passes, wrong_refused, right_passes, right_refused, without_map } = self;
        format!("{cases} | {wrong} | {false_passes} | {wrong_refused} | {right_passes} | {right_refused} | {without_map}")
    }
}

const HEADER: &str = "| kind | cases | wrong maps | passed (false) | not passed | right maps passed | not passed | no map | first reason |\n\
                      |---|---|---|---|---|---|---|---|---|\n";

/// The whole text.
pub(crate) fn text(rows: &[Row]) -> String {
    let mut text = String::new();
    for (title, hidden) in [("Observable", false), ("Not observable", true)] {
        let of_title: Vec<&Row> = rows.iter().filter(|r| r.mistake.hidden.is_some() == hidden).collect();
        if of_title.is_empty() {
            continue;
        }
        let _ = writeln!(text, "## {title}\n\n{}", HEADER.trim_end());
        let mut kinds: Vec<&str> = of_title.iter().map(|r| r.mistake.kind).collect();
        kinds.dedup();
        for kind in kinds {
            let of_kind = || of_title.iter().copied().filter(|r| r.mistake.kind == kind);
            let why = of_kind().find_map(|r| r.mistake.hidden).map_or(String::new(), |why| format!("{why}. "));
            let reason = of_kind().find(|r| !r.outcome.passes()).map_or("", |r| &r.outcome.reason);
            let _ = writeln!(text, "| {kind} | {} | {why}{} |", Counts::of(of_kind()).cells(), short(reason));
        }
        let _ = writeln!(text, "| **all** | {} | |\n", Counts::of(of_title.iter().copied()).cells());
    }
    text += &list("False passes", rows, Outcome::is_false_pass);
    text += &list("Right maps that did not pass", rows, |o| o.wrongness.is_some() && !o.is_wrong() && !o.passes());
    text += &list("Wrong maps that failed only in closed loop or for lack of data", rows, |o| {
        o.is_wrong() && matches!(o.status, Some(Status::Fail | Status::NotJudged))
    });
    text
}

fn list(title: &str, rows: &[Row], chosen: impl Fn(&Outcome) -> bool) -> String {
    let mut text = format!("## {title}\n\n");
    for Row { mistake, vehicle, outcome } in rows.iter().filter(|r| chosen(&r.outcome)) {
        let apart = if mistake.hidden.is_some() { " (not observable)" } else { "" };
        let _ = writeln!(text, "- {}, {}, {vehicle}{apart}: {}", mistake.kind, mistake.strength, figures(outcome));
    }
    text + "\n"
}

/// The figures of an outcome as one line.
pub(crate) fn figures(outcome: &Outcome) -> String {
    let wrong = outcome.wrongness.map_or("no map".to_owned(), |w| {
        let what = if w.torques() {
            "torques wrong"
        } else if w.is_wrong() {
            "standard errors too small"
        } else {
            "right"
        };
        format!(
            "{what}, RMS {:.2} N·m ({:.1} × the limit), {:.0} % of {} cells beyond 3 σ",
            w.rms_nm,
            w.over_limit,
            100.0 * w.beyond,
            w.cells
        )
    });
    let warnings = if outcome.warnings.is_empty() { String::new() } else { format!("; warns: {}", outcome.warnings.join(", ")) };
    format!("{wrong}; {}{warnings}", short(&outcome.reason))
}

fn short(reason: &str) -> String {
    let reason = reason.replace('|', "/");
    if reason.chars().count() > 150 { reason.chars().take(150).collect::<String>() + "…" } else { reason }
}
