//! Drives the turns of a scenario with a controller of pivots, and starts the scenario's disturbance at its time.

use crate::control::{Phase, PivotRequest};
use crate::sim::{Fault, World, WorldCommand};
use crate::units::RAD_PER_DEG;
use crate::verify::Result;
use crate::verify::bench::{PivotBench, PivotMoment};
use crate::verify::drive::{Driver, inputs, pose};
use crate::verify::pivot_law::PivotControl;
use crate::verify::scenario::{Disturbance, Expected, Onset, Scenario};

/// Longest simulated time of one turn [s]: the time-outs of a controller come first.
const LONGEST_S: f64 = 120.0;
/// Time that a failed run continues [s]: a vehicle at 0.6 m/s stops within it, and the torque must stay zero.
const AFTER_FAILURE_S: f64 = 2.5;
/// Time before the first turn [s]: every sensor has read at least once.
const SETTLE_S: f64 = 0.1;

/// A turn of the scenario.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct AskedTurn {
    /// Its number, from 0.
    pub(crate) index: usize,
    /// Angle [rad], left positive.
    pub(crate) turn_rad: f64,
}

/// Part of a run.
#[derive(Debug, Clone, Copy)]
enum RunPart {
    /// Before the first turn, with periods left.
    Settling(usize),
    /// In a turn, with time left for it [s].
    Turning(f64),
    /// After a failure, with periods left.
    Failed(usize),
}

/// The driver of a scenario.
pub(crate) struct PivotDriver<'a, C: PivotControl> {
    bench: &'a PivotBench<'a>,
    scenario: &'a Scenario,
    controller: C,
    part: RunPart,
    turn: Option<AskedTurn>,
    /// The disturbance that has not yet begun in this turn.
    pending: Option<(Disturbance, Onset)>,
    last_phase: Phase,
    in_phase_s: f64,
    as_expected: bool,
    /// The turn that did not end.
    endless: Option<String>,
}

impl<'a, C: PivotControl> PivotDriver<'a, C> {
    /// The driver at the start of `scenario`. A disturbance without an onset begins now.
    pub(crate) fn new(bench: &'a PivotBench<'a>, scenario: &'a Scenario, controller: C, world: &mut World) -> Self {
        world.place_wheel(scenario.start_wheel_deg * RAD_PER_DEG);
        if let Some((disturbance, None)) = scenario.disturbance {
            begin(world, disturbance, bench);
        }
        Self {
            last_phase: controller.phase(),
            bench,
            scenario,
            controller,
            part: RunPart::Settling((SETTLE_S / bench.period_s) as usize),
            turn: None,
            pending: None,
            in_phase_s: 0.0,
            as_expected: true,
            endless: None,
        }
    }

    /// The last requested turn; `None` before the first.
    pub(crate) fn turn(&self) -> Option<AskedTurn> {
        self.turn
    }

    /// The current request.
    pub(crate) fn request(&self) -> Option<&PivotRequest> {
        self.controller.current()
    }

    /// Whether the last turn failed.
    pub(crate) fn failed(&self) -> bool {
        matches!(self.part, RunPart::Failed(_))
    }

    /// What went wrong with the controller itself: it broke, or a turn did not end.
    pub(crate) fn fault(&self) -> Option<&str> {
        self.controller.fault().or(self.endless.as_deref())
    }

    /// Whether every turn has ended as the scenario expects.
    pub(crate) fn as_expected(&self) -> bool {
        self.as_expected
    }

    /// Requests the next turn; `false` if there is none.
    fn ask(&mut self, world: &World) -> Result<bool> {
        let index = self.turn.map_or(0, |turn| turn.index + 1);
        let Some(&turn_deg) = self.scenario.turns_deg.get(index) else { return Ok(false) };
        let turn_rad = turn_deg * RAD_PER_DEG;
        self.controller.request(turn_rad, pose(&world.measure()))?;
        self.turn = Some(AskedTurn { index, turn_rad });
        self.pending = match self.scenario.disturbance {
            Some((disturbance, Some(onset))) => Some((disturbance, onset)),
            _ => None,
        };
        (self.last_phase, self.in_phase_s) = (self.controller.phase(), 0.0);
        self.part = RunPart::Turning(LONGEST_S);
        Ok(true)
    }

    /// Judges how a turn ended. `true` when it succeeded.
    fn end_turn(&mut self) -> bool {
        let phase = self.controller.phase();
        let failed = phase != Phase::Succeeded;
        if phase.is_active() {
            let number = self.turn.map_or(0, |turn| turn.index + 1);
            self.endless = Some(format!("turn {number} did not end within {LONGEST_S} s"));
        }
        self.as_expected &= match self.scenario.expected {
            Expected::Success => !failed,
            Expected::Failure(failure) => phase == Phase::Failed(failure),
        };
        if failed {
            self.part = RunPart::Failed((AFTER_FAILURE_S / self.bench.period_s) as usize);
        }
        !failed
    }

    /// Starts the disturbance when its time has come.
    fn disturb(&mut self, world: &mut World) {
        if let Some((disturbance, Onset { phase, after_s })) = self.pending
            && phase == self.controller.phase()
            && self.in_phase_s >= after_s
        {
            begin(world, disturbance, self.bench);
            self.pending = None;
        }
    }
}

