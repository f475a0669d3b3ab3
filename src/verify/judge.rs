//! Runs the scenarios and the comparison, applies the gate, and forms the verdict.

use crate::check::campaign_checks::all_checks;
use crate::control::WaypointLaw;
use crate::map::{Check, FORMAT_VERSION};
use crate::sim;
use crate::verify::basis::Basis;
use crate::verify::bench::PivotMoment;
use crate::verify::comparison::{compare, comparison_runs};
use crate::verify::controller_library::LibraryLaw;
use crate::verify::drive::EachMoment;
use crate::verify::metric::{MetricSummary, Values};
use crate::verify::notes::notes;
use crate::verify::perturbations::draws;
use crate::verify::pivot_log::PivotLog;
use crate::verify::pivot_traces::ClosedLoop;
use crate::verify::pivots_check::PIVOTS;
use crate::verify::replay_check::{REPLAY, nothing_to_accept};
use crate::verify::round_trip::round_trip;
use crate::verify::run::run;
use crate::verify::scenario::Scenario;
use crate::verify::settings::{RunLog, VerifySettings, Wanted};
use crate::verify::stage::{PivotRuns, PivotStage};
use crate::verify::verdict::{FORMAT, MapVerdict, PlantSummary, ScenarioVerdict, Status};
use crate::verify::{Error, Maps, Result};
use rayon::prelude::*;

/// A verdict, and the requested traces and logs.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Verified {
    /// The verdict.
    pub verdict: MapVerdict,
    /// The runs of the comparison over time; `None` when they were not requested or the verdict has no comparison.
    pub traces: Option<ClosedLoop>,
    /// Logs of the nominal runs, one for each scenario that was tested; empty when they were not requested.
    pub logs: Vec<RunLog>,
}

/// Judges a map.
///
/// # Errors
/// A plant that cannot be simulated, or a controller that cannot be set up. A bad map is a verdict, not an error.
pub fn verify(maps: &Maps, settings: &VerifySettings) -> Result<MapVerdict> {
    Ok(verify_with(maps, settings, Wanted::default())?.verdict)
}

/// As [`verify`]; traces and logs are taken from the same runs.
///
/// # Errors
/// As [`verify`], and any error of the MCAP writer.
pub(crate) fn verify_with(maps: &Maps, settings: &VerifySettings, wanted: Wanted<'_>) -> Result<Verified> {
    let (checks, basis) = (all_checks(&maps.table1), Basis::new(&maps.table1));
    let accepted = accepted(&checks, &settings.accept)?;
    let policy = settings.controller.settings.planning.wheel_policy;
    let tested = settings.scenarios.iter().filter(|s| basis.untestable(s, maps.reverse.is_some(), policy).is_none()).count();
    let total = tested * (settings.draws + 1) + comparison_runs(settings);
    let done = || {
        if let Some(progress) = wanted.progress {
            progress(total);
        }
    };
    let stage = PivotStage::new(maps, settings, &done)?;
    let varied = draws(&stage.plant, &settings.spread, settings.draws.max(settings.comparison_draws), settings.seed)?;
    let trips = round_trip(maps, &settings.gate.round_trip)?;
    let judged = judge_scenarios(&stage, settings, &basis, &varied[..settings.draws.min(varied.len())], (false, wanted.logs))?;
    let (scenarios, logs): (Vec<_>, Vec<_>) = judged.into_iter().unzip();
    let compared = compare(&stage, settings, &varied, wanted.traces)?;
    let (comparison, traces) = compared.unzip();
    let mut notes = notes(&maps.forced, &trips, &scenarios);
    if !maps.angles.is_empty() {
        notes.push(format!("pivots: the map at the test angle of {}°", maps.table2.vehicle.test_angle_deg));
    }
    let idle = settings.accept.iter().filter(|name| !accepted.contains(name));
    notes.extend(idle.map(|name| nothing_to_accept(name)));
    let kind = if matches!(stage.plant.motion, sim::MotionSettings::Physical(_)) { "physical" } else { "identified" };
    let verdict = MapVerdict {
        format: FORMAT.to_owned(),
        format_version: FORMAT_VERSION,
        tool_version: env!("CARGO_PKG_VERSION").to_owned(),
        generation: maps.table1.generation.clone(),
        status: Status::Pass,
        reason: String::new(),
        scope: Vec::new(),
        checks,
        accepted,
        basis: Some(basis),
        notes,
        table2_csv_sha256: maps.csv_sha256.clone(),
        forced: maps.forced.clone(),
        plant: PlantSummary {
            kind: kind.to_owned(),
            dead_time_s: stage.plant.drive.dead_time_s,
            lag_s: stage.plant.drive.lag_s,
            torque_limit_nm: stage.plant.drive.torque_limit_nm,
            breakaway_nm: stage.exact.breakaway_nm(),
            torque_step_nm: Some(stage.plant.drive.torque_quantum_nm).filter(|step| *step > 0.0),
            torque_dead_band_nm: Some(stage.plant.drive.torque_dead_band_nm).filter(|band| *band > 0.0),
            rate_limit_nm_s: stage.plant.drive.slew_limit_nm_s,
            speed_step_mps: Some(stage.plant.speed_step_mps()).filter(|step| *step > 0.0),
        },
        draws: settings.draws,
        comparison_draws: settings.comparison_draws,
        seed: settings.seed,
        spread: settings.spread,
        controller_settings: Some(settings.controller.clone()),
        controller_command: settings.controller_command.clone(),
        controller: serde_json::json!({ "modules": stage.control, "drive_law": stage.law }),
        round_trip_limit: settings.gate.round_trip.clone(),
        limits: settings.gate.limits.clone(),
        round_trip: trips,
        scenarios,
        comparison,
        lateral_sha256: None,
        manoeuvre_vehicle_sha256: None,
        replayed: Vec::new(),
        pivots: Vec::new(),
    }
    .concluded();
    Ok(Verified { verdict, traces: traces.flatten(), logs: logs.into_iter().flatten().collect() })
}

