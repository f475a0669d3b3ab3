//! The map compared with other laws, on the same plant and the same draws.

use crate::control::{HeadingLaw, WaypointLaw};
use crate::sim;
use crate::verify::Result;
use crate::verify::laws::{constant_gain, tuned_heading_law, tuning_runs};
use crate::verify::metric::{Metric, MetricSummary, Statistic};
use crate::verify::pivot_traces::{ClosedLoop, PivotTrace};
use crate::verify::scenario::Scenario;
use crate::verify::settings::VerifySettings;
use crate::verify::stage::{PivotRuns, PivotStage};
use crate::verify::verdict::{LawComparison, LawSummary};

/// Laws in the comparison.
const LAWS: usize = 4;

/// The scenario that the comparison drives.
const COMPARED: &str = "left-90";

/// Number of runs that the comparison needs.
pub(crate) fn comparison_runs(settings: &VerifySettings) -> usize {
    if settings.comparison_draws > 0 { LAWS * (settings.comparison_draws + 1) + tuning_runs() } else { 0 }
}

/// The comparison on the first draws of `varied`, and the traces of map and conventional law if requested. `None` without draws.
///
/// # Errors
/// As [`crate::verify::verify`].
pub(crate) fn compare(
    stage: &PivotStage<'_>,
    settings: &VerifySettings,
    varied: &[(sim::WorldSettings, u64)],
    traces: bool,
) -> Result<Option<(LawComparison, Option<ClosedLoop>)>> {
    if settings.comparison_draws == 0 {
        return Ok(None);
    }
    let varied = &varied[..settings.comparison_draws.min(varied.len())];
    let all = Scenario::all();
    let scenario = all.iter().find(|s| s.name == COMPARED).unwrap_or(&all[0]);
    let gain = constant_gain(stage.maps, stage.maps.torque_limit_nm());
    let tuned = tuned_heading_law(&stage.bench(), scenario, &stage.plant, &stage.law, gain, stage.done)?;
    let trace = || traces.then(PivotTrace::default);
    let map = stage.run_all(scenario, varied, || stage.map_law(), trace(), trace)?;
    let perfect = stage.run_all(scenario, varied, || WaypointLaw::new(stage.law, &stage.exact), (), || ())?.summaries();
    let constant = stage.run_all(scenario, varied, || WaypointLaw::new(stage.law, gain), (), || ())?.summaries();
    let conventional = stage.run_all(scenario, varied, || HeadingLaw::new(tuned), trace(), trace)?;
    let summaries = [map.summaries(), perfect, constant, conventional.summaries()];
    let [by_map, by_perfect, _, by_conventional] = &summaries;
    let comparison = LawComparison {
        scenario: scenario.name.clone(),
        constant_gain_nm_per_mps2: gain.gain_nm_per_mps2,
        conventional: (&tuned).into(),
        start_jerk_ratio: ratio_of_medians(Metric::StartJerkMps3, by_map, by_conventional),
        speed_rms_ratio: ratio_of_medians(Metric::SpeedRmsMps, by_map, by_perfect),
        laws: ["map", "perfect inverse", "constant gain", "conventional"]
            .into_iter()
            .zip(summaries)
            .map(|(name, metrics)| LawSummary { name: name.to_owned(), metrics })
            .collect(),
    };
    let closed_loop = traced(map).zip(traced(conventional)).map(|(map, other)| ClosedLoop::new(stage.maps, scenario, &map, &other));
    Ok(Some((comparison, closed_loop)))
}

/// The median of a metric over that of another law; `None` when either is missing or the ratio is not finite.
fn ratio_of_medians(metric: Metric, of: &[MetricSummary], other: &[MetricSummary]) -> Option<f64> {
    let median = |of: &[MetricSummary]| of.iter().find(|s| s.metric == metric).and_then(|s| s.figure(Statistic::Median));
    Some(median(of)? / median(other)?).filter(|r| r.is_finite())
}

/// The traces of all runs; `None` when they were not kept.
fn traced(runs: PivotRuns<Option<PivotTrace>, Option<PivotTrace>>) -> Option<(PivotTrace, Vec<PivotTrace>)> {
    let draws: Option<Vec<PivotTrace>> = runs.draws.into_iter().map(|d| d.1).collect();
    runs.nominal.1.zip(draws)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::verify::metric::Values;

    #[test]
    fn a_ratio_of_medians_is_absent_where_a_law_lacks_the_metric_or_it_is_not_finite() {
        let of = |value: f64| {
            let mut values = Values::default();
            values.set(Metric::StartJerkMps3, value);
            MetricSummary::all(&values, &[values])
        };
        assert_eq!(ratio_of_medians(Metric::StartJerkMps3, &of(3.0), &of(12.0)), Some(0.25));
        assert_eq!(ratio_of_medians(Metric::StartJerkMps3, &of(3.0), &of(0.0)), None);
        assert_eq!(ratio_of_medians(Metric::SpeedRmsMps, &of(3.0), &of(12.0)), None);
    }
}
