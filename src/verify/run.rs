//! One run: a scenario driven by a law on a plant, with its metrics.

use crate::sim;
use crate::sim::World;
use crate::units::RAD_PER_DEG;
use crate::verify::Result;
use crate::verify::bench::PivotBench;
use crate::verify::drive::{Observer, drive, steps_of};
use crate::verify::metric::Values;
use crate::verify::pivot_driver::PivotDriver;
use crate::verify::pivot_law::PivotLaw;
use crate::verify::run_metrics::PivotMetrics;
use crate::verify::scenario::Scenario;

/// What a run came to.
pub(crate) struct DrivenPivot {
    /// Its metrics.
    pub(crate) values: Values,
    /// What went wrong with the controller itself.
    pub(crate) fault: Option<String>,
}

/// Runs `scenario` and computes its metrics; `observer` also sees every period.
///
/// # Errors
/// A plant that cannot be simulated, a controller that cannot be set up or started.
pub(crate) fn run<'a, L: PivotLaw>(
    bench: &'a PivotBench<'a>,
    scenario: &'a Scenario,
    plant: &sim::WorldSettings,
    law: L,
    seed: u64,
    observer: impl Observer<PivotDriver<'a, L::Controller>>,
) -> Result<DrivenPivot> {
    let mut settings = *bench.control;
    settings.planning.policy = scenario.policy;
    if let Some(right_deg) = scenario.right_wheel_deg {
        settings.planning.right_angle_rad = right_deg * RAD_PER_DEG;
    }
    if let Some(return_deg) = scenario.return_wheel_deg {
        settings.planning.return_angle_rad = return_deg * RAD_PER_DEG;
    }
    let mut world = World::new(plant, seed)?;
    let mut driver = PivotDriver::new(bench, scenario, law.controller(&settings)?, &mut world);
    let mut observers = (PivotMetrics::new(bench, &settings, plant), observer);
    drive(&mut world, steps_of(bench.period_s, plant.step_s), &mut driver, &mut observers)?;
    let values = observers.0.values(scenario, &driver, &world.state());
    Ok(DrivenPivot { values, fault: driver.fault().map(str::to_owned) })
}
