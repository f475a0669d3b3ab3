//! The plant, the law and the controller of a verdict, and runs of one law over a scenario: nominal and on every draw.

use crate::control::{OutsidePolicy, PivotSettings, Tables, TorqueFromAccel as _, UnderWay, WaypointLaw, WaypointLawSettings};
use crate::map::{Gear, TorqueTable};
use crate::sim;
use crate::units::RAD_PER_DEG;
use crate::verify::bench::PivotBench;
use crate::verify::controller_command::ControllerCommand;
use crate::verify::controller_under_test::ProcessLaw;
use crate::verify::drive::Observer;
use crate::verify::exact_map::ExactMap;
use crate::verify::measured_region::Region;
use crate::verify::metric::{MetricSummary, Values};
use crate::verify::pivot_driver::PivotDriver;
use crate::verify::pivot_law::PivotLaw;
use crate::verify::run::{DrivenPivot, run};
use crate::verify::scenario::Scenario;
use crate::verify::settings::VerifySettings;
use crate::verify::{Maps, Result};
use rayon::prelude::*;

/// Everything that a scenario is run with.
pub(crate) struct PivotStage<'a> {
    pub(crate) maps: &'a Maps,
    pub(crate) control: PivotSettings,
    pub(crate) law: WaypointLawSettings,
    outside: OutsidePolicy,
    region: Region,
    pub(crate) plant: sim::WorldSettings,
    pub(crate) exact: ExactMap,
    pub(crate) seed: u64,
    /// Called each time a run has ended.
    pub(crate) done: &'a (dyn Fn() + Sync),
}

/// Runs of one law over one scenario: the metrics and the observer of each.
pub(crate) struct PivotRuns<N, O> {
    pub(crate) nominal: (Values, N),
    pub(crate) draws: Vec<(Values, O)>,
    /// What went wrong with the controller itself, per run: the run, and what happened.
    pub(crate) faults: Vec<String>,
}

impl<N, O> PivotRuns<N, O> {
    /// The metrics over the runs.
    pub(crate) fn summaries(&self) -> Vec<MetricSummary> {
        let draws: Vec<Values> = self.draws.iter().map(|d| d.0).collect();
        MetricSummary::all(&self.nominal.0, &draws)
    }
}

impl<'a> PivotStage<'a> {
    /// # Errors
    /// A plant that cannot be simulated.
    pub(crate) fn new(maps: &'a Maps, settings: &VerifySettings, done: &'a (dyn Fn() + Sync)) -> Result<Self> {
        let plant = match (&settings.plant, &settings.given_vehicle) {
            (Some(plant), _) => plant.clone(),
            (None, Some(given)) => sim::WorldSettings::identified(&maps.table1)?.with_given(given),
            (None, None) => sim::WorldSettings::identified(&maps.table1)?,
        };
        let exact = ExactMap::new(&plant)?;
        let (controller, vehicle) = (&settings.controller.settings, &maps.table2.vehicle);
        let law = controller.law(vehicle.wheelbase_m, maps.table2.dead_time_s + maps.table2.lag_s);
        UnderWay::checked(law.reaction_s, law.period_s)?;
        Ok(Self {
            maps,
            control: controller.pivot(vehicle.wheelbase_m, vehicle.test_angle_deg * RAD_PER_DEG),
            law,
            outside: controller.outside(),
            region: Region::new(&maps.table2),
            plant,
            exact,
            seed: settings.seed,
            done,
        })
    }

    /// The law of the map under test.
    pub(crate) fn map_law(&self) -> WaypointLaw<Tables<'a>> {
        let (forward, reverse) = (self.maps.forward.view(), self.maps.reverse.as_ref().map(TorqueTable::view));
        WaypointLaw::new(self.law, Tables { forward, reverse, policy: self.outside })
    }

    /// The law of a process of the user's.
    pub(crate) fn process_law<'b>(&self, command: &'b ControllerCommand) -> ProcessLaw<'b> {
        ProcessLaw {
            command,
            period_s: self.law.period_s,
            wheel_radius_m: self.maps.table2.vehicle.wheel_radius_m,
            torque_limit_nm: self.maps.torque_limit_nm(),
        }
    }

    /// Data of the vehicle that a run needs.
    pub(crate) fn bench(&self) -> PivotBench<'_> {
        let profile = &self.control.planning.profile;
        let torque_nm = |accel| self.exact.torque(Gear::Forward, 0.5 * profile.cruise_mps, accel).map_or(0.0, |found| found.torque_nm);
        PivotBench {
            planned_nm: [torque_nm(0.0), torque_nm(profile.accel_mps2)],
            control: &self.control,
            period_s: self.law.period_s,
            torque_limit_nm: self.maps.torque_limit_nm(),
            breakaway_nm: self.exact.breakaway_nm(),
            region: &self.region,
        }
    }

    /// The nominal run of a law and its runs on the plants `varied`. `nominal` observes the first, one of `draw` each of the others. Where the
    /// controller itself breaks on the nominal plant, the others are not run.
    ///
    /// # Errors
    /// A plant that cannot be simulated, a controller that cannot be set up.
    pub(crate) fn run_all<L, N, O>(
        &self,
        scenario: &Scenario,
        varied: &[(sim::WorldSettings, u64)],
        law: impl Fn() -> L + Sync,
        mut nominal: N,
        draw: impl Fn() -> O + Sync,
    ) -> Result<PivotRuns<N, O>>
    where
        L: PivotLaw,
        N: for<'b> Observer<PivotDriver<'b, L::Controller>>,
        O: for<'b> Observer<PivotDriver<'b, L::Controller>> + Send,
    {
        let bench = self.bench();
        let driven = run(&bench, scenario, &self.plant, law(), self.seed, &mut nominal);
        (self.done)();
        let DrivenPivot { values, fault } = driven?;
        let nominal = (values, nominal);
        if let Some(fault) = fault {
            let not_run = if varied.is_empty() { String::new() } else { format!("; {} perturbed vehicles were not driven", varied.len()) };
            for _ in varied {
                (self.done)();
            }
            return Ok(PivotRuns { nominal, draws: Vec::new(), faults: vec![format!("nominal run, {fault}{not_run}")] });
        }
        let one = |(plant, seed): &(sim::WorldSettings, u64)| {
            let mut observer = draw();
            let driven = run(&bench, scenario, plant, law(), *seed, &mut observer);
            (self.done)();
            Ok((driven?, observer))
        };
        let driven: Result<Vec<(DrivenPivot, O)>> = varied.par_iter().map(one).collect();
        let (mut draws, mut faults) = (Vec::new(), Vec::new());
        for (number, (driven, observer)) in (1..).zip(driven?) {
            faults.extend(driven.fault.map(|fault| format!("perturbed run {number}, {fault}")));
            draws.push((driven.values, observer));
        }
        Ok(PivotRuns { nominal, draws, faults })
    }
}