impl<C: PivotControl> Driver for PivotDriver<'_, C> {
    type Moment = PivotMoment;

    fn prepare(&mut self, world: &mut World) -> Result<bool> {
        loop {
            match &mut self.part {
                RunPart::Failed(0) => return Ok(false),
                RunPart::Settling(left @ 1..) | RunPart::Failed(left) => {
                    *left -= 1;
                    return Ok(true);
                }
                RunPart::Turning(left_s) if self.controller.phase().is_active() && *left_s > 0.0 => {
                    self.disturb(world);
                    return Ok(true);
                }
                RunPart::Turning(_) => {
                    if self.end_turn() && !self.ask(world)? {
                        return Ok(false);
                    }
                }
                RunPart::Settling(0) => {
                    if !self.ask(world)? {
                        return Ok(false);
                    }
                }
            }
        }
    }

    fn command(&mut self, world: &World) -> (PivotMoment, WorldCommand) {
        let (state, seen) = (world.state(), world.measure());
        let command = self.controller.step(state.t_s, &inputs(&seen));
        if let RunPart::Turning(left_s) = &mut self.part {
            let phase = self.controller.phase();
            self.in_phase_s = if phase == self.last_phase { self.in_phase_s + self.bench.period_s } else { 0.0 };
            self.last_phase = phase;
            *left_s -= self.bench.period_s;
        }
        let order = WorldCommand { torque_nm: command.torque_nm, wheel_angle_rad: command.wheel_angle_rad, gear: command.gear };
        (PivotMoment { state, seen, command }, order)
    }
}

/// Starts a disturbance.
fn begin(world: &mut World, disturbance: Disturbance, bench: &PivotBench<'_>) {
    // always enough for the vehicle to start
    let [holding_nm, planned_nm] = bench.planned_nm;
    let of_the_plan = |share: f64| (holding_nm + share * (planned_nm - holding_nm)).max(1.1 * bench.breakaway_nm);
    match disturbance {
        Disturbance::Obstacle => world.set_estop(true),
        Disturbance::SteeringStuck => world.inject(Fault::SteeringStuck),
        Disturbance::SteeringSlow { rate_factor } => world.inject(Fault::SteeringSlow { rate_factor }),
        Disturbance::SteeringImplausible => world.inject(Fault::SteeringOffset { offset_rad: 3.0 }),
        Disturbance::SpeedLost => world.inject(Fault::SpeedSensorLost),
        Disturbance::Slope { grade } => world.inject(Fault::Slope { grade_rad: grade.atan(), uphill_heading_rad: 0.0 }),
        Disturbance::WetFloor { share } => world.inject(Fault::WetFloor { grip_nm: of_the_plan(share) }),
        Disturbance::LowBattery { share } => world.inject(Fault::TorqueLimit { limit_nm: of_the_plan(share) }),
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::map::Vehicle;
    use crate::sim::{PhysicalSettings, WorldSettings};
    use crate::verify::bench::PivotMoment;
    use crate::verify::judge::replay;
    use crate::verify::reference_maps::known_maps;
    use crate::verify::{Maps, Metric, Values, VerifySettings};

    fn maps() -> Maps {
        let vehicle = Vehicle {
            wheelbase_m: 0.92,
            wheel_radius_m: 0.12,
            test_angle_deg: 90.0,
            torque_limit_nm: Some(44.0),
            torque_full_scale_nm: None,
        };
        let (table1, table2) = known_maps(&WorldSettings::physical(vehicle, PhysicalSettings::default())).unwrap();
        Maps::new(table1, table2).unwrap()
    }

    fn driven(name: &str) -> (Vec<PivotMoment>, Values) {
        let scenario = Scenario::all().into_iter().find(|s| s.name == name).unwrap();
        let mut moments = Vec::new();
        let values = replay(&maps(), &VerifySettings::new().unwrap(), &scenario, |m| moments.push(*m)).unwrap();
        (moments, values)
    }

    #[test]
    fn a_disturbance_begins_at_its_time_and_the_run_goes_on_after_the_failure() {
        let (moments, values) = driven("stop-driving");
        let driving = moments.iter().position(|m| m.command.phase == Phase::Driving).unwrap();
        let stopped = moments.iter().position(|m| m.seen.estop).unwrap();
        // 1.5 s of 0.02 s after the first period in which the phase was seen
        assert_eq!(stopped - driving, 76);
        let failed = moments.iter().position(|m| matches!(m.command.phase, Phase::Failed(_))).unwrap();
        assert_eq!(moments.len() - failed, 126, "the period of the failure and 2.5 s after it");
        assert_eq!(values.get(Metric::AsExpected), Some(1.0));
        assert!(values.get(Metric::TravelAfterFailureM).unwrap() > 0.0);
        assert_eq!((values.get(Metric::TimeS), values.get(Metric::HeadingErrorDeg)), (None, None));
    }

    #[test]
    fn turns_follow_one_another_and_their_times_add_up() {
        let (moments, values) = driven("chained");
        let begun = moments.windows(2).filter(|pair| pair[1].command.phase == Phase::Driving && pair[0].command.phase != Phase::Driving);
        assert_eq!(begun.count(), 3);
        let settled_s = moments[5].state.t_s;
        let end_s = moments.last().unwrap().state.t_s + 0.02;
        assert!((values.get(Metric::TimeS).unwrap() - (end_s - settled_s)).abs() < 1e-9);
        assert!((moments.last().unwrap().state.heading_rad.to_degrees() - 180.0).abs() < 1.5);
        assert!(values.get(Metric::HeadingErrorDeg).unwrap() < 1.5, "the largest of three errors");
    }

    #[test]
    fn the_wheel_starts_where_the_scenario_says() {
        assert!((driven("wheel-off-angle").0[0].state.wheel_angle_rad + 35.0 * RAD_PER_DEG).abs() < 1e-12);
    }
}
