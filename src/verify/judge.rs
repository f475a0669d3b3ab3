//! Runs the scenarios and the comparison, applies the gate, and puts the verdict together.

use crate::control::{DriveLaw, HeadingLaw, PivotRequest, TorqueMap as _, WaypointLaw, WaypointLawSettings};
use crate::manoeuvre::{Manoeuvre, ManoeuvreTorque};
use crate::map::{FORMAT_VERSION, Gear};
use crate::verify::bench::{Bench, Moment};
use crate::verify::gate::Gate;
use crate::verify::laws::{constant_gain, law_settings, map_law, test_angle_rad, tuned_heading_law, tuning_runs};
use crate::verify::measured_region::Region;
use crate::verify::metric::{Metric, Statistic, Summary, Values};
use crate::verify::perturbations::{Spread, draws};
use crate::verify::plant::Plant;
use crate::verify::round_trip::{RoundTrip, round_trip};
use crate::verify::run::run;
use crate::verify::scenario::Scenario;
use crate::verify::verdict::{Comparison, FORMAT, LawSummary, PlantSummary, ScenarioVerdict, Status, Verdict};
use crate::verify::{Maps, Result};
use crate::{control, manoeuvre, sim};
use rayon::prelude::*;

/// How a map is verified.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// The scenarios. Default all.
    pub scenarios: Vec<Scenario>,
    /// Perturbed plants per scenario. Default 200: the 99th percentile then rests on the two worst.
    pub draws: usize,
    /// Perturbed plants in the comparison. Default 20; 0 leaves the comparison out.
    pub comparison_draws: usize,
    /// How far they are perturbed.
    pub spread: Spread,
    /// Seed of everything random. Default 1.
    pub seed: u64,
    /// The limits.
    pub gate: Gate,
    /// The drive law; `None`, the default, is the usual one for the map's vehicle.
    pub law: Option<WaypointLawSettings>,
    /// The plant; `None`, the default, is the one that Table 1 identified.
    pub plant: Option<sim::Settings>,
    /// The manoeuvres. Default none: they judge the vehicle's other maps and laws, and take longer than all pivots.
    pub manoeuvres: Vec<Manoeuvre>,
    /// Perturbed vehicles per manoeuvre. Default 20: a manoeuvre takes a hundred times as long as a pivot.
    pub manoeuvre_draws: usize,
    /// The physical vehicle that drives manoeuvres. Default the bundled scrubber.
    pub manoeuvre_vehicle: sim::Settings,
}

impl Settings {
    /// The defaults.
    ///
    /// # Errors
    /// None in practice: the built-in gate is read.
    pub fn new() -> Result<Self> {
        Ok(Self {
            scenarios: Scenario::all(),
            draws: 200,
            comparison_draws: 20,
            spread: Spread::default(),
            seed: 1,
            gate: Gate::with(None)?,
            law: None,
            plant: None,
            manoeuvres: Vec::new(),
            manoeuvre_draws: 20,
            manoeuvre_vehicle: manoeuvre::bundled_vehicle()?,
        })
    }
}

/// Everything that a scenario is run with.
pub(crate) struct Stage<'a> {
    maps: &'a Maps,
    pub(crate) control: control::Settings,
    pub(crate) law: WaypointLawSettings,
    region: Region,
    pub(crate) plant: sim::Settings,
    exact: Plant,
    /// Called each time a run has ended.
    done: &'a (dyn Fn(usize) + Sync),
}

impl<'a> Stage<'a> {
    pub(crate) fn new(maps: &'a Maps, settings: &Settings, done: &'a (dyn Fn(usize) + Sync)) -> Result<Self> {
        let plant = settings.plant.as_ref().map_or_else(|| sim::Settings::identified(&maps.table1), |p| Ok(p.clone()))?;
        let control = control::Settings::new(maps.table2.vehicle.wheelbase_m, test_angle_rad(maps));
        let exact = Plant::new(&plant)?;
        Ok(Self {
            maps,
            control,
            law: settings.law.unwrap_or_else(|| law_settings(maps)),
            region: Region::new(&maps.table2),
            plant,
            exact,
            done,
        })
    }

