//! From the parts of a verdict to its status, its scope, and its first line: the cause with figure and limit.

use crate::check::campaign_checks::all_checks;
use crate::map::{Check, Gear, Table1File};
use crate::verify::basis::Basis;
use crate::verify::gate::LimitCheck;
use crate::verify::notes::notes;
use crate::verify::pivots_check::pivots_check;
use crate::verify::replay_check::replay_check;
use crate::verify::round_trip::RoundTripVerdict;
use crate::verify::scenario::Scenario;
use crate::verify::verdict::{MapVerdict, ScenarioVerdict, Status};

impl MapVerdict {
    /// The verdict as one line: pass with its scope, or the cause with figure and limit.
    pub fn headline(&self) -> String {
        match self.status {
            Status::Rejected => {
                let mut standing = standing(&self.checks, &self.accepted);
                let Some(first) = standing.next() else { return "rejected".to_owned() };
                let more = standing.count();
                format!("rejected by {}: {}{}", first.name, first.text(), and_more(more, "objection"))
            }
            Status::Fail => format!("FAIL: {}{}", self.failure(), self.overruled()),
            Status::NotJudged | Status::NotTested => {
                format!("not judged: {}", self.lack().unwrap_or_else(|| "nothing was tested".to_owned()))
            }
            Status::Pass => {
                let scope = if self.scope.is_empty() { String::new() } else { format!(": {}", self.scope.join(", ")) };
                let assumed = self.basis.as_ref().map(|b| b.assumed.join(", ")).filter(|a| !a.is_empty());
                format!("pass{scope}{}{}", assumed.map_or(String::new(), |a| format!("; assumed: {a}")), self.overruled())
            }
        }
    }

    /// The verdict with the checks of `table1` and the basis from its campaign; a verdict of an older version has neither.
    pub(crate) fn on(mut self, table1: &Table1File) -> Self {
        self.checks = all_checks(table1);
        self.checks.extend(replay_check(&self.replayed));
        self.checks.extend(pivots_check(&self.pivots));
        self.basis = Some(Basis::new(table1));
        self.concluded()
    }

    /// The verdict with the status, the scope and the first line that follow from its parts. A fail stays a fail.
    pub(crate) fn concluded(mut self) -> Self {
        let broken = self.round_trip.is_empty()
            || self.round_trip.iter().any(|t| !t.pass)
            || self.scenarios.iter().any(|s| s.status == Status::Fail);
        self.status = if standing(&self.checks, &self.accepted).next().is_some() {
            Status::Rejected
        } else if broken || self.status == Status::Fail {
            Status::Fail
        } else if self.lack().is_some() {
            Status::NotJudged
        } else {
            Status::Pass
        };
        self.scope = self.narrowed();
        self.reason = self.headline();
        self
    }

    /// The checks that a person has overruled, as the end of a line.
    fn overruled(&self) -> String {
        let overruled: Vec<String> =
            self.checks.iter().filter(|c| self.accepted.contains(&c.name)).map(|c| format!("{} ({})", c.name, c.meaning)).collect();
        if overruled.is_empty() { String::new() } else { format!("; overruled by hand: {}", overruled.join(", ")) }
    }

    /// What is missing to judge; `None` if nothing is.
    fn lack(&self) -> Option<String> {
        if let Some(reason) = self.basis.as_ref().and_then(|b| b.unjudged(Gear::Forward)) {
            return Some(reason.to_owned());
        }
        if self.draws == 0 {
            return Some("no perturbed vehicle was driven, at least 1 is needed; give more draws".to_owned());
        }
        if tested(&self.scenarios).next().is_none() {
            let reason = self.scenarios.iter().find_map(|s| s.notes.first()).map_or(String::new(), |note| format!(" ({note})"));
            return Some(format!("0 of {} scenarios were tested, at least 1 is needed{reason}", self.scenarios.len()));
        }
        None
    }