/// The objections among the checks that are named in `names`.
///
/// # Errors
/// A name that no check has.
fn accepted(checks: &[Check], names: &[String]) -> Result<Vec<String>> {
    // the recorded logs follow
    let known: Vec<&str> = checks.iter().map(|c| c.name.as_str()).chain([REPLAY, PIVOTS]).collect();
    if let Some(found) = names.iter().find(|name| !known.contains(&name.as_str())) {
        return Err(Error::NoCheck { found: found.clone(), known: known.join(", ") });
    }
    Ok(checks.iter().filter(|c| c.objects() && names.contains(&c.name)).map(|c| c.name.clone()).collect())
}

/// Runs one scenario on the nominal plant, as [`verify`] does, and shows every control period to `record`.
///
/// # Errors
/// As [`verify`].
pub fn replay(maps: &Maps, settings: &VerifySettings, scenario: &Scenario, record: impl FnMut(&PivotMoment)) -> Result<Values> {
    let stage = PivotStage::new(maps, settings, &|| ())?;
    Ok(run(&stage.bench(), scenario, &stage.plant, stage.map_law(), settings.seed, EachMoment(record))?.values)
}

/// The verdict on each scenario of `settings`, driven with the map, or with the perfect inverse of the plant; without round trip and comparison.
///
/// # Errors
/// As [`verify`].
pub(crate) fn judge_pivots(maps: &Maps, settings: &VerifySettings, perfect: bool) -> Result<Vec<ScenarioVerdict>> {
    let basis = Basis::new(&maps.table1);
    let stage = PivotStage::new(maps, settings, &|| ())?;
    let varied = draws(&stage.plant, &settings.spread, settings.draws, settings.seed)?;
    let judged = judge_scenarios(&stage, settings, &basis, &varied, (perfect, false))?;
    Ok(judged.into_iter().map(|(verdict, _)| verdict).collect())
}

/// The runs of a scenario, whoever drove.
struct JudgedRuns {
    summaries: Vec<MetricSummary>,
    draws: usize,
    faults: Vec<String>,
    log: Option<PivotLog>,
}

fn judged(runs: PivotRuns<Option<PivotLog>, ()>) -> JudgedRuns {
    JudgedRuns { summaries: runs.summaries(), draws: runs.draws.len(), faults: runs.faults, log: runs.nominal.1 }
}

