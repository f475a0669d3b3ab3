//! Notes on failures and on skipped scenarios; and scenarios that are added to a verdict.

use crate::verify::round_trip::RoundTripVerdict;
use crate::verify::verdict::{MapVerdict, ScenarioVerdict, Status};

impl MapVerdict {
    /// The verdict with further scenarios that were judged on the same map, such as manoeuvres, and a note on them. It passes only if they
    /// do not fail.
    #[must_use]
    pub fn with_scenarios(mut self, scenarios: Vec<ScenarioVerdict>, note: Option<String>) -> Self {
        // the notes on the scenarios come first; later notes stay
        let before = notes(&self.forced, &self.round_trip, &self.scenarios).len();
        let others = self.notes.split_off(before.min(self.notes.len()));
        self.scenarios.extend(scenarios);
        self.notes = notes(&self.forced, &self.round_trip, &self.scenarios);
        self.notes.extend(others);
        self.notes.extend(note);
        self.concluded()
    }
}

/// Notes on accepted mismatches, on the round trips and on the scenarios.
pub(crate) fn notes(forced: &[String], trips: &[RoundTripVerdict], scenarios: &[ScenarioVerdict]) -> Vec<String> {
    let mut notes = forced.to_vec();
    if trips.is_empty() {
        notes.push("no gear has both a Table 1 and a Table 2 at the test angle: no round trip".to_owned());
    }
    for trip in trips {
        let map = trip.name();
        if let Some(w) = trip.worst.filter(|_| trip.failed > 0) {
            notes.push(format!(
                "{map}: {} of {} places break the limit of the round trip; worst at {} m/s, {:.3} m/s²: {:.2} N·m instead of {:.2} N·m",
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

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::map::Gear;
    use crate::verify::scenario::Class;
    use crate::verify::verdict::FORMAT;
    use crate::verify::{PlantSummary, RoundTripLimit, Spread};

    fn scenario(name: &str, status: Status) -> ScenarioVerdict {
        ScenarioVerdict { status, ..ScenarioVerdict::not_tested(name, "", Class::Turn, format!("not tested: {name} lacks a table")) }
    }

    fn verdict(scenarios: Vec<ScenarioVerdict>) -> MapVerdict {
        let mut all = notes(&["let pass".to_owned()], &[], &scenarios);
        all.push("pivots: a note at the end".to_owned());
        MapVerdict {
            format: FORMAT.to_owned(),
            format_version: 1,
            tool_version: String::new(),
            generation: String::new(),
            status: Status::Pass,
            reason: String::new(),
            scope: Vec::new(),
            checks: Vec::new(),
            accepted: Vec::new(),
            basis: None,
            notes: all,
            table2_csv_sha256: Vec::new(),
            forced: vec!["let pass".to_owned()],
            plant: PlantSummary::default(),
            draws: 0,
            comparison_draws: 0,
            seed: 1,
            spread: Spread::default(),
            controller_settings: None,
            controller_command: None,
            controller: serde_json::Value::Null,
            round_trip_limit: RoundTripLimit { at_most_mps2: 0.1, row_mean_at_most_mps2: 0.1, standard_errors: 3.0, reason: String::new() },
            limits: Vec::new(),
            round_trip: Vec::new(),
            scenarios,
            comparison: None,
            lateral_sha256: None,
            manoeuvre_vehicle_sha256: None,
            replayed: Vec::new(),
            pivots: Vec::new(),
        }
    }

    fn sound_trip() -> RoundTripVerdict {
        RoundTripVerdict {
            gear: Gear::Forward,
            wheel_angle_deg: None,
            places: 1,
            beyond_axes: 0,
            failed: 0,
            failed_rows_mps: Vec::new(),
            starts_at_zero: true,
            rms_mps2: 0.0,
            worst: None,
            pass: true,
        }
    }

    #[test]
    fn added_scenarios_are_noted_as_if_they_had_been_there_from_the_start() {
        let (left, right) = (scenario("left", Status::Pass), scenario("right", Status::NotTested));
        let (parking, u_turn) = (scenario("parking", Status::Fail), scenario("u-turn", Status::NotTested));
        let added =
            verdict(vec![left.clone(), right.clone()]).with_scenarios(vec![parking.clone(), u_turn.clone()], Some("by maps".to_owned()));
        let whole = verdict(vec![left, right, parking, u_turn]);
        assert_eq!(added.notes[..added.notes.len() - 1], whole.notes);
        assert!(added.notes.contains(&"failed: parking".to_owned()) && added.notes.contains(&"not tested: right, u-turn".to_owned()));
        assert_eq!(added.notes.last().map(String::as_str), Some("by maps"));
        assert_eq!((added.status, added.scenarios.len()), (Status::Fail, 4));
    }

    #[test]
    fn nothing_added_changes_nothing_and_no_addition_makes_a_bad_map_good() {
        let before = MapVerdict { draws: 4, round_trip: vec![sound_trip()], ..verdict(vec![scenario("left-90", Status::Pass)]) };
        let before = before.with_scenarios(Vec::new(), None);
        assert_eq!(
            (before.status, before.reason.as_str()),
            (Status::Pass, "pass: forward gear only, left turns only, 1 of 26 pivots only")
        );
        assert_eq!(before.clone().with_scenarios(Vec::new(), None), before);
        let bad = MapVerdict { status: Status::Fail, ..before };
        assert_eq!(bad.with_scenarios(vec![scenario("parking", Status::Pass)], None).status, Status::Fail);
    }
}
