//! Runs the manoeuvres, nominal and perturbed, and applies the gate.

use crate::manoeuvre::Result;
use crate::manoeuvre::bench::ManoeuvreBench;
use crate::manoeuvre::drive::ManoeuvreMoment;
use crate::manoeuvre::endings::{DriveEnd, endings, worst_run};
use crate::manoeuvre::manoeuvre_log::ManoeuvreLog;
use crate::manoeuvre::scenario::Manoeuvre;
use crate::manoeuvre::settings::ManoeuvreSettings;
use crate::manoeuvre::torque::ManoeuvreTorque;
use crate::manoeuvre::traces::{ManoeuvreTrace, ManoeuvreTraces, NominalRun};
use crate::sim;
use crate::verify::drive::EachMoment;
use crate::verify::perturbations::draws;
use crate::verify::{Maps, MetricSummary, RunLog, ScenarioVerdict, Values, Wanted};
use rayon::prelude::*;

/// The verdicts on the manoeuvres, and the requested traces and logs.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct JudgedManoeuvres {
    /// The verdict on each manoeuvre, to be added to the verdict on the map ([`crate::verify::MapVerdict::with_scenarios`]).
    pub verdicts: Vec<ScenarioVerdict>,
    /// Their torque source, in words; `None` without a manoeuvre.
    pub note: Option<String>,
    /// The nominal runs over time; `None` when they were not requested or no manoeuvre was tested.
    pub traces: Option<ManoeuvreTraces>,
    /// Logs of the nominal runs, one for each manoeuvre that was tested, and of the worst perturbed ones; empty when they were not requested.
    pub logs: Vec<RunLog>,
}

/// Judges every manoeuvre of `settings`; traces and logs are taken from the same runs.
///
/// # Errors
/// A vehicle that cannot be simulated, a path that cannot be planned. A badly driven manoeuvre is a verdict, not an error.
pub(crate) fn judge_manoeuvres(maps: &Maps, settings: &ManoeuvreSettings, wanted: Wanted<'_>) -> Result<JudgedManoeuvres> {
    let vehicle = &settings.vehicle;
    let varied = draws(vehicle, &settings.spread, settings.draws, settings.seed)?;
    let total = settings.manoeuvres.iter().filter(|m| m.reason_against(maps, vehicle).is_none()).count() * (varied.len() + 1);
    let done = || {
        if let Some(progress) = wanted.progress {
            progress(total);
        }
    };
    let stage = ManoeuvreStage {
        maps,
        settings,
        bench: ManoeuvreBench::new(maps, vehicle, &settings.controller)?,
        varied: &varied,
        wanted,
        done: &done,
    };
    let judged: Result<Vec<JudgedManoeuvre>> = settings.manoeuvres.par_iter().map(|manoeuvre| stage.judge(manoeuvre)).collect();
    let mut all = JudgedManoeuvres { verdicts: Vec::new(), note: None, traces: None, logs: Vec::new() };
    if !settings.manoeuvres.is_empty() {
        all.note = Some(ManoeuvreTorque::what(maps));
    }
    let mut traces = Vec::new();
    for judged in judged? {
        all.verdicts.push(judged.verdict);
        traces.extend(judged.trace);
        all.logs.extend(judged.logs);
    }
    if !traces.is_empty() {
        all.traces = Some(ManoeuvreTraces::new(maps, settings.draws, traces));
    }
    Ok(all)
}

/// The inputs of the judgement.
struct ManoeuvreStage<'a> {
    maps: &'a Maps,
    settings: &'a ManoeuvreSettings,
    bench: ManoeuvreBench<'a>,
    varied: &'a [(sim::WorldSettings, u64)],
    wanted: Wanted<'a>,
    /// Called each time a run has ended.
    done: &'a (dyn Fn() + Sync),
}

/// One manoeuvre judged.
struct JudgedManoeuvre {
    verdict: ScenarioVerdict,
    trace: Option<ManoeuvreTrace>,
    logs: Vec<RunLog>,
}

