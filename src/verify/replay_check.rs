//! Recorded runs against the identified plant → a check of the verdict: the evidence that is independent of the fit.
//!
//! The figure is that of `unseen-runs`: the constant acceleration that the replay of a run lacks, as a share of the acceleration by the
//! largest torque, root mean square over the runs of a log. Logs that the fit has not used count alone, if there are any.

use crate::map::{Check, CheckOutcome};
use crate::verify::replayed::ReplayedRun;
use crate::verify::verdict::MapVerdict;
use std::collections::BTreeMap;

/// Name of the check.
pub(crate) const REPLAY: &str = "replay";
/// Shares for a warning and for an objection. Another day adds a warmer gear and another floor to the 0.3 % of good campaigns.
const LIMITS: [f64; 2] = [0.02, 0.04];
/// Fewest runs of a log.
const FEWEST_RUNS: usize = 3;

impl MapVerdict {
    /// The verdict with recorded runs that the plant has replayed: the log that departs most is a check, whose objection a person overrules by
    /// its name in `accept`.
    #[must_use]
    pub(crate) fn with_replayed(mut self, runs: Vec<ReplayedRun>, accept: &[String]) -> Self {
        self.with_check(replay_check(&runs), accept);
        self.replayed = runs;
        self.concluded()
    }

    /// Adds the check on recorded logs, overruled if it objects and `accept` names it.
    pub(crate) fn with_check(&mut self, check: Option<Check>, accept: &[String]) {
        let Some(check) = check else { return };
        if check.objects() && accept.contains(&check.name) && !self.accepted.contains(&check.name) {
            self.accepted.push(check.name.clone());
            self.notes.retain(|note| *note != nothing_to_accept(&check.name));
        }
        self.checks.push(check);
    }
}

/// The note on a check that is to be accepted and does not object.
pub(crate) fn nothing_to_accept(name: &str) -> String {
    format!("{name} is no objection: nothing to accept")
}

/// The check; `None` with few runs.
pub(crate) fn replay_check(runs: &[ReplayedRun]) -> Option<Check> {
    let any_held_out = runs.iter().any(|r| !r.fitted);
    let mut logs: BTreeMap<&str, Vec<f64>> = BTreeMap::new();
    for run in runs.iter().filter(|r| !(any_held_out && r.fitted)) {
        logs.entry(&run.file).or_default().push(run.missing_share);
    }
    let rms = |shares: &[f64]| (shares.iter().map(|s| s * s).sum::<f64>() / shares.len() as f64).sqrt();
    let enough = logs.iter().filter(|(_, shares)| shares.len() >= FEWEST_RUNS);
    let (file, shares) = enough.max_by(|a, b| rms(a.1).total_cmp(&rms(b.1)))?;
    let (figure, mean) = (rms(shares), shares.iter().sum::<f64>() / shares.len() as f64);
    let (outcome, limit) = CheckOutcome::graded(figure, LIMITS);
    let used = if any_held_out { "that the fit has not used" } else { "of the fit" };
    let meaning = format!(
        "the {} runs of {file}, {used}, accelerate by {:.1} % of the largest acceleration more or less than the plant (on average {:+.1} %), {:.0} % is allowed",
        shares.len(),
        100.0 * figure,
        100.0 * mean,
        100.0 * limit
    );
    let check = Check::passed(REPLAY, (100.0 * figure, 100.0 * limit, "%"), meaning);
    Some(check.judged(outcome, "look for another load, floor, unit, sign or clock in that log, or fit it too"))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::map::Gear;
    use crate::verify::verdict::Status;

    fn runs(file: &str, fitted: bool, shares: &[f64]) -> Vec<ReplayedRun> {
        let run = |missing_share: &f64| ReplayedRun {
            file: file.to_owned(),
            fitted,
            gear: Gear::Forward,
            from_s: 0.0,
            seconds: 2.0,
            samples: 100,
            r_squared: Some(0.99),
            rmse_mps: 0.01,
            max_mps: 0.02,
            missing_share: *missing_share,
        };
        shares.iter().map(run).collect()
    }

    #[test]
    fn the_log_that_departs_most_decides_and_runs_of_the_fit_count_only_alone() {
        let good = runs("good.mcap", false, &[0.004, -0.003, 0.005]);
        assert_eq!(replay_check(&good).unwrap().outcome, CheckOutcome::Passed);
        let loaded = [good.clone(), runs("loaded.mcap", false, &[-0.05, -0.06, -0.055])].concat();
        let check = replay_check(&loaded).unwrap();
        assert!(
            check.objects() && check.meaning.contains("runs of loaded.mcap, that the fit has not used") && check.meaning.contains("-5.5 %"),
            "{check:?}"
        );
        let fitted = runs("fitted.mcap", true, &[0.03, -0.03, 0.03]);
        assert_eq!(replay_check(&[good, fitted.clone()].concat()).unwrap().outcome, CheckOutcome::Passed);
        assert_eq!(replay_check(&fitted).unwrap().outcome, CheckOutcome::Warning);
        assert!(replay_check(&fitted[..2]).is_none() && replay_check(&[]).is_none());
    }

    #[test]
    fn an_objection_of_the_replay_rejects_until_it_is_accepted_and_no_other_replay_is_accepted() {
        let verdict = || -> MapVerdict { serde_json::from_str(include_str!("../../maps/verify.json")).unwrap() };
        let (loaded, accept) = (runs("loaded.mcap", false, &[-0.05, -0.06, -0.055]), [REPLAY.to_owned()]);
        let rejected = verdict().with_replayed(loaded.clone(), &[]);
        assert!(rejected.status == Status::Rejected && rejected.reason.starts_with("rejected by replay: "), "{}", rejected.reason);
        let accepted = verdict().with_replayed(loaded, &accept);
        assert!(accepted.status == Status::Pass && accepted.accepted == accept, "{}", accepted.reason);
        let good = verdict().with_replayed(runs("good.mcap", false, &[0.004, -0.003, 0.005]), &accept);
        assert!(good.status == Status::Pass && good.accepted.is_empty());
    }
}
