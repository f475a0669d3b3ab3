//! One run: a controller and a world in closed loop, and what is measured of it.

use crate::control::{DriveLaw, Inputs, Phase, PivotController, PivotRequest, Pose};
use crate::sim;
use crate::sim::{Fault, Measurement, World};
use crate::units::RAD_PER_DEG;
use crate::verify::Result;
use crate::verify::bench::{Bench, Moment};
use crate::verify::metric::{Metric, Values};
use crate::verify::run_metrics::Watch;
use crate::verify::scenario::{Disturbance, Expected, Onset, Scenario};

/// Longest simulated time of one turn [s]: the controller's own time-outs come first.
const LONGEST_S: f64 = 120.0;
/// How long a failed run is watched [s]: a vehicle at 0.6 m/s has stopped by then, and the torque has to stay away.
const WATCHED_S: f64 = 2.5;
/// How long before a turn begins [s]: sensors have read at least once.
const SETTLE_S: f64 = 0.1;

/// Runs `scenario` and measures it; `record` sees every period.
pub(crate) fn run<L: DriveLaw>(
    bench: &Bench<'_>,
    scenario: &Scenario,
    plant: &sim::Settings,
    law: L,
    seed: u64,
    mut record: impl FnMut(&Moment, Option<&PivotRequest>),
) -> Result<Values> {
    let mut settings = *bench.control;
    settings.planning.policy = scenario.policy;
    let mut controller = PivotController::new(&settings, law)?;
    let mut world = World::new(plant, seed)?;
    world.place_wheel(scenario.start_wheel_deg * RAD_PER_DEG);
    let onset = match scenario.disturbance {
        Some((disturbance, None)) => {
            begin(&mut world, disturbance, bench);
            None
        }
        Some((disturbance, Some(onset))) => Some((disturbance, onset)),
        None => None,
    };
    let steps = (bench.period_s / plant.step_s).round().max(1.0) as usize;
    let mut watch = Watch::new(bench, &settings, plant);
    for _ in 0..(SETTLE_S / bench.period_s) as usize {
        period(&mut world, &mut controller, steps, &mut watch, &mut record);
    }
    let mut expected_end = true;
    for &turn_deg in &scenario.turns_deg {
        let turn_rad = turn_deg * RAD_PER_DEG;
        watch.begin(&world.state(), turn_rad);
        controller.request(turn_rad, pose(&world.measure()))?;
        let mut pending = onset;
        let (mut last_phase, mut in_phase_s) = (controller.phase(), 0.0);
        let mut left_s = LONGEST_S;
        while controller.phase().is_active() && left_s > 0.0 {
            if let Some((disturbance, Onset { phase, after_s })) = pending
                && phase == controller.phase()
                && in_phase_s >= after_s
            {
                begin(&mut world, disturbance, bench);
                pending = None;
            }
            period(&mut world, &mut controller, steps, &mut watch, &mut record);
            in_phase_s = if controller.phase() == last_phase { in_phase_s + bench.period_s } else { 0.0 };
            last_phase = controller.phase();
            left_s -= bench.period_s;
        }
        let failed = controller.phase() != Phase::Succeeded;
        expected_end &= match scenario.expected {
            Expected::Success => !failed,
            Expected::Failure(failure) => controller.phase() == Phase::Failed(failure),
        };
        if failed {
            for _ in 0..(WATCHED_S / bench.period_s) as usize {
                period(&mut world, &mut controller, steps, &mut watch, &mut record);
            }
        }
        watch.end(&world.state(), failed);
        if failed {
            break;
        }
    }
    let mut values = watch.values(scenario);
    values.set(Metric::AsExpected, f64::from(u8::from(expected_end)));
    Ok(values)
}

fn pose(seen: &Measurement) -> Pose {
    Pose { x_m: seen.x_m, y_m: seen.y_m, heading_rad: seen.heading_rad }
}

/// One control period: read, command, and let the world go on.
fn period<L: DriveLaw>(
    world: &mut World,
    controller: &mut PivotController<L>,
    steps: usize,
    watch: &mut Watch<'_>,
    record: &mut impl FnMut(&Moment, Option<&PivotRequest>),
) {
    let (state, seen) = (world.state(), world.measure());
    let command = controller.step(&Inputs {
        speed_mps: seen.speed_mps,
        wheel_angle_rad: seen.wheel_angle_rad,
        pose: pose(&seen),
        gear: seen.gear,
        estop: seen.estop,
    });
    let moment = Moment { state, seen, command };
    record(&moment, controller.current());
    let order = sim::Command { torque_nm: command.torque_nm, wheel_angle_rad: command.wheel_angle_rad, gear: command.gear };
    let mut sum_mps = 0.0;
    for _ in 0..steps {
        world.step(&order);
        sum_mps += world.state().speed_mps;
    }
    watch.see(&moment, sum_mps / steps as f64);
}

/// Lets a disturbance begin.
fn begin(world: &mut World, disturbance: Disturbance, bench: &Bench<'_>) {
    // never so little that the vehicle cannot set off
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
