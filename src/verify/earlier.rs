//! A verdict added to the one that the same map already has: manoeuvres after pivots, small turns after large ones.
//!
//! What was driven before and is not driven now stays, so that no order of commands loses a failure. A failure goes only when the same
//! scenario is driven again on at least as many perturbed vehicles.

use crate::verify::pivots_check::PIVOTS;
use crate::verify::replay_check::REPLAY;
use crate::verify::scenario::Scenario;
use crate::verify::verdict::{MapVerdict, ScenarioVerdict, Status};

impl MapVerdict {
    /// This verdict with what `earlier` judged of the same map and this verdict does not. Of another map, another controller, a process of the user's, other limits or
    /// another version of the file, nothing is kept.
    #[must_use]
    pub(crate) fn added_to(mut self, earlier: &Self) -> Self {
        if !self.judges_as(earlier) {
            return self;
        }
        let mut driven = std::mem::take(&mut self.scenarios);
        let mut scenarios = Vec::new();
        let same_manoeuvres = self.drives_manoeuvres_as(earlier);
        for before in earlier.scenarios.iter().filter(|s| s.class.is_pivot() || same_manoeuvres) {
            let now = driven.iter().position(|s| s.name == before.name).map(|k| driven.remove(k));
            scenarios.push(match now {
                Some(now) if !outlasts(before, &now) => now,
                _ => before.clone(),
            });
        }
        // new pivots follow the pivots before them, manoeuvres the manoeuvres
        scenarios.append(&mut driven);
        scenarios.sort_by_key(order);
        if !self.drives_pivots() && earlier.scenarios.iter().any(|s| s.class.is_pivot()) {
            self.draws = earlier.draws;
        }
        if same_manoeuvres {
            self.manoeuvre_vehicle_sha256 = self.manoeuvre_vehicle_sha256.or_else(|| earlier.manoeuvre_vehicle_sha256.clone());
        }
        self.accepted.extend(earlier.accepted.iter().filter(|name| !self.accepted.contains(name)).cloned().collect::<Vec<_>>());
        let replayed = with_earlier(std::mem::take(&mut self.replayed), &earlier.replayed, |r| &r.file);
        let pivots = with_earlier(std::mem::take(&mut self.pivots), &earlier.pivots, |p| &p.file);
        for note in &earlier.notes {
            if !self.notes.contains(note) {
                self.notes.push(note.clone());
            }
        }
        let accepted = self.accepted.clone();
        self.checks.retain(|check| check.name != REPLAY && check.name != PIVOTS);
        self.with_scenarios(scenarios, None).with_replayed(replayed, &accepted).with_pivots(pivots, &accepted)
    }

    /// Whether both judge the same map in the same way.
    fn judges_as(&self, other: &Self) -> bool {
        self.generation == other.generation
            && !self.generation.is_empty()
            && self.table2_csv_sha256 == other.table2_csv_sha256
            && self.format_version == other.format_version
            && self.forced == other.forced
            && self.plant == other.plant
            && self.spread == other.spread
            && self.controller_settings == other.controller_settings
            // the same command may start another program than before
            && self.controller_command.is_none()
            && other.controller_command.is_none()
            && self.controller == other.controller
            && self.limits == other.limits
            && self.round_trip_limit == other.round_trip_limit
    }

    /// Whether the manoeuvres that an earlier verdict judged still hold: with this lateral table, and by the vehicle that drives now, if one does.
    fn drives_manoeuvres_as(&self, earlier: &Self) -> bool {
        let same_vehicle = self.manoeuvre_vehicle_sha256.is_none() || self.manoeuvre_vehicle_sha256 == earlier.manoeuvre_vehicle_sha256;
        same_vehicle && self.lateral_sha256 == earlier.lateral_sha256
    }

    fn drives_pivots(&self) -> bool {
        self.scenarios.iter().any(|s| s.class.is_pivot())
    }
}

/// What earlier logs gave, without the logs that were given again, and then what these give now.
fn with_earlier<T: Clone>(now: Vec<T>, earlier: &[T], file: impl Fn(&T) -> &String) -> Vec<T> {
    let kept = earlier.iter().filter(|before| now.iter().all(|again| file(again) != file(before)));
    let mut all: Vec<T> = kept.cloned().collect();
    all.extend(now);
    all
}

/// Whether an earlier failure stands against a pass on fewer perturbed vehicles. One in another scene of this name does not.
fn outlasts(before: &ScenarioVerdict, now: &ScenarioVerdict) -> bool {
    before.scene == now.scene && before.status == Status::Fail && now.status != Status::Fail && now.draws < before.draws
}