/// The verdict on each scenario, driven with the perfect inverse of the plant if `perfect`, and the log of its nominal run if `logs`.
fn judge_scenarios(
    stage: &PivotStage<'_>,
    settings: &VerifySettings,
    basis: &Basis,
    varied: &[(sim::WorldSettings, u64)],
    (perfect, logs): (bool, bool),
) -> Result<Vec<(ScenarioVerdict, Option<RunLog>)>> {
    let policy = settings.controller.settings.planning.wheel_policy;
    let judge = |scenario: &Scenario| {
        let (name, what) = (&scenario.name, &scenario.what);
        if let Some(why) = basis.untestable(scenario, stage.maps.reverse.is_some(), policy) {
            return Ok((ScenarioVerdict::not_tested(name, what, scenario.class, why), None));
        }
        let log = logs.then(|| PivotLog::new(stage.maps, scenario));
        let runs = match &settings.controller_command {
            _ if perfect => judged(stage.run_all(scenario, varied, || WaypointLaw::new(stage.law, &stage.exact), log, || ())?),
            Some(command) if command.is_library() => judged(stage.run_all(scenario, varied, || LibraryLaw { command }, log, || ())?),
            Some(command) => judged(stage.run_all(scenario, varied, || stage.process_law(command), log, || ())?),
            None => judged(stage.run_all(scenario, varied, || stage.map_law(), log, || ())?),
        };
        let mut verdict = ScenarioVerdict::new(name, what, scenario.class, (runs.summaries, runs.draws), &settings.gate);
        verdict = verdict.with_controller_faults(runs.faults);
        if scenario.assumes_symmetry() {
            verdict.notes.push("symmetry assumed: the table was measured with the wheel to the left".to_owned());
        }
        let bytes = runs.log.map(PivotLog::finish).transpose()?;
        Ok((verdict, bytes.map(|bytes| RunLog { name: name.clone(), bytes })))
    };
    settings.scenarios.par_iter().map(judge).collect()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::map::Vehicle;
    use crate::sim::{PhysicalSettings, WorldSettings as World};
    use crate::verify::reference_maps::known_maps;
    use std::sync::atomic::{AtomicUsize, Ordering};

    fn maps() -> Maps {
        let vehicle = Vehicle {
            wheelbase_m: 0.92,
            wheel_radius_m: 0.12,
            test_angle_deg: 90.0,
            torque_limit_nm: Some(44.0),
            torque_full_scale_nm: None,
        };
        let (table1, table2) = known_maps(&World::physical(vehicle, PhysicalSettings::default())).unwrap();
        Maps::new(table1, table2).unwrap()
    }

    #[test]
    fn traces_and_logs_come_with_the_verdict_and_do_not_change_it() {
        let mut maps = maps();
        maps.reverse = None;
        let scenarios = Scenario::all().into_iter().filter(|s| ["left-30", "right-30", "speed-lost"].contains(&s.name.as_str())).collect();
        let settings = VerifySettings { scenarios, draws: 2, comparison_draws: 3, ..VerifySettings::new().unwrap() };
        let (runs, total) = (AtomicUsize::new(0), AtomicUsize::new(0));
        let progress = |all: usize| {
            runs.fetch_add(1, Ordering::Relaxed);
            total.store(all, Ordering::Relaxed);
        };
        let all =
            verify_with(&maps, &settings, Wanted { traces: true, logs: true, progress: Some(&progress), ..Wanted::default() }).unwrap();
        assert_eq!(all.verdict, verify(&maps, &settings).unwrap());
        assert_eq!(runs.into_inner(), total.into_inner(), "as many runs as were announced");
        let names: Vec<&str> = all.logs.iter().map(|log| log.name.as_str()).collect();
        assert_eq!(names, ["left-30", "speed-lost"], "without a reverse table nothing is driven to the right");
        let traces = all.traces.unwrap();
        assert_eq!((traces.draws, traces.scenario.as_str(), traces.laws.len()), (3, "left-90", 2));
        let turned_deg = traces.laws[0].heading_deg.nominal.last().unwrap();
        assert!((turned_deg - 90.0).abs() < 1.5, "{turned_deg}");
    }

    #[test]
    fn without_draws_of_the_comparison_there_is_none_and_no_traces() {
        let settings = VerifySettings { scenarios: Vec::new(), draws: 0, comparison_draws: 0, ..VerifySettings::new().unwrap() };
        let all = verify_with(&maps(), &settings, Wanted { traces: true, ..Wanted::default() }).unwrap();
        assert!(all.traces.is_none() && all.verdict.comparison.is_none());
    }
}