    pub(crate) fn bench(&self) -> Bench<'_> {
        let profile = &self.control.planning.profile;
        let torque_nm = |accel| self.exact.torque(Gear::Forward, 0.5 * profile.cruise_mps, accel).map_or(0.0, |found| found.torque_nm);
        Bench {
            planned_nm: [torque_nm(0.0), torque_nm(profile.accel_mps2)],
            control: &self.control,
            period_s: self.law.period_s,
            torque_limit_nm: self.maps.torque_limit_nm(),
            breakaway_nm: self.exact.breakaway_nm(),
            region: &self.region,
        }
    }
}

/// Judges a map.
///
/// # Errors
/// A plant that cannot be simulated, or a controller that cannot be set up. A bad map is no error: it is the verdict.
pub fn verify(maps: &Maps, settings: &Settings) -> Result<Verdict> {
    verify_watched(maps, settings, &|_| ())
}

/// As [`verify`]; calls `done` after every simulated run, from any thread, with the number of runs in all.
///
/// # Errors
/// As [`verify`].
pub fn verify_watched(maps: &Maps, settings: &Settings, done: &(dyn Fn(usize) + Sync)) -> Result<Verdict> {
    let driven = settings.scenarios.iter().filter(|s| !s.needs_reverse() || maps.reverse.is_some()).count() * (settings.draws + 1);
    let compared = if settings.comparison_draws > 0 { LAWS * (settings.comparison_draws + 1) + tuning_runs() } else { 0 };
    let told = |_: usize| done(driven + compared);
    let stage = Stage::new(maps, settings, &told)?;
    let varied = draws(&stage.plant, &settings.spread, settings.draws.max(settings.comparison_draws), settings.seed)?;
    let trips = round_trip(maps, &settings.gate.round_trip)?;
    let mut scenarios = judge_scenarios(&stage, settings, &varied)?;
    scenarios.extend(manoeuvre::judge(maps, settings)?);
    let comparison = if settings.comparison_draws > 0 { Some(compare(&stage, settings, &varied)?) } else { None };
    let mut notes = notes(maps, &trips, &scenarios);
    if !maps.angles.is_empty() {
        notes.push(format!("pivots: the map at the test angle of {}°", maps.table2.vehicle.test_angle_deg));
    }
    if !settings.manoeuvres.is_empty() {
        notes.push(ManoeuvreTorque::what(maps));
    }
    let good = !trips.is_empty() && trips.iter().all(|t| t.pass) && scenarios.iter().all(|s| s.status != Status::Fail);
    let kind = if matches!(stage.plant.motion, sim::MotionSettings::Physical(_)) { "physical" } else { "identified" };
    Ok(Verdict {
        format: FORMAT.to_owned(),
        format_version: FORMAT_VERSION,
        tool_version: env!("CARGO_PKG_VERSION").to_owned(),
        status: if good { Status::Pass } else { Status::Fail },
        notes,
        table2_csv_sha256: maps.csv_sha256.clone(),
        forced: maps.forced.clone(),
        plant: PlantSummary {
            kind: kind.to_owned(),
            dead_time_s: stage.plant.drive.dead_time_s,
            lag_s: stage.plant.drive.lag_s,
            torque_limit_nm: stage.plant.drive.torque_limit_nm,
            breakaway_nm: stage.exact.breakaway_nm(),
        },
        draws: settings.draws,
        comparison_draws: settings.comparison_draws,
        seed: settings.seed,
        spread: settings.spread,
        controller: serde_json::json!({ "modules": stage.control, "drive_law": stage.law }),
        round_trip_limit: settings.gate.round_trip.clone(),
        limits: settings.gate.limits.clone(),
        round_trip: trips,
        scenarios,
        comparison,
        replayed: Vec::new(),
    })
}

/// Runs one scenario on the nominal plant, as [`verify`] does, and shows every control period to `record`.
///
/// # Errors
/// As [`verify`].
pub fn replay(
    maps: &Maps,
    settings: &Settings,
    scenario: &Scenario,
    mut record: impl FnMut(&Moment, Option<&PivotRequest>),
) -> Result<Values> {
    let stage = Stage::new(maps, settings, &|_| ())?;
    run(&stage.bench(), scenario, &stage.plant, map_law(maps, &stage.law), settings.seed, &mut record)
}

