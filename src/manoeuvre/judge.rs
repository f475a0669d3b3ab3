//! Runs the manoeuvres, nominal and perturbed, and applies the gate.

use crate::manoeuvre::bench::Bench;
use crate::manoeuvre::drive::Moment;
use crate::manoeuvre::planned::Planned;
use crate::manoeuvre::scenario::Manoeuvre;
use crate::manoeuvre::torque::ManoeuvreTorque;
use crate::sim;
use crate::sim::VehicleFile;
use crate::verify::judge::Settings;
use crate::verify::metric::{Metric, Summary, Values};
use crate::verify::perturbations::draws;
use crate::verify::verdict::{ScenarioVerdict, Status};
use crate::verify::{Maps, Result};
use rayon::prelude::*;

/// The bundled scrubber, on which manoeuvres are driven unless told otherwise.
///
/// # Errors
/// None in practice: the file is part of the program.
pub fn bundled_vehicle() -> Result<sim::Settings> {
    Ok(VehicleFile::from_toml(include_str!("../../data/vehicles/scrubber.toml"))?.settings())
}

fn bench<'a>(maps: &'a Maps, settings: &Settings) -> Result<Bench<'a>> {
    let plant = &settings.manoeuvre_vehicle;
    Ok(Bench { maps, torque: ManoeuvreTorque::new(Some(maps), plant)?, wheelbase_m: plant.vehicle.wheelbase_m, planned: None })
}

/// Judges every manoeuvre of `settings`.
pub(crate) fn judge(maps: &Maps, settings: &Settings) -> Result<Vec<ScenarioVerdict>> {
    let bench = bench(maps, settings)?;
    let plant = &settings.manoeuvre_vehicle;
    let varied = draws(plant, &settings.spread, settings.manoeuvre_draws, settings.seed)?;
    settings
        .manoeuvres
        .par_iter()
        .map(|manoeuvre| {
            let mut verdict = ScenarioVerdict {
                name: manoeuvre.name.clone(),
                what: manoeuvre.what.clone(),
                class: manoeuvre.class,
                status: Status::NotTested,
                notes: Vec::new(),
                metrics: Vec::new(),
                checks: Vec::new(),
            };
            if let Some(why) = manoeuvre.hindrance(maps, plant) {
                verdict.notes.push(why);
                return Ok(verdict);
            }
            let planned = manoeuvre.plan(bench.wheelbase_m)?;
            let bench = Bench { planned: planned.as_ref(), ..bench.clone() };
            let nominal = manoeuvre.run(&bench, plant, settings.seed, |_| {})?;
            let runs: Result<Vec<Values>> = varied.par_iter().map(|(plant, seed)| manoeuvre.run(&bench, plant, *seed, |_| {})).collect();
            let runs = runs?;
            verdict.metrics = Metric::ALL.into_iter().filter_map(|metric| Summary::new(metric, &nominal, &runs)).collect();
            verdict.checks = settings.gate.check(manoeuvre.class, &verdict.metrics);
            verdict.status = if verdict.checks.iter().all(|c| c.pass) { Status::Pass } else { Status::Fail };
            Ok(verdict)
        })
        .collect()
}

/// Runs one manoeuvre on the nominal vehicle and shows every control period to `record`.
///
/// # Errors
/// A vehicle that cannot be simulated.
pub fn replay(maps: &Maps, settings: &Settings, manoeuvre: &Manoeuvre, record: impl FnMut(&Moment)) -> Result<Values> {
    replay_planned(maps, settings, manoeuvre, None, record)
}

/// As [`replay`], along a plan that was made before.
pub(crate) fn replay_planned(
    maps: &Maps,
    settings: &Settings,
    manoeuvre: &Manoeuvre,
    planned: Option<&Planned>,
    record: impl FnMut(&Moment),
) -> Result<Values> {
    manoeuvre.run(&Bench { planned, ..bench(maps, settings)? }, &settings.manoeuvre_vehicle, settings.seed, record)
}
