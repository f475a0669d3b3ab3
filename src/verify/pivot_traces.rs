//! `verify_traces.json`: the pivot of the comparison over time, by the map and by the conventional law, on the nominal plant and as quantiles
//! over the draws. For display only; the verdict does not depend on it.

use crate::control::Phase;
use crate::map::{FORMAT_VERSION, parse_file};
use crate::units::RAD_PER_DEG;
use crate::verify::drive::{Observer, Period};
use crate::verify::metric::quantile;
use crate::verify::pivot_driver::PivotDriver;
use crate::verify::pivot_law::PivotControl;
use crate::verify::scenario::Scenario;
use crate::verify::{Maps, Result};
use serde::{Deserialize, Serialize};

/// Value of the `format` field of a `verify_traces.json`.
const FORMAT: &str = "pivot-cal/verify_traces";

/// `verify_traces.json`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct ClosedLoop {
    /// Always `pivot-cal/verify_traces`.
    pub format: String,
    /// Version of this layout.
    pub format_version: u32,
    /// Version of the program that wrote it.
    pub tool_version: String,
    /// Identifier of the generation, that of the Table 1 behind the file; empty in files of versions before it.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub generation: String,
    /// SHA-256 of the Table 2 files that were used, forward first.
    pub table2_csv_sha256: Vec<String>,
    /// The scenario.
    pub scenario: String,
    /// Description of the scenario.
    pub what: String,
    /// Number of draws of the quantiles.
    pub draws: usize,
    /// Time since the gear was set [s].
    pub t_s: Vec<f64>,
    /// Speed that the map's law aims at on the nominal plant [m/s]; null after the end.
    pub target_speed_mps: Vec<Option<f64>>,
    /// `map` and `conventional`.
    pub laws: Vec<LawTraces>,
}

/// One law over time, true values of the simulated plant.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct LawTraces {
    /// Name as in the comparison.
    pub name: String,
    /// Front-wheel speed [m/s], gear frame.
    pub speed_mps: Bands,
    /// Its acceleration [m/s²].
    pub accel_mps2: Bands,
    /// Effective torque [N·m].
    pub torque_nm: Bands,
    /// Heading turned since the request [°].
    pub heading_deg: Bands,
}

/// One quantity over time. A run that has ended keeps its last value.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct Bands {
    /// On the fitted plant.
    pub nominal: Vec<f64>,
    /// 5 of 100 draws are below.
    pub p05: Vec<f64>,
    /// A quarter of the draws is below.
    pub p25: Vec<f64>,
    /// Half of the draws are below.
    pub median: Vec<f64>,
    /// Three quarters of the draws are below.
    pub p75: Vec<f64>,
    /// 95 of 100 draws are below.
    pub p95: Vec<f64>,
}

/// Every second control period is kept [s].
const STEP_S: f64 = 0.04;
/// Longest trace [s].
const LONGEST_S: f64 = 20.0;
/// Time shown after the slower nominal run has stopped [s].
const AFTER_S: f64 = 0.6;

/// A point of a run.
#[derive(Debug, Clone, Copy)]
struct TracePoint {
    /// Time since the gear was set [s].
    t_s: f64,
    /// Speed [m/s], acceleration [m/s²], effective torque [N·m], heading turned [°].
    values: [f64; 4],
    /// Speed that the law aims at [m/s].
    target_speed_mps: Option<f64>,
}

/// A run from the gear being set: an observer that keeps the drawn quantities.
#[derive(Debug, Default)]
pub(crate) struct PivotTrace {
    points: Vec<TracePoint>,
    begun_s: Option<f64>,
    start_rad: Option<f64>,
}

impl<'a, C: PivotControl> Observer<PivotDriver<'a, C>> for PivotTrace {
    fn see(&mut self, period: &Period<'_, PivotDriver<'a, C>>) {
        let (state, command) = (&period.moment.state, &period.moment.command);
        let start_rad = *self.start_rad.get_or_insert(state.heading_rad);
        if self.begun_s.is_none() && command.phase == Phase::Driving {
            self.begun_s = Some(state.t_s);
        }
        if let Some(begun_s) = self.begun_s {
            let turned_deg = (state.heading_rad - start_rad) / RAD_PER_DEG;
            self.points.push(TracePoint {
                t_s: state.t_s - begun_s,
                values: [state.speed_mps, state.accel_mps2, state.torque_nm, turned_deg],
                target_speed_mps: command.drive.map(|d| d.target_speed_mps),
            });
        }
    }
}

impl PivotTrace {
    /// The last point at or before a time.
    fn at(&self, t_s: f64) -> Option<&TracePoint> {
        self.points.get(self.points.partition_point(|p| p.t_s <= t_s + 1e-6).saturating_sub(1))
    }

    /// When the wheel came to rest [s].
    fn end_s(&self) -> f64 {
        self.points.iter().rev().find(|p| p.values[0].abs() > 1e-3).map_or(0.0, |p| p.t_s)
    }
}

/// The traces of one law: on the fitted plant, and on each draw.
type LawRuns = (PivotTrace, Vec<PivotTrace>);