impl ManoeuvreStage<'_> {
    fn judge(&self, manoeuvre: &Manoeuvre) -> Result<JudgedManoeuvre> {
        let (settings, vehicle) = (self.settings, &self.settings.vehicle);
        let (name, class) = (&manoeuvre.name, manoeuvre.class);
        if let Some(why) = manoeuvre.reason_against(self.maps, vehicle) {
            let not_tested = ScenarioVerdict::not_tested(name, &manoeuvre.what, class, why);
            return Ok(JudgedManoeuvre {
                verdict: ScenarioVerdict { scene: manoeuvre.scene.clone(), ..not_tested },
                trace: None,
                logs: Vec::new(),
            });
        }
        let planned = manoeuvre.plan(self.bench.vehicle.wheelbase_m)?;
        let what = &match planned.as_ref().and_then(|planned| planned.moves) {
            Some([moves, shuffles]) if shuffles > 0 => {
                format!("{}; {moves} moves, {shuffles} of them along the slot's axis", manoeuvre.what)
            }
            _ => manoeuvre.what.clone(),
        };
        let bench = ManoeuvreBench { planned: planned.as_ref(), ..self.bench.clone() };
        let path = match &planned {
            Some(planned) => planned.path.clone(),
            None => manoeuvre.reference(bench.vehicle.wheelbase_m)?,
        };
        let mut log = if self.wanted.logs { Some(ManoeuvreLog::of_scenario(&vehicle.vehicle, name, what, &path)?) } else { None };
        let (mut uncompensated, mut moments) = (Vec::new(), Vec::new());
        let keep = |kept: &mut Vec<ManoeuvreMoment>, moment: &ManoeuvreMoment| {
            if self.wanted.traces {
                kept.push(*moment);
            }
        };
        let first = EachMoment(|moment: &ManoeuvreMoment| keep(&mut uncompensated, moment));
        let second = (EachMoment(|moment: &ManoeuvreMoment| keep(&mut moments, moment)), &mut log);
        let nominal = manoeuvre.run(&bench, vehicle, settings.seed, first, second);
        (self.done)();
        let (nominal, nominal_end) = nominal?;
        let one = |(plant, seed): &(sim::WorldSettings, u64)| {
            let ended = manoeuvre.run(&bench, plant, *seed, (), ());
            (self.done)();
            ended
        };
        let runs: Result<Vec<(Values, DriveEnd)>> = self.varied.par_iter().map(one).collect();
        let runs = runs?;
        let metrics = MetricSummary::all(&nominal, &runs.iter().map(|run| run.0).collect::<Vec<_>>());
        let mut verdict = ScenarioVerdict::new(name, what, class, (metrics, runs.len()), &settings.gate);
        verdict.about = ManoeuvreTorque::about(self.maps);
        verdict.scene.clone_from(&manoeuvre.scene);
        verdict.notes.extend(endings(&verdict, &nominal_end, &runs));
        let worst = worst_run(runs.iter().map(|run| &run.0), &verdict.checks).filter(|_| self.wanted.worst_logs);
        let mut logs = Vec::new();
        if let Some(worst) = worst {
            let (plant, seed) = &self.varied[worst];
            let what = format!("{what}; the worst of {} perturbed vehicles, draw {}", runs.len(), worst + 1);
            let mut log = Some(ManoeuvreLog::of_scenario(&plant.vehicle, name, &what, &path)?);
            manoeuvre.run(&bench, plant, *seed, (), &mut log)?;
            let bytes = log.map(ManoeuvreLog::finish).transpose()?;
            logs.extend(bytes.map(|bytes| RunLog { name: format!("{name}.worst"), bytes }));
        }
        let nominal = NominalRun { path: &path, planned: planned.as_ref(), uncompensated: &uncompensated, moments: &moments };
        let trace = self.wanted.traces.then(|| ManoeuvreTrace::new(manoeuvre, verdict.clone(), &nominal));
        let bytes = log.map(ManoeuvreLog::finish).transpose()?;
        logs.splice(0..0, bytes.map(|bytes| RunLog { name: name.clone(), bytes }));
        Ok(JudgedManoeuvre { verdict, trace, logs })
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::manoeuvre::ManoeuvreKind;
    use crate::verify::Status;
    use crate::verify::reference_maps::known_maps;

    #[test]
    fn traces_and_logs_come_with_the_verdicts_and_do_not_change_them() {
        let mut settings = ManoeuvreSettings { draws: 1, ..ManoeuvreSettings::new().unwrap() };
        let (table1, table2) = known_maps(&settings.vehicle).unwrap();
        let maps = Maps::new(table1, table2).unwrap();
        let all = Manoeuvre::all().into_iter();
        settings.manoeuvres = all.filter(|m| m.name == "polyline-lqr" || matches!(m.kind, ManoeuvreKind::Compensation(_))).collect();
        let plain = judge_manoeuvres(&maps, &settings, Wanted::default()).unwrap();
        let rich = judge_manoeuvres(&maps, &settings, Wanted { traces: true, logs: true, worst_logs: true, progress: None }).unwrap();
        assert_eq!((&plain.verdicts, &plain.note), (&rich.verdicts, &rich.note));
        assert!(plain.traces.is_none() && plain.logs.is_empty());
        // without a lateral table nothing is compensated
        let status: Vec<_> = rich.verdicts.iter().map(|v| v.status).collect();
        assert_eq!(status, [[Status::Pass].as_slice(), &[Status::NotTested; 4]].concat());
        let traces = rich.traces.unwrap();
        let logs: Vec<&str> = rich.logs.iter().map(|log| log.name.as_str()).collect();
        assert_eq!((traces.manoeuvres.len(), logs), (1, vec!["polyline-lqr", "polyline-lqr.worst"]));
        assert!(rich.logs[0].bytes != rich.logs[1].bytes, "another vehicle");
        // a map of one wheel angle drives the turns on the spot alone
        assert_eq!(
            rich.verdicts[0].about.as_deref(),
            Some("the path planner and its laws, not the map: torque away from 90° is the plant's exact inverse")
        );
        assert_eq!(traces.manoeuvres[0].verdict, rich.verdicts[0]);
        assert!(traces.manoeuvres[0].driven_m.len() > 20 && !traces.manoeuvres[0].errors.is_empty());
    }

    #[test]
    fn both_bundled_vehicles_drive_every_polyline_within_the_gate() {
        for vehicle in [include_str!("../../data/vehicles/scrubber.toml"), include_str!("../../data/vehicles/sweeper.toml")] {
            let vehicle = crate::sim::VehicleFile::from_toml(vehicle).unwrap().settings();
            let (table1, table2) = known_maps(&vehicle).unwrap();
            let maps = Maps::new(table1, table2).unwrap();
            let manoeuvres: Vec<Manoeuvre> = Manoeuvre::all().into_iter().filter(|m| m.class == crate::verify::Class::Polyline).collect();
            let settings = ManoeuvreSettings { draws: 8, vehicle, manoeuvres, ..ManoeuvreSettings::new().unwrap() };
            for verdict in judge_manoeuvres(&maps, &settings, Wanted::default()).unwrap().verdicts {
                assert_eq!(verdict.status, Status::Pass, "{}: {:?}", verdict.name, verdict.notes);
            }
        }
    }

    #[test]
    fn without_a_manoeuvre_there_is_nothing_to_note() {
        let settings = ManoeuvreSettings::new().unwrap();
        let (table1, table2) = known_maps(&settings.vehicle).unwrap();
        let none = judge_manoeuvres(&Maps::new(table1, table2).unwrap(), &settings, Wanted::default()).unwrap();
        assert_eq!(none, JudgedManoeuvres { verdicts: Vec::new(), note: None, traces: None, logs: Vec::new() });
    }
}