    /// What the tested scenarios leave out.
    fn narrowed(&self) -> Vec<String> {
        let all = Scenario::all();
        let named = |s: &ScenarioVerdict| all.iter().find(|known| known.name == s.name).cloned();
        let pivots: Vec<Scenario> = tested(&self.scenarios).filter_map(|s| named(s).or_else(|| Scenario::of_turn(&s.name))).collect();
        let mut others: Vec<f64> = tested(&self.scenarios).filter_map(|s| s.wheel_angle_deg).collect();
        others.sort_unstable_by(f64::total_cmp);
        others.dedup();
        let angle = self.basis.as_ref().map(|b| {
            let all: Vec<String> = std::iter::once(b.test_angle_deg).chain(others).map(|angle| format!("{angle}°")).collect();
            format!("{} only", all.join(" and "))
        });
        let about: Option<String> = tested(&self.scenarios).find_map(|s| s.about.as_ref()).map(|about| format!("manoeuvres prove {about}"));
        if pivots.is_empty() {
            let names: Vec<&str> = tested(&self.scenarios).map(|s| s.name.as_str()).collect();
            let only = (!names.is_empty()).then(|| format!("{} only, no pivot", names.join(", ")));
            return only.into_iter().chain(about).collect();
        }
        let mut scope: Vec<String> = angle.into_iter().collect();
        if !pivots.iter().any(Scenario::needs_reverse) {
            scope.push("forward gear only".to_owned());
        }
        for (side, sign) in [("left", -1.0), ("right", 1.0)] {
            if !pivots.iter().any(|s| s.turns_deg.iter().any(|t| t * sign > 0.0)) {
                scope.push(format!("{side} turns only"));
            }
        }
        let judged = self.scenarios.iter().filter_map(named).count();
        if judged == 0 {
            let names: Vec<&str> = pivots.iter().map(|s| s.name.as_str()).collect();
            scope.push(format!("{} only", names.join(", ")));
        } else if judged < all.len() {
            scope.push(format!("{judged} of {} pivots only", all.len()));
        }
        scope.extend(about);
        scope.extend(self.controller_command.as_ref().map(|command| format!("driven by {}", command.label())));
        scope
    }

    /// The cause of a fail, with figure and limit.
    fn failure(&self) -> String {
        let of_trips = |trips: &[RoundTripVerdict]| notes(&[], trips, &[]).into_iter().next();
        if self.round_trip.is_empty() {
            return of_trips(&[]).unwrap_or_default();
        }
        if let Some(trip) = self.round_trip.iter().find(|t| !t.pass) {
            if let Some(w) = trip.worst.filter(|_| trip.failed > 0) {
                return format!(
                    "round trip, {}: {:.3} m/s² at {} m/s and {:.3} m/s², {:.3} is allowed; Table 2 is not the inverse of Table 1 there",
                    trip.name(),
                    w.error_mps2.abs(),
                    w.speed_mps,
                    w.accel_mps2,
                    w.limit_mps2
                );
            }
            return of_trips(std::slice::from_ref(trip)).unwrap_or_else(|| format!("round trip, {}", trip.name()));
        }
        let mut failed = self.scenarios.iter().filter(|s| s.status == Status::Fail);
        let Some(first) = failed.next() else { return "a limit is broken".to_owned() };
        let more = failed.count();
        if let Some(fault) = first.controller_fault() {
            return format!("{}: the controller broke: {fault}{}", first.name, and_more(more, "scenario"));
        }
        let worst = first.checks.iter().filter(|c| !c.pass).max_by(|a, b| excess(a).total_cmp(&excess(b)));
        let cause = worst.map_or_else(|| "a limit is broken".to_owned(), words);
        format!("{}: {cause}{}", first.name, and_more(more, "scenario"))
    }
}

/// The objections that nobody has overruled.
pub(crate) fn standing<'a>(checks: &'a [Check], accepted: &'a [String]) -> impl Iterator<Item = &'a Check> {
    checks.iter().filter(|c| c.objects() && !accepted.contains(&c.name))
}

fn tested(scenarios: &[ScenarioVerdict]) -> impl Iterator<Item = &ScenarioVerdict> {
    scenarios.iter().filter(|s| s.status != Status::NotTested)
}

fn and_more(count: usize, what: &str) -> String {
    match count {
        0 => String::new(),
        1 => format!(" (and 1 more {what})"),
        n => format!(" (and {n} more {what}s)"),
    }
}

/// How far a value is beyond its limit, relative to the limit.
fn excess(check: &LimitCheck) -> f64 {
    let relative = |limit: f64, value: f64| (value - limit).abs() / limit.abs().max(1e-9);
    check.value.zip(check.at_most.or(check.at_least)).map_or(0.0, |(value, limit)| relative(limit, value))
}

fn words(check: &LimitCheck) -> String {
    let value = check.value.map_or("none".to_owned(), |v| check.metric.with_unit(v));
    let limit = match (check.at_most, check.at_least) {
        (Some(most), _) => format!("at most {} is allowed", check.metric.with_unit(most)),
        (None, Some(least)) => format!("at least {} is needed", check.metric.with_unit(least)),
        (None, None) => String::new(),
    };
    format!("{} ({}) is {value}, {limit}", check.metric.title(), check.statistic.title())
}
