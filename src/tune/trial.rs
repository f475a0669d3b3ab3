//! One candidate driven: its limits, and how long it takes.

use crate::controller::ControllerSettings;
use crate::tune::limit_margin::{LimitMargin, nearest_limits};
use crate::tune::loop_margins::LoopMargins;
use crate::tune::settings::TuneSettings;
use crate::verify::{Class, Maps, Metric, Result, Scenario, ScenarioVerdict, Statistic, Status, VerifySettings, judge_pivots};

/// The law that a candidate drives.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum TunedLaw {
    /// With the map.
    Map,
    /// With the perfect inverse of the plant.
    Perfect,
}

/// A candidate and how it drove.
#[derive(Debug, Clone)]
pub(crate) struct Trial {
    /// The candidate.
    pub(crate) settings: ControllerSettings,
    /// Its limits, the smallest margin first.
    pub(crate) margins: Vec<LimitMargin>,
    /// Mean over the turns of the median time from the gear being set to standstill [s]; infinity if one has none.
    pub(crate) settling_s: f64,
    /// Margins of its speed loop.
    pub(crate) loop_margins: LoopMargins,
    /// Verdicts on the scenarios.
    pub(crate) verdicts: Vec<ScenarioVerdict>,
}

/// What one limit may lack in the sum over all of them: beyond it, others count for more.
const MOST_LACK: f64 = 5.0;

/// Above every time that a good candidate may cost.
const BAD: f64 = 1e3;

impl Trial {
    /// Drives a candidate over `scenarios` on `draws` perturbed plants each.
    ///
    /// # Errors
    /// As [`judge_pivots`].
    pub(crate) fn drive(
        maps: &Maps,
        settings: &TuneSettings,
        candidate: &ControllerSettings,
        scenarios: &[Scenario],
        draws: usize,
        law: TunedLaw,
    ) -> Result<Self> {
        let mut controller = settings.start.clone();
        controller.settings = candidate.clone();
        let verify = VerifySettings { controller, scenarios: scenarios.to_vec(), draws, comparison_draws: 0, ..settings.verify.clone() };
        let verdicts = judge_pivots(maps, &verify, law == TunedLaw::Perfect)?;
        let turns = verdicts.iter().filter(|v| v.class == Class::Turn && v.status != Status::NotTested);
        let time = |v: &ScenarioVerdict| v.metrics.iter().find(|m| m.metric == Metric::SettlingTimeS)?.figure(Statistic::Median);
        let times: Vec<f64> = turns.map(|v| time(v).unwrap_or(f64::INFINITY)).collect();
        let settling_s = times.iter().sum::<f64>() / times.len().max(1) as f64;
        let (dead_time_s, lag_s) = (maps.table2.dead_time_s, maps.table2.lag_s);
        let loop_margins = LoopMargins::new(&candidate.law(maps.table2.vehicle.wheelbase_m, dead_time_s + lag_s), dead_time_s, lag_s);
        Ok(Self { settings: candidate.clone(), margins: LimitMargin::all(&verdicts), settling_s, loop_margins, verdicts })
    }

    /// Smallest margin of a limit.
    pub(crate) fn least_margin(&self) -> f64 {
        self.margins.first().map_or(f64::NEG_INFINITY, |m| m.margin)
    }

    /// Whether every limit is kept.
    pub(crate) fn passes(&self) -> bool {
        !self.verdicts.is_empty() && self.verdicts.iter().all(|v| v.status != Status::Fail)
    }

    /// What the search makes small: the time, if every limit has its reserve and the speed loop its margins, otherwise what the reserve lacks.
    pub(crate) fn cost(&self, reserve: f64) -> f64 {
        let of_limits: f64 = nearest_limits(&self.margins).iter().map(|m| (reserve - m.margin).clamp(0.0, MOST_LACK)).sum();
        let lack = of_limits + self.loop_margins.lack().max(0.0);
        if lack <= 0.0 { self.settling_s } else { BAD * (1.0 + lack) }
    }
}
