//! Recorded pivots in operation against the map → a check of the verdict: what the deployed map did on the vehicle.
//!
//! The figure is the RMS of actual − desired acceleration over the RMS of the desired one, without the part of the former that the noise of
//! the readings explains: of all logs of a gear together, or of one log that is long enough and departs more.

use crate::map::{Check, CheckOutcome, Gear};
use crate::verify::recorded_pivots::RecordedPivots;
use crate::verify::verdict::MapVerdict;

/// Name of the check.
pub(crate) const PIVOTS: &str = "pivots";
/// Shares for a warning and for an objection. With its own map, a vehicle makes 3 to 18 % by the speed loop's reaction to noise and to the floor
/// (26 drives of four turns: two scrubbers, the sweeper); with a map of 30 % more or less mass and inertia 23 to 30 % (18 drives).
const LIMITS: [f64; 2] = [0.2, 0.22];
/// A log that is compared for less long counts with the others only [s]: one short pivot is mostly start and stop.
const ALONE_S: f64 = 3.0;

impl MapVerdict {
    /// The verdict with recorded pivots: the log and gear that depart most are a check, whose objection a person overrules by its name in
    /// `accept`.
    #[must_use]
    pub(crate) fn with_pivots(mut self, pivots: Vec<RecordedPivots>, accept: &[String]) -> Self {
        self.with_check(pivots_check(&pivots), accept);
        self.pivots = pivots;
        self.concluded()
    }
}

/// Logs of one gear that are judged together.
struct Together<'a> {
    logs: Vec<&'a RecordedPivots>,
}

impl Together<'_> {
    /// The mean over the compared time.
    fn mean(&self, of: impl Fn(&RecordedPivots) -> f64) -> f64 {
        self.logs.iter().map(|p| p.seconds * of(p)).sum::<f64>() / self.seconds()
    }

    fn seconds(&self) -> f64 {
        self.logs.iter().map(|p| p.seconds).sum()
    }

    /// RMS of actual − desired without the noise of the readings, over the RMS of the desired acceleration.
    fn share(&self) -> f64 {
        let desired = self.mean(|p| p.desired_rms_mps2.powi(2));
        (self.mean(|p| (p.rms_mps2.powi(2) - p.noise_mps2.powi(2)).max(0.0)) / desired.max(1e-12)).sqrt()
    }

    fn name(&self) -> String {
        match self.logs[..] {
            [one] => one.file.clone(),
            _ => format!("{} logs", self.logs.len()),
        }
    }
}

/// The check; `None` without recorded pivots.
pub(crate) fn pivots_check(pivots: &[RecordedPivots]) -> Option<Check> {
    let of_gear = Gear::ALL.map(|gear| Together { logs: pivots.iter().filter(|p| p.gear == gear).collect() });
    let alone = pivots.iter().filter(|p| p.seconds >= ALONE_S).map(|p| Together { logs: vec![p] });
    let judged = of_gear.into_iter().filter(|t| !t.logs.is_empty()).chain(alone);
    let worst = judged.max_by(|a, b| a.share().total_cmp(&b.share()))?;
    let (outcome, limit) = CheckOutcome::graded(worst.share(), LIMITS);
    let meaning = format!(
        "in {:.0} s of pivots in {} gear in {} the acceleration departs from the desired one by {:.0} % of it (it is {:.2} times the desired one, \
         and on average {:+.1} % of the largest one off), {:.0} % is allowed",
        worst.seconds(),
        worst.logs[0].gear,
        worst.name(),
        100.0 * worst.share(),
        worst.mean(|p| p.gain),
        100.0 * worst.mean(|p| p.mean_mps2 / p.reach_mps2),
        100.0 * limit
    );
    let check = Check::passed(PIVOTS, (100.0 * worst.share(), 100.0 * limit, "%"), meaning);
    Some(
        check.judged(
            outcome,
            "the vehicle carries another load, stands on another floor or drives with another map: drive and fit a new log",
        ),
    )
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::verify::recorded_pivots::recorded_pivots;
    use crate::verify::recorded_pivots::tests::driven;
    use crate::verify::verdict::Status;

    fn pivots(file: &str, seconds: f64, rms_mps2: f64) -> RecordedPivots {
        RecordedPivots {
            file: file.to_owned(),
            gear: Gear::Forward,
            seconds,
            mean_mps2: -0.01,
            rms_mps2,
            noise_mps2: 0.0,
            desired_rms_mps2: 0.3,
            gain: 0.9,
            reach_mps2: 2.0,
        }
    }

    #[test]
    fn the_vehicle_of_the_map_passes_and_one_with_30_percent_more_inertia_is_an_objection() {
        let check = |heavier: f64| {
            let (table1, recording, survey) = driven(heavier);
            pivots_check(&recorded_pivots(&table1, &recording, &survey).unwrap()).unwrap()
        };
        let (right, heavy) = (check(1.0), check(1.3));
        assert_eq!(right.outcome, CheckOutcome::Passed, "{}", right.text());
        assert!(heavy.objects() && heavy.meaning.contains("pivots in forward gear in shift.mcap"), "{}", heavy.text());
    }

    #[test]
    fn a_short_log_counts_with_the_others_and_a_long_one_alone() {
        let good = || pivots("good.mcap", 60.0, 0.03);
        assert!(pivots_check(&[]).is_none());
        let short = pivots_check(&[good(), pivots("short.mcap", 2.0, 0.1)]).unwrap();
        assert!(short.outcome == CheckOutcome::Passed && short.meaning.contains("in 2 logs"), "{}", short.meaning);
        let long = pivots_check(&[good(), pivots("loaded.mcap", 5.0, 0.1)]).unwrap();
        assert!(long.objects() && long.meaning.contains("loaded.mcap") && long.meaning.contains("-0.5 %"), "{}", long.meaning);
    }

    #[test]
    fn an_objection_of_the_pivots_rejects_until_it_is_accepted() {
        let verdict = || -> MapVerdict { serde_json::from_str(include_str!("../../maps/verify.json")).unwrap() };
        let (loaded, accept) = (vec![pivots("loaded.mcap", 5.0, 0.1)], [PIVOTS.to_owned()]);
        let rejected = verdict().with_pivots(loaded.clone(), &[]);
        assert!(rejected.status == Status::Rejected && rejected.reason.starts_with("rejected by pivots: "), "{}", rejected.reason);
        let kept = verdict().added_to(&rejected);
        assert!(kept.status == Status::Rejected && kept.pivots == loaded, "a later verdict keeps what was seen on the vehicle");
        let accepted = verdict().with_pivots(loaded, &accept);
        assert!(accepted.status == Status::Pass && accepted.accepted == accept, "{}", accepted.reason);
    }
}
