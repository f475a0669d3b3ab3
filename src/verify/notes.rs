//! What failed or was left out, in words, and scenarios that are added to a verdict.

use crate::verify::round_trip::RoundTripVerdict;
use crate::verify::verdict::{MapVerdict, ScenarioVerdict, Status};

impl MapVerdict {
    /// The verdict with further scenarios that were judged on the same map, such as manoeuvres, and a note on them. It passes only if they
    /// do not fail.
    #[must_use]
    pub fn with_scenarios(mut self, scenarios: Vec<ScenarioVerdict>, note: Option<String>) -> Self {
        // the notes on the scenarios come first; what follows them stays
        let before = notes(&self.forced, &self.round_trip, &self.scenarios).len();
        let others = self.notes.split_off(before.min(self.notes.len()));
        self.scenarios.extend(scenarios);
        self.notes = notes(&self.forced, &self.round_trip, &self.scenarios);
        self.notes.extend(others);
        self.notes.extend(note);
        if self.scenarios.iter().any(|s| s.status == Status::Fail) {
            self.status = Status::Fail;
        }
        self
    }
}

/// Notes on files that were let pass, on the round trips and on the scenarios.
pub(crate) fn notes(forced: &[String], trips: &[RoundTripVerdict], scenarios: &[ScenarioVerdict]) -> Vec<String> {
    let mut notes = forced.to_vec();
    if trips.is_empty() {
        notes.push("no gear has both a Table 1 and a Table 2 at the test angle: no round trip".to_owned());
    }
    for trip in trips {
        let map = trip.name();
        if let Some(w) = trip.worst.filter(|_| trip.failed > 0) {
            notes.push(format!(
                "{map}: {} of {} places do not survive the round trip; worst at {} m/s, {:.3} m/s²: {:.2} N·m instead of {:.2} N·m",
                trip.failed, trip.places, w.speed_mps, w.accel_mps2, w.torque_nm, w.right_torque_nm
            ));
        }
        if !trip.failed_rows_mps.is_empty() {
            notes.push(format!("{map}: whole rows are off, at {:?} m/s", trip.failed_rows_mps));
        }
        if !trip.starts_at_zero {
            notes.push(format!("{map}: the speed axis does not start at 0, where every pivot starts"));
        }
        if trip.places == 0 {
            notes.push(format!("{map}: Table 1 has no measured cell that Table 2 covers"));
        }
    }
    let named = |status: Status| scenarios.iter().filter(|s| s.status == status).map(|s| s.name.as_str()).collect::<Vec<_>>().join(", ");
    let (failed, untested) = (named(Status::Fail), named(Status::NotTested));
    if !failed.is_empty() {
        notes.push(format!("failed: {failed}"));
    }
    if !untested.is_empty() {
        notes.push(format!("not tested: {untested}"));
    }
    let mut reasons: Vec<&String> = scenarios.iter().filter(|s| s.status == Status::NotTested).flat_map(|s| &s.notes).collect();
    reasons.dedup();
    notes.extend(reasons.into_iter().cloned());
    notes
}