/// Nominal run and draws of a law over one scenario.
fn run_all<L: DriveLaw>(
    stage: &Stage<'_>,
    scenario: &Scenario,
    varied: &[(sim::Settings, u64)],
    seed: u64,
    law: impl Fn() -> L + Sync,
) -> Result<Vec<Summary>> {
    let bench = stage.bench();
    let one = |plant: &sim::Settings, seed: u64| {
        let values = run(&bench, scenario, plant, law(), seed, |_, _| {});
        (stage.done)(1);
        values
    };
    let nominal = one(&stage.plant, seed)?;
    let runs: Result<Vec<Values>> = varied.par_iter().map(|(plant, seed)| one(plant, *seed)).collect();
    let runs = runs?;
    Ok(Metric::ALL.into_iter().filter_map(|metric| Summary::new(metric, &nominal, &runs)).collect())
}

fn judge_scenarios(stage: &Stage<'_>, settings: &Settings, varied: &[(sim::Settings, u64)]) -> Result<Vec<ScenarioVerdict>> {
    let varied = &varied[..settings.draws.min(varied.len())];
    settings
        .scenarios
        .par_iter()
        .map(|scenario| {
            let mut verdict = ScenarioVerdict {
                name: scenario.name.clone(),
                what: scenario.what.clone(),
                class: scenario.class,
                status: Status::NotTested,
                notes: Vec::new(),
                metrics: Vec::new(),
                checks: Vec::new(),
            };
            if scenario.needs_reverse() && stage.maps.reverse.is_none() {
                verdict.notes.push("not tested: there is no reverse table".to_owned());
                return Ok(verdict);
            }
            if scenario.assumes_symmetry() {
                verdict.notes.push("symmetry assumed: the table was measured with the wheel to the left".to_owned());
            }
            verdict.metrics = run_all(stage, scenario, varied, settings.seed, || map_law(stage.maps, &stage.law))?;
            verdict.checks = settings.gate.check(scenario.class, &verdict.metrics);
            verdict.status = if verdict.checks.iter().all(|c| c.pass) { Status::Pass } else { Status::Fail };
            Ok(verdict)
        })
        .collect()
}

/// Laws in the comparison.
const LAWS: usize = 4;

/// The scenario that the comparison drives.
pub(crate) const COMPARED: &str = "left-90";

fn compare(stage: &Stage<'_>, settings: &Settings, varied: &[(sim::Settings, u64)]) -> Result<Comparison> {
    let varied = &varied[..settings.comparison_draws.min(varied.len())];
    let all = Scenario::all();
    let scenario = all.iter().find(|s| s.name == COMPARED).unwrap_or(&all[0]);
    let gain = constant_gain(stage.maps, stage.maps.torque_limit_nm());
    let tuned = tuned_heading_law(&stage.bench(), scenario, &stage.plant, &stage.law, gain, stage.done)?;
    let seed = settings.seed;
    let map = run_all(stage, scenario, varied, seed, || map_law(stage.maps, &stage.law))?;
    let perfect = run_all(stage, scenario, varied, seed, || WaypointLaw::new(stage.law, &stage.exact))?;
    let constant = run_all(stage, scenario, varied, seed, || WaypointLaw::new(stage.law, gain))?;
    let conventional = run_all(stage, scenario, varied, seed, || HeadingLaw::new(tuned))?;
    let ratio = |metric: Metric, other: &[Summary]| {
        let median = |of: &[Summary]| of.iter().find(|s| s.metric == metric).and_then(|s| s.figure(Statistic::Median));
        Some(median(&map)? / median(other)?).filter(|r| r.is_finite())
    };
    let (start_jerk_ratio, speed_rms_ratio) = (ratio(Metric::StartJerkMps3, &conventional), ratio(Metric::SpeedRmsMps, &perfect));
    let law = |name: &str, metrics| LawSummary { name: name.to_owned(), metrics };
    Ok(Comparison {
        scenario: scenario.name.clone(),
        laws: vec![law("map", map), law("perfect inverse", perfect), law("constant gain", constant), law("conventional", conventional)],
        constant_gain_nm_per_mps2: gain.gain_nm_per_mps2,
        conventional: (&tuned).into(),
        start_jerk_ratio,
        speed_rms_ratio,
    })
}

fn notes(maps: &Maps, trips: &[RoundTrip], scenarios: &[ScenarioVerdict]) -> Vec<String> {
    let mut notes = maps.forced.clone();
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
