//! One run: a controller and a world in closed loop, and what is measured of it.

use super::Result;
use super::metric::{Metric, Values};
use super::region::Region;
use super::scenario::{Disturbance, Expected, Onset, Scenario};
use crate::control::{DriveLaw, Failure, Inputs, Outputs, Phase, PivotController, PivotRequest, Pose, Settings};
use crate::map::Gear;
use crate::sim::{self, Fault, Measurement, TrueState, World};
use crate::units::RAD_PER_DEG;

/// What a run needs to know of the vehicle under test.
#[derive(Debug, Clone, Copy)]
pub(super) struct Bench<'a> {
    /// Settings of the controller; the scenario's policy replaces theirs.
    pub(super) control: &'a Settings,
    /// Control period [s].
    pub(super) period_s: f64,
    /// Torque limit [N·m].
    pub(super) torque_limit_nm: f64,
    /// Breakaway torque of the map [N·m].
    pub(super) breakaway_nm: f64,
    /// Where Table 2 was measured.
    pub(super) region: &'a Region,
}

/// One control period of a run, for a log or a picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Moment {
    /// The truth at the start of the period.
    pub state: TrueState,
    /// What the controller read.
    pub seen: Measurement,
    /// What it commanded.
    pub command: Outputs,
}

/// Longest simulated time of one turn [s]: the controller's own time-outs come first.
const LONGEST_S: f64 = 120.0;
/// How long a failed run is watched [s]: a vehicle at 0.6 m/s has stopped by then, and the torque has to stay away.
const WATCHED_S: f64 = 2.5;
/// How long before a turn begins [s]: sensors have read at least once.
const SETTLE_S: f64 = 0.1;

/// Runs `scenario` and measures it; `record` sees every period.
pub(super) fn run<L: DriveLaw>(
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
    let above_breakaway = |share: f64| bench.breakaway_nm + share * (bench.torque_limit_nm - bench.breakaway_nm);
    match disturbance {
        Disturbance::Obstacle => world.set_estop(true),
        Disturbance::SteeringStuck => world.inject(Fault::SteeringStuck),
        Disturbance::SteeringSlow { rate_factor } => world.inject(Fault::SteeringSlow { rate_factor }),
        Disturbance::SteeringImplausible => world.inject(Fault::SteeringOffset { offset_rad: 3.0 }),
        Disturbance::SpeedLost => world.inject(Fault::SpeedSensorLost),
        Disturbance::Slope { grade } => world.inject(Fault::Slope { grade_rad: grade.atan(), uphill_heading_rad: 0.0 }),
        Disturbance::WetFloor { share } => world.inject(Fault::WetFloor { grip_nm: above_breakaway(share) }),
        Disturbance::LowBattery { share } => world.inject(Fault::TorqueLimit { limit_nm: above_breakaway(share) }),
    }
}

/// Watches a run and adds up its metrics. Over several turns the largest counts, and the mean of shares.
struct Watch<'a> {
    bench: &'a Bench<'a>,
    settings: &'a Settings,
    wheelbase_m: f64,
    start: TrueState,
    turn_rad: f64,
    length_m: f64,
    gear: Gear,
    arc_m: f64,
    heading_error_rad: f64,
    overshoot_rad: f64,
    drift_m: f64,
    squares: f64,
    largest_mps: f64,
    driving_periods: f64,
    saturated: f64,
    outside: f64,
    limit_nm: f64,
    peak_accel_mps2: f64,
    peak_jerk_mps3: f64,
    start_jerk_mps3: f64,
    means_mps: [f64; 2],
    since_drive_s: Option<f64>,
    standing_since_s: f64,
    settling_s: f64,
    begun_s: f64,
    time_s: f64,
    failed: bool,
    drive_after_failure_nm: f64,
    travel_after_failure_m: f64,
}

impl<'a> Watch<'a> {
    fn new(bench: &'a Bench<'a>, settings: &'a Settings, plant: &sim::Settings) -> Self {
        Self {
            bench,
            settings,
            wheelbase_m: plant.vehicle.wheelbase_m,
            start: TrueState::default(),
            turn_rad: 0.0,
            length_m: 0.0,
            gear: Gear::Forward,
            arc_m: 0.0,
            heading_error_rad: 0.0,
            overshoot_rad: 0.0,
            drift_m: 0.0,
            squares: 0.0,
            largest_mps: 0.0,
            driving_periods: 0.0,
            saturated: 0.0,
            outside: 0.0,
            limit_nm: bench.torque_limit_nm.min(plant.drive.torque_limit_nm),
            peak_accel_mps2: 0.0,
            peak_jerk_mps3: 0.0,
            start_jerk_mps3: 0.0,
            means_mps: [0.0; 2],
            since_drive_s: None,
            standing_since_s: 0.0,
            settling_s: 0.0,
            begun_s: 0.0,
            time_s: 0.0,
            failed: false,
            drive_after_failure_nm: 0.0,
            travel_after_failure_m: 0.0,
        }
    }

    fn begin(&mut self, state: &TrueState, turn_rad: f64) {
        let sin = (self.settings.planning.test_angle_rad).sin().abs();
        (self.start, self.turn_rad, self.begun_s) = (*state, turn_rad, state.t_s);
        self.length_m = self.wheelbase_m * turn_rad.abs() / sin;
        self.arc_m = 0.0;
        self.since_drive_s = None;
        self.means_mps = [state.speed_mps; 2];
    }

