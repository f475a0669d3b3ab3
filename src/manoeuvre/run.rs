//! One manoeuvre on one vehicle.

use crate::guidance::route::polyline::PolylinePlan;
use crate::manoeuvre::Result;
use crate::manoeuvre::bench::ManoeuvreBench;
use crate::manoeuvre::drive::{ManoeuvreMoment, ManoeuvreObserver};
use crate::manoeuvre::endings::DriveEnd;
use crate::manoeuvre::scenario::{Manoeuvre, ManoeuvreKind};
use crate::manoeuvre::settings::ManoeuvreSettings;
use crate::manoeuvre::{planned_run, polyline_run};
use crate::sim;
use crate::verify::drive::EachMoment;
use crate::verify::{Maps, Values};

impl Manoeuvre {
    /// Runs it on `plant`, computes the metrics, and says how and where it ended. `observer` sees every period. A compensation is driven twice: `uncompensated` sees the
    /// first drive, `observer` the second.
    pub(crate) fn run(
        &self,
        bench: &ManoeuvreBench<'_>,
        plant: &sim::WorldSettings,
        seed: u64,
        uncompensated: impl ManoeuvreObserver,
        observer: impl ManoeuvreObserver,
    ) -> Result<(Values, DriveEnd)> {
        match &self.kind {
            ManoeuvreKind::Polyline { law, points, settings } => {
                let plan = PolylinePlan::new(points, settings)?;
                polyline_run::run(bench, *law, (&plan, settings), plant, seed, observer)
            }
            ManoeuvreKind::Compensation(scenario) => scenario.run(bench, plant, seed, uncompensated, observer),
            ManoeuvreKind::Planned(task) => match bench.planned {
                Some(planned) => planned_run::run(bench, planned, plant, seed, observer),
                None => planned_run::run(bench, &task.plan(bench.vehicle.wheelbase_m)?, plant, seed, observer),
            },
        }
    }
}

/// Runs one manoeuvre on the nominal vehicle and shows every control period to `record`.
///
/// # Errors
/// A vehicle that cannot be simulated.
pub fn replay_manoeuvre(
    maps: &Maps,
    settings: &ManoeuvreSettings,
    manoeuvre: &Manoeuvre,
    record: impl FnMut(&ManoeuvreMoment),
) -> Result<Values> {
    let bench = ManoeuvreBench::new(maps, &settings.vehicle, &settings.controller)?;
    Ok(manoeuvre.run(&bench, &settings.vehicle, settings.seed, (), EachMoment(record))?.0)
}
