//! Rules of a map that is a list of points: Apollo's table and long-form CSV.

use crate::check::grid_rules::{LONG_STEP, long_steps_of};
use crate::check::{Rule, RuleBreach, Severity};
use crate::import::foreign::{CommandPoint, CommandPoints};

/// Which signs of command and acceleration contradict each other.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum SignRule {
    /// Throttle means acceleration, brake means deceleration: any difference in sign is wrong. Apollo's table.
    Strict,
    /// A braking torque cannot speed up a wheel; a driving torque may be smaller than friction. Torque maps.
    Physical,
}

/// Judges the points; returns the places that were judged per rule.
pub(crate) fn judge(points: &CommandPoints, sign: SignRule, findings: &mut Vec<RuleBreach>) -> Vec<(Rule, usize, &'static str)> {
    let rows = points.rows();
    for (speed, row) in &rows {
        monotone(*speed, row, findings);
        if row.len() < 2 {
            let what = "a single entry: nothing to interpolate along acceleration".to_owned();
            findings.push(on(row, RuleBreach::at(Rule::RangeGap, Severity::Warning, format!("speed {speed}"), what)));
        }
    }
    for p in &points.points {
        let wrong = match sign {
            SignRule::Strict => p.accel * p.command < 0.0,
            SignRule::Physical => p.accel > 0.0 && p.command < 0.0,
        };
        if wrong {
            let at = format!("speed {}, acceleration {}", p.speed, p.accel);
            let what = format!("{} {} for an acceleration of {}", points.command, p.command, p.accel);
            findings.push(RuleBreach::at(Rule::Sign, Severity::Error, at, what).on(Some(p.line), 0));
        }
    }
    let speeds: Vec<_> = rows.iter().map(|r| r.0).collect();
    for (from, to) in long_steps_of(&speeds) {
        let what = format!("a step more than {LONG_STEP} times the table's usual one");
        findings.push(RuleBreach::at(Rule::RangeGap, Severity::Warning, format!("speed {from} to {to}"), what));
    }
    if let Some(first) = speeds.first().filter(|first| **first > 0.0) {
        let what = format!("speeds begin at {first}");
        findings.push(RuleBreach::at(Rule::RangeGap, Severity::Note, format!("speed 0 to {first}"), what));
    }
    if let Some(&negative) = speeds.first().filter(|first| **first < 0.0) {
        let what = "speeds are counted in the direction of travel, from 0".to_owned();
        findings.push(RuleBreach::at(Rule::AxisOrder, Severity::Warning, format!("speed {negative}"), what));
    }
    vec![
        (Rule::NotMonotone, rows.len(), "speed rows"),
        (Rule::Plateau, rows.len(), "speed rows"),
        (Rule::Sign, points.points.len(), "entries"),
    ]
}

/// One finding per speed row and rule: the pairs whose command falls, does not change, or occurs twice.
fn monotone(speed: f64, row: &[CommandPoint], findings: &mut Vec<RuleBreach>) {
    let at = || format!("speed {speed}");
    let text = |pairs: &[(CommandPoint, CommandPoint)]| {
        let shown = pairs.iter().take(3).map(|(a, b)| format!("{} → {} at acceleration {} → {}", a.command, b.command, a.accel, b.accel));
        let more = pairs.len().saturating_sub(3);
        let more = if more > 0 { format!(", and {more} more") } else { String::new() };
        format!("{}{more}", shown.collect::<Vec<_>>().join(", "))
    };
    let pairs = row.windows(2).map(|w| (w[0], w[1]));
    let (twice, pairs): (Vec<_>, Vec<_>) = pairs.partition(|(a, b)| a.accel == b.accel);
    let falling: Vec<_> = pairs.iter().copied().filter(|(a, b)| b.command < a.command).collect();
    let level: Vec<_> = pairs.iter().copied().filter(|(a, b)| b.command == a.command).collect();
    for (rule, severity, found, what) in [
        (Rule::Duplicate, Severity::Warning, twice, "the same acceleration twice: "),
        (Rule::NotMonotone, Severity::Error, falling, "more acceleration for less command: "),
        (Rule::Plateau, Severity::Warning, level, "one command for several accelerations: "),
    ] {
        if let Some((_, first)) = found.first() {
            let what = format!("{what}{}", text(&found));
            findings.push(RuleBreach::at(rule, severity, at(), what).on(Some(first.line), 0));
        }
    }
}

fn on(row: &[CommandPoint], finding: RuleBreach) -> RuleBreach {
    finding.on(row.first().map(|p| p.line), 0)
}
