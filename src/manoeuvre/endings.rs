//! How and where the runs of a manoeuvre ended, in words, and which of them is the worst.

use crate::guidance::route::follower::{DriveStage, Trouble};
use crate::units::RAD_PER_DEG;
use crate::verify::{LimitCheck, ScenarioVerdict, Status, Values};

/// The end of a drive.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct DriveEnd {
    /// Last stage; [`DriveStage::Driving`] if the drive did not end by itself.
    pub(crate) stage: DriveStage,
    /// Number of the leg, from 0.
    pub(crate) leg: usize,
    /// True place of the rear axle's middle [m].
    pub(crate) at_m: [f64; 2],
    /// True heading [rad].
    pub(crate) heading_rad: f64,
    /// Time since the start [s].
    pub(crate) t_s: f64,
}

impl DriveEnd {
    /// Whether the end of the path was reached.
    pub(crate) fn arrived(&self) -> bool {
        self.stage == DriveStage::Arrived
    }

    /// How it ended.
    fn how(&self) -> &'static str {
        match self.stage {
            DriveStage::Arrived => "arrived",
            DriveStage::Failed(Trouble::ObstacleStop) => "emergency stop",
            DriveStage::Failed(Trouble::SpeedLost) => "no speed reading",
            DriveStage::Failed(Trouble::Steering) => "the wheel did not reach its angle",
            DriveStage::Failed(Trouble::Stalled) => "it did not move although it should",
            DriveStage::Failed(Trouble::Heading) => "the heading was not reached in the corrections allowed",
            _ => "it was still under way after 15 minutes",
        }
    }

    /// Where and when it ended.
    fn place(&self) -> String {
        let [x, y] = self.at_m;
        format!("at ({x:.3}, {y:.3}) m, heading {:.2}°, after {:.1} s", self.heading_rad / RAD_PER_DEG, self.t_s)
    }
}

/// What the verdict on a failed manoeuvre says: its nominal run, how many perturbed runs ended how and on which leg, and the worst of them.
pub(crate) fn endings(verdict: &ScenarioVerdict, nominal: &DriveEnd, runs: &[(Values, DriveEnd)]) -> Vec<String> {
    if verdict.status != Status::Fail {
        return Vec::new();
    }
    let mut notes = vec![format!("nominal run: {}, leg {}, {}", nominal.how(), nominal.leg + 1, nominal.place())];
    let mut kinds: Vec<(&str, usize, usize, usize)> = Vec::new();
    for (k, (_, end)) in runs.iter().enumerate() {
        match kinds.iter_mut().find(|kind| (kind.0, kind.1) == (end.how(), end.leg)) {
            Some(kind) => kind.2 += 1,
            None => kinds.push((end.how(), end.leg, 1, k)),
        }
    }
    kinds.sort_by_key(|kind| (std::cmp::Reverse(kind.2), kind.3));
    for (how, leg, count, first) in kinds {
        let example = runs[first].1.place();
        notes.push(format!("{count} of {} perturbed runs: {how}, leg {}; the first is draw {}, {example}", runs.len(), leg + 1, first + 1));
    }
    if let Some(worst) = worst_run(runs.iter().map(|r| &r.0), &verdict.checks) {
        let (values, end) = &runs[worst];
        let broken: Vec<String> = verdict
            .checks
            .iter()
            .filter(|c| !c.pass)
            .filter_map(|c| values.get(c.metric).map(|v| format!("{} {}", c.metric.title(), c.metric.with_unit(v))))
            .collect();
        notes.push(format!("worst draw {}: {}; {}, leg {}, {}", worst + 1, broken.join(", "), end.how(), end.leg + 1, end.place()));
    }
    notes
}

/// The run that is furthest beyond, or least within, the limits; `None` without a run.
pub(crate) fn worst_run<'a>(runs: impl Iterator<Item = &'a Values>, checks: &[LimitCheck]) -> Option<usize> {
    let used = |values: &Values| {
        checks
            .iter()
            .map(|c| match (values.get(c.metric), c.at_most, c.at_least) {
                (Some(value), Some(most), _) if most > 0.0 => value / most,
                (Some(value), _, Some(least)) if value > 0.0 => least / value,
                (Some(value), _, Some(least)) if value < least => f64::INFINITY,
                _ => 0.0,
            })
            .fold(0.0, f64::max)
    };
    runs.map(used).enumerate().fold(None, |worst: Option<(usize, f64)>, run| worst.filter(|w| w.1 >= run.1).or(Some(run))).map(|w| w.0)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::verify::{Class, Gate, Metric, MetricSummary};

    fn run(corner_m: f64, stage: DriveStage, leg: usize) -> (Values, DriveEnd) {
        let mut values = Values::default();
        values.set(Metric::AsExpected, f64::from(u8::from(stage == DriveStage::Arrived)));
        values.set(Metric::CornerErrorM, corner_m);
        (values, DriveEnd { stage, leg, at_m: [1.0, 2.0], heading_rad: 0.5, t_s: 60.0 })
    }

    fn judged(runs: &[(Values, DriveEnd)]) -> ScenarioVerdict {
        let values: Vec<Values> = runs.iter().map(|r| r.0).collect();
        let metrics = MetricSummary::all(&runs[0].0, &values);
        ScenarioVerdict::new("polyline", "", Class::Polyline, (metrics, values.len()), &Gate::with(None).unwrap())
    }

    #[test]
    fn a_failed_manoeuvre_says_how_where_and_which_draw_is_the_worst() {
        let heading = DriveStage::Failed(Trouble::Heading);
        let runs = [run(0.004, DriveStage::Arrived, 6), run(0.03, heading, 2), run(0.02, heading, 2), run(0.01, DriveStage::Arrived, 6)];
        let notes = endings(&judged(&runs), &runs[0].1, &runs);
        assert_eq!(notes[0], "nominal run: arrived, leg 7, at (1.000, 2.000) m, heading 28.65°, after 60.0 s");
        assert!(notes[1].starts_with("2 of 4 perturbed runs: arrived, leg 7; the first is draw 1, "), "{notes:?}");
        assert!(
            notes[2]
                .starts_with("2 of 4 perturbed runs: the heading was not reached in the corrections allowed, leg 3; the first is draw 2")
        );
        // both miss the end; the one with the larger error comes first because it is found first
        assert!(notes[3].starts_with("worst draw 2: ended as expected 0.0 %, corner position error 0.030 m"), "{notes:?}");
    }

    #[test]
    fn a_pass_has_nothing_to_say_and_the_worst_run_is_that_nearest_to_a_limit() {
        let runs = [run(0.004, DriveStage::Arrived, 6), run(0.012, DriveStage::Arrived, 6), run(0.01, DriveStage::Arrived, 6)];
        let mut verdict = judged(&runs);
        verdict.status = Status::Pass;
        assert!(endings(&verdict, &runs[0].1, &runs).is_empty());
        let limits: Vec<LimitCheck> = verdict.checks.into_iter().filter(|c| c.metric == Metric::CornerErrorM).collect();
        assert_eq!(worst_run(runs.iter().map(|r| &r.0), &limits), Some(1));
        assert_eq!(worst_run([].iter(), &limits), None);
    }
}