/// Place in the display order: pivots of the list, other turns, pivots at other wheel angles, manoeuvres.
fn order(scenario: &ScenarioVerdict) -> (usize, usize) {
    let known = Scenario::all().iter().position(|s| s.name == scenario.name);
    match (known, scenario.class.is_pivot(), scenario.wheel_angle_deg) {
        (Some(place), ..) => (0, place),
        (None, true, None) => (1, 0),
        (None, true, Some(_)) => (2, 0),
        (None, false, _) => (3, 0),
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::verify::Class;

    fn verdict() -> MapVerdict {
        serde_json::from_str(include_str!("../../maps/verify.json")).unwrap()
    }

    fn scenario(name: &str, class: Class, status: Status, draws: usize) -> ScenarioVerdict {
        ScenarioVerdict { status, draws: Some(draws), ..ScenarioVerdict::not_tested(name, "", class, String::new()) }
    }

    #[test]
    fn manoeuvres_and_small_turns_are_added_and_stand_in_the_usual_order() {
        let all = verdict();
        let later = |scenarios| MapVerdict { scenarios, draws: 20, ..all.clone() };
        let parked = later(vec![scenario("parking", Class::Parking, Status::Pass, 20)]).added_to(&all);
        assert_eq!((parked.scenarios.len(), parked.status, parked.draws), (all.scenarios.len() + 1, Status::Pass, all.draws));
        let small = later(vec![scenario("left-5", Class::Turn, Status::Pass, 200)]).added_to(&parked);
        let names: Vec<&str> = small.scenarios.iter().map(|s| s.name.as_str()).collect();
        assert_eq!(names[names.len() - 2..], ["left-5", "parking"]);
        assert_eq!(names[..all.scenarios.len()], all.scenarios.iter().map(|s| s.name.as_str()).collect::<Vec<_>>());
    }

    #[test]
    fn a_failure_stays_until_it_is_driven_again_on_as_many_vehicles() {
        let all = verdict();
        let with = |status, draws| MapVerdict { scenarios: vec![scenario("left-90", Class::Turn, status, draws)], ..all.clone() };
        let failed = with(Status::Fail, 200).concluded();
        let quick = with(Status::Pass, 1).added_to(&failed);
        assert_eq!((quick.status, quick.scenarios[0].status), (Status::Fail, Status::Fail));
        assert_eq!(with(Status::Pass, 200).added_to(&quick).status, Status::Pass);
        let other = MapVerdict { scenarios: vec![scenario("left-30", Class::Turn, Status::Pass, 200)], ..all.clone() };
        assert_eq!(other.added_to(&failed).status, Status::Fail, "another scenario does not mend it");
    }

    #[test]
    fn nothing_is_kept_of_another_map_or_other_limits() {
        let all = verdict();
        let now = || MapVerdict { scenarios: vec![scenario("left-90", Class::Turn, Status::Pass, 200)], ..all.clone() };
        let kept = |earlier: MapVerdict| now().added_to(&earlier).scenarios.len();
        assert_eq!(kept(MapVerdict { generation: "another".to_owned(), ..all.clone() }), 1);
        assert_eq!(kept(MapVerdict { limits: Vec::new(), ..all.clone() }), 1);
        let process = Some(crate::verify::ControllerCommand::new("a b", 10).unwrap());
        assert_eq!(kept(MapVerdict { controller_command: process, ..all.clone() }), 1);
        assert_eq!(kept(all.clone()), all.scenarios.len());
        let parked = MapVerdict { scenarios: vec![scenario("parking", Class::Parking, Status::Pass, 20)], ..all.clone() };
        let of = |vehicle: &str| MapVerdict { manoeuvre_vehicle_sha256: Some(vehicle.to_owned()), ..parked.clone() };
        let turned = MapVerdict { scenarios: vec![scenario("u-turn", Class::UTurn, Status::Pass, 20)], ..of("sweeper") };
        assert_eq!(turned.clone().added_to(&of("sweeper")).scenarios.len(), 2);
        assert_eq!(turned.added_to(&of("scrubber")).scenarios.len(), 1);
        assert_eq!(now().added_to(&of("scrubber")).scenarios.len(), 2);
        assert_eq!(MapVerdict { lateral_sha256: Some("another".to_owned()), ..now() }.added_to(&of("scrubber")).scenarios.len(), 1);
    }
}