impl ClosedLoop {
    /// From the runs of the comparison by the map and by the conventional law.
    pub(crate) fn new(maps: &Maps, scenario: &Scenario, by_map: &LawRuns, conventional: &LawRuns) -> Self {
        let end_s = (by_map.0.end_s().max(conventional.0.end_s()) + AFTER_S).min(LONGEST_S);
        let t_s: Vec<f64> = (0..=(end_s / STEP_S).ceil() as u32).map(|k| round(f64::from(k) * STEP_S, 1e3)).collect();
        let target = |t: f64| by_map.0.at(t).and_then(|p| p.target_speed_mps).map(|v| round(v, 1e4));
        Self {
            format: FORMAT.to_owned(),
            format_version: FORMAT_VERSION,
            tool_version: env!("CARGO_PKG_VERSION").to_owned(),
            generation: maps.table1.generation.clone(),
            table2_csv_sha256: maps.csv_sha256.clone(),
            scenario: scenario.name.clone(),
            what: scenario.what.clone(),
            draws: by_map.1.len(),
            target_speed_mps: t_s.iter().map(|t| target(*t)).collect(),
            laws: vec![law_traces("map", by_map, &t_s), law_traces("conventional", conventional, &t_s)],
            t_s,
        }
    }

    /// Reads the JSON text.
    ///
    /// # Errors
    /// Not JSON, another format or version, a missing field.
    pub(crate) fn from_json(text: &str) -> Result<Self> {
        Ok(parse_file(text, FORMAT)?)
    }

    /// The text of `verify_traces.json`, with a final line end.
    ///
    /// # Errors
    /// None in practice; serialisation is fallible by its signature.
    pub(crate) fn to_json(&self) -> Result<String> {
        Ok(serde_json::to_string(self)? + "\n")
    }
}

fn law_traces(name: &str, runs: &LawRuns, t_s: &[f64]) -> LawTraces {
    let bands = |which: usize, steps: f64| {
        let value = |run: &PivotTrace, t: f64| run.at(t).map_or(0.0, |p| p.values[which]);
        let mut bands =
            Bands { nominal: Vec::new(), p05: Vec::new(), p25: Vec::new(), median: Vec::new(), p75: Vec::new(), p95: Vec::new() };
        for &t in t_s {
            bands.nominal.push(round(value(&runs.0, t), steps));
            let mut values: Vec<f64> = runs.1.iter().map(|r| value(r, t)).collect();
            values.sort_by(f64::total_cmp);
            let shares = [0.05, 0.25, 0.5, 0.75, 0.95];
            let lists = [&mut bands.p05, &mut bands.p25, &mut bands.median, &mut bands.p75, &mut bands.p95];
            for (list, share) in lists.into_iter().zip(shares) {
                list.extend(quantile(&values, share).map(|v| round(v, steps)));
            }
        }
        bands
    };
    LawTraces {
        name: name.to_owned(),
        speed_mps: bands(0, 1e4),
        accel_mps2: bands(1, 1e3),
        torque_nm: bands(2, 1e2),
        heading_deg: bands(3, 1e2),
    }
}

fn round(value: f64, steps: f64) -> f64 {
    let rounded = (value * steps).round() / steps;
    // no "-0" in a file
    if rounded == 0.0 { 0.0 } else { rounded }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn ramp(end_s: f64, factor: f64) -> PivotTrace {
        let points = (0..=(end_s / 0.02) as u32).map(|k| {
            let t_s = 0.02 * f64::from(k);
            TracePoint { t_s, values: [factor * t_s, factor, 0.0, 0.0], target_speed_mps: (t_s < 0.5).then_some(t_s) }
        });
        PivotTrace { points: points.collect(), begun_s: Some(0.0), start_rad: Some(0.0) }
    }

    #[test]
    fn between_two_periods_the_earlier_one_counts_and_after_the_end_the_last() {
        let trace = ramp(1.0, 1.0);
        let speed = |t_s: f64| trace.at(t_s).unwrap().values[0];
        assert_eq!((speed(0.05), speed(99.0)), (0.04, trace.points[50].t_s));
        // the exact time of a period, with the rounding of its sum
        assert_eq!(speed(0.06 - 1e-9), trace.points[3].t_s);
        assert!(PivotTrace::default().at(0.0).is_none() && PivotTrace::default().end_s() == 0.0);
    }

    #[test]
    fn the_bands_are_quantiles_over_the_draws_at_each_time() {
        let runs = (ramp(1.0, 1.0), (0..=100).map(|k| ramp(1.0, 0.01 * f64::from(k))).collect());
        let laws = law_traces("map", &runs, &[0.0, 1.0]);
        let speed = &laws.speed_mps;
        assert_eq!((speed.nominal[1], speed.p05[1], speed.p25[1], speed.median[1], speed.p95[1]), (1.0, 0.05, 0.25, 0.5, 0.95));
        assert_eq!(laws.accel_mps2.median, [0.5, 0.5]);
    }

    #[test]
    fn zero_is_written_without_a_sign() {
        assert!(round(-1e-9, 1e3).is_sign_positive());
    }
}
