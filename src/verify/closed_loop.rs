//! `verify_traces.json`: the pivot of the comparison over time, by the map and by the conventional law, on the nominal plant and as quantiles
//! over the draws. For people to look at; the verdict does not depend on it.

use crate::control::{DriveLaw, HeadingLaw, HeadingLawSettings, Phase, SpeedLoopSettings};
use crate::map::{FORMAT_VERSION, expect_format};
use crate::units::RAD_PER_DEG;
use crate::verify::bench::Moment;
use crate::verify::judge::{COMPARED, Settings, Stage};
use crate::verify::laws::{constant_gain, map_law};
use crate::verify::metric::quantile;
use crate::verify::perturbations::draws;
use crate::verify::run::run;
use crate::verify::scenario::Scenario;
use crate::verify::verdict::{Comparison, Verdict};
use crate::verify::{Maps, Result};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// What the `format` field of a `verify_traces.json` says.
const FORMAT: &str = "pivot-cal/verify_traces";

/// `verify_traces.json`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ClosedLoop {
    /// Always `pivot-cal/verify_traces`.
    pub format: String,
    /// Version of this layout.
    pub format_version: u32,
    /// Version of the program that wrote it.
    pub tool_version: String,
    /// SHA-256 of the Table 2 files that drove, forward first.
    pub table2_csv_sha256: Vec<String>,
    /// The scenario.
    pub scenario: String,
    /// What it is.
    pub what: String,
    /// Draws behind the quantiles.
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
pub struct LawTraces {
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
pub struct Bands {
    /// On the plant as fitted.
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
/// Shown after the slower nominal run stands [s].
const AFTER_S: f64 = 0.6;

/// One run from the gear being set: time, and the four quantities.
type Run = Vec<(f64, [f64; 4], Option<f64>)>;

/// Drives the comparison's pivot again with its draws, and the gains that the search found for the conventional law. `None` when the verdict
/// holds no comparison.
///
/// # Errors
/// As [`crate::verify::verify`].
pub fn closed_loop(maps: &Maps, settings: &Settings, verdict: &Verdict) -> Result<Option<ClosedLoop>> {
    let Some(comparison) = &verdict.comparison else { return Ok(None) };
    let untold = |_: usize| ();
    let stage = Stage::new(maps, settings, &untold)?;
    let count = settings.comparison_draws;
    // the comparison takes the first of these draws
    let varied = draws(&stage.plant, &settings.spread, settings.draws.max(count), settings.seed)?;
    let varied = &varied[..count.min(varied.len())];
    let scenarios = Scenario::all();
    let scenario = scenarios.iter().find(|s| s.name == COMPARED).unwrap_or(&scenarios[0]);
    let heading = conventional(&stage, comparison, maps);
    let all = |law: &(dyn Fn(&crate::sim::Settings, u64) -> Result<Run> + Sync)| -> Result<(Run, Vec<Run>)> {
        let nominal = law(&stage.plant, settings.seed)?;
        let runs: Result<Vec<Run>> = varied.par_iter().map(|(plant, seed)| law(plant, *seed)).collect();
        Ok((nominal, runs?))
    };
    let by_map = all(&|plant, seed| drive(&stage, scenario, plant, map_law(maps, &stage.law), seed))?;
    let by_heading = all(&|plant, seed| drive(&stage, scenario, plant, HeadingLaw::new(heading), seed))?;
    let stands = |run: &Run| run.iter().rev().find(|m| m.1[0].abs() > 1e-3).map_or(0.0, |m| m.0);
    let end_s = (stands(&by_map.0).max(stands(&by_heading.0)) + AFTER_S).min(LONGEST_S);
    let t_s: Vec<f64> = (0..=(end_s / STEP_S).ceil() as u32).map(|k| round(f64::from(k) * STEP_S, 1e3)).collect();
    let target_speed_mps = t_s.iter().map(|t| at(&by_map.0, *t).and_then(|m| m.2).map(|v| round(v, 1e4))).collect();
    Ok(Some(ClosedLoop {
        format: FORMAT.to_owned(),
        format_version: FORMAT_VERSION,
        tool_version: env!("CARGO_PKG_VERSION").to_owned(),
        table2_csv_sha256: maps.csv_sha256.clone(),
        scenario: scenario.name.clone(),
        what: scenario.what.clone(),
        draws: varied.len(),
        target_speed_mps,
        laws: vec![law_traces("map", &by_map, &t_s), law_traces("conventional", &by_heading, &t_s)],
        t_s,
    }))
}

/// The conventional law with the gains of the comparison.
fn conventional(stage: &Stage<'_>, comparison: &Comparison, maps: &Maps) -> HeadingLawSettings {
    let gains = &comparison.conventional;
    HeadingLawSettings {
        period_s: stage.law.period_s,
        heading_proportional: gains.heading_proportional,
        heading_integral: gains.heading_integral,
        heading_derivative: gains.heading_derivative,
        max_speed_mps: stage.control.planning.profile.cruise_mps,
        speed_loop: SpeedLoopSettings {
            proportional_per_s: gains.speed_proportional_per_s,
            integral_per_s2: gains.speed_integral_per_s2,
            ..stage.law.speed_loop
        },
        standstill_mps: stage.law.standstill_mps,
        end_threshold_rad: stage.law.end_threshold_m / stage.control.planning.wheelbase_m,
        torque: constant_gain(maps, maps.torque_limit_nm()),
    }
}

fn drive<L: DriveLaw>(stage: &Stage<'_>, scenario: &Scenario, plant: &crate::sim::Settings, law: L, seed: u64) -> Result<Run> {
    let mut points: Run = Vec::new();
    let mut begun_s = None;
    let mut heading_rad = None;
    run(&stage.bench(), scenario, plant, law, seed, |moment: &Moment, _| {
        let (state, command) = (&moment.state, &moment.command);
        let start_rad = *heading_rad.get_or_insert(state.heading_rad);
        if begun_s.is_none() && command.phase == Phase::Driving {
            begun_s = Some(state.t_s);
        }
        if let Some(begun_s) = begun_s {
            let turned_deg = (state.heading_rad - start_rad) / RAD_PER_DEG;
            let target = command.drive.map(|d| d.target_speed_mps);
            points.push((state.t_s - begun_s, [state.speed_mps, state.accel_mps2, state.torque_nm, turned_deg], target));
        }
    })?;
    Ok(points)
}

/// The last moment at or before a time.
fn at(run: &Run, t_s: f64) -> Option<&(f64, [f64; 4], Option<f64>)> {
    run.get(run.partition_point(|m| m.0 <= t_s + 1e-6).saturating_sub(1))
}

fn law_traces(name: &str, (nominal, runs): &(Run, Vec<Run>), t_s: &[f64]) -> LawTraces {
    let bands = |which: usize, steps: f64| {
        let value = |run: &Run, t: f64| at(run, t).map_or(0.0, |m| m.1[which]);
        let mut bands =
            Bands { nominal: Vec::new(), p05: Vec::new(), p25: Vec::new(), median: Vec::new(), p75: Vec::new(), p95: Vec::new() };
        for &t in t_s {
            bands.nominal.push(round(value(nominal, t), steps));
            let mut values: Vec<f64> = runs.iter().map(|r| value(r, t)).collect();
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

impl ClosedLoop {
    /// Reads the JSON text.
    ///
    /// # Errors
    /// Not JSON, another format or version, a missing field.
    pub fn from_json(text: &str) -> Result<Self> {
        Ok(serde_json::from_value(expect_format(text, FORMAT)?)?)
    }

    /// The text of `verify_traces.json`, with a final line end.
    ///
    /// # Errors
    /// None in practice; serialisation is fallible by its signature.
    pub fn to_json(&self) -> Result<String> {
        Ok(serde_json::to_string(self)? + "\n")
    }
}