    /// `mean_mps`: mean of the true speed over the period that `moment` began.
    fn see(&mut self, moment: &Moment, mean_mps: f64) {
        let (state, command, period_s) = (&moment.state, &moment.command, self.bench.period_s);
        if let Some(gear) = command.gear {
            self.gear = gear;
        }
        let sign = self.gear.sign();
        let accel = (mean_mps - self.means_mps[1]) / period_s;
        let jerk = (mean_mps - 2.0 * self.means_mps[1] + self.means_mps[0]) / (period_s * period_s);
        self.means_mps = [self.means_mps[1], mean_mps];
        self.peak_accel_mps2 = self.peak_accel_mps2.max(accel.abs());
        self.peak_jerk_mps3 = self.peak_jerk_mps3.max(jerk.abs());
        if command.phase == Phase::Driving {
            let since_s = self.since_drive_s.map_or(0.0, |s| s + period_s);
            self.since_drive_s = Some(since_s);
            if since_s <= 0.5 {
                self.start_jerk_mps3 = self.start_jerk_mps3.max(jerk.abs());
            }
            let error_mps = sign * state.speed_mps - self.settings.planning.profile.speed_at(self.arc_m, self.length_m);
            self.squares += error_mps * error_mps;
            self.largest_mps = self.largest_mps.max(error_mps.abs());
            self.driving_periods += 1.0;
            if let Some(drive) = command.drive {
                // 1e-6: an interpolated table value at its limit may miss it by its rounding
                self.saturated += f64::from(u8::from(drive.torque_nm.abs() >= self.limit_nm - 1e-6));
                self.outside += f64::from(u8::from(!self.bench.region.contains(self.gear, drive.speed_mps, drive.accel_mps2)));
            }
            self.drift_m = self.drift_m.max(self.drift(state));
        } else if let Some(since_s) = self.since_drive_s.as_mut() {
            *since_s += period_s;
        }
        if mean_mps.abs() > 1e-3 {
            self.standing_since_s = self.since_drive_s.unwrap_or(0.0);
        }
        let turned_rad = (state.heading_rad - self.start.heading_rad) * self.turn_rad.signum();
        if command.phase.is_active() || matches!(command.phase, Phase::Succeeded) {
            self.overshoot_rad = self.overshoot_rad.max(turned_rad - self.turn_rad.abs());
        }
        if let Phase::Failed(failure) = command.phase {
            self.drive_after_failure_nm = self.drive_after_failure_nm.max(sign * command.torque_nm);
            self.travel_after_failure_m += mean_mps.abs() * period_s;
            // after an implausible angle the wheel is not where it seems to be; nothing else to tell
            let _: Failure = failure;
        }
        self.arc_m += sign * mean_mps * period_s;
    }

    /// Distance of the reference point from its place on the circle that it should follow [m].
    fn drift(&self, state: &TrueState) -> f64 {
        let (sin, cos) = self.settings.planning.test_angle_rad.sin_cos();
        let mirrored = self.gear == Gear::Forward && self.turn_rad < 0.0;
        let to_centre_m = self.wheelbase_m * cos / sin * if mirrored { -1.0 } else { 1.0 };
        let centre = |s: &TrueState| (s.x_m - s.heading_rad.sin() * to_centre_m, s.y_m + s.heading_rad.cos() * to_centre_m);
        let ((x0, y0), (x, y)) = (centre(&self.start), centre(state));
        f64::hypot(x - x0, y - y0)
    }

    fn end(&mut self, state: &TrueState, failed: bool) {
        let turned_rad = state.heading_rad - self.start.heading_rad;
        self.heading_error_rad = self.heading_error_rad.max((turned_rad - self.turn_rad).abs());
        self.settling_s = self.settling_s.max(self.standing_since_s);
        self.time_s += state.t_s - self.begun_s;
        self.failed |= failed;
    }

    fn values(&self, scenario: &Scenario) -> Values {
        let mut values = Values::default();
        values.set(Metric::PeakAccelMps2, self.peak_accel_mps2);
        values.set(Metric::PeakJerkMps3, self.peak_jerk_mps3);
        if self.failed {
            values.set(Metric::DriveAfterFailureNm, self.drive_after_failure_nm);
            values.set(Metric::TravelAfterFailureM, self.travel_after_failure_m);
        } else {
            values.set(Metric::TimeS, self.time_s);
            values.set(Metric::SettlingTimeS, self.settling_s);
        }
        if scenario.expected == Expected::Success {
            // a turn that failed has an error too: what is missing
            values.set(Metric::HeadingErrorDeg, self.heading_error_rad / RAD_PER_DEG);
            values.set(Metric::OvershootDeg, self.overshoot_rad / RAD_PER_DEG);
        }
        if self.driving_periods > 0.0 {
            values.set(Metric::DriftM, self.drift_m);
            values.set(Metric::SpeedRmsMps, (self.squares / self.driving_periods).sqrt());
            values.set(Metric::SpeedMaxMps, self.largest_mps);
            values.set(Metric::StartJerkMps3, self.start_jerk_mps3);
            values.set(Metric::SaturatedShare, self.saturated / self.driving_periods);
            values.set(Metric::OutsideShare, self.outside / self.driving_periods);
        }
        values
    }
}
