//! Turning on the spot towards a heading: two gains, a dead zone, a smallest and a largest rate.
//!
//! The published law of such corners turns a vehicle with two driven sides about its geometric centre. This vehicle cannot: with its wheel at 90°
//! the only fixed point is the middle of the rear axle. So it turns about that, and the front wheel sets the rate, v = L·ω.

use crate::control::numeric::{sqrt, wrapped};
use crate::control::{Arrival, Inputs, SpeedLoop, SpeedLoopSettings, UnderWay};
use crate::controller::module_sections::SpotTurnKeys;
use crate::guidance::route::follower::{DriveCommand, DriveStage, Trouble, stop_accel};
use crate::guidance::route::response::{PERIOD_S, VehicleResponse};
use crate::guidance::torque_source::TorqueSource;
use crate::map::Gear;
use crate::units::RAD_PER_DEG;
use core::f64::consts::FRAC_PI_2;
use serde::Serialize;

/// The rate over the heading error.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub(crate) struct TurnRate {
    /// Gain above the threshold [1/s]. Default 1.5.
    pub large_gain_per_s: f64,
    /// Gain below it [1/s]. Default 0.7.
    pub small_gain_per_s: f64,
    /// Threshold between large and small errors [rad]. Default 25°.
    pub large_rad: f64,
    /// Errors up to this are ignored [rad]. Default 0.5°.
    pub dead_zone_rad: f64,
    /// Smallest rate outside the dead zone [rad/s]. Default 0.08: at a lower rate the wheel sticks.
    pub min_rad_s: f64,
    /// Largest rate [rad/s]. Default 0.6.
    pub max_rad_s: f64,
}

impl Default for TurnRate {
    fn default() -> Self {
        Self {
            large_gain_per_s: 1.5,
            small_gain_per_s: 0.7,
            large_rad: 25.0 * RAD_PER_DEG,
            dead_zone_rad: 0.5 * RAD_PER_DEG,
            min_rad_s: 0.08,
            max_rad_s: 0.6,
        }
    }
}

impl TurnRate {
    /// Rate [rad/s] for a heading error [rad], of its sign; 0 in the dead zone and for an error that is not a number.
    pub(crate) fn rate_rad_s(&self, error_rad: f64) -> f64 {
        let size = error_rad.abs();
        if size.is_nan() || size <= self.dead_zone_rad {
            return 0.0;
        }
        let gain = if size > self.large_rad { self.large_gain_per_s } else { self.small_gain_per_s };
        (gain * size).min(self.max_rad_s).max(self.min_rad_s).copysign(error_rad)
    }
}

/// Settings of a turn.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub(crate) struct TurnSettings {
    /// Rate over error.
    pub rate: TurnRate,
    /// Wheelbase [m].
    pub wheelbase_m: f64,
    /// Control period [s]. Default 0.02.
    pub period_s: f64,
    /// Fastest change of the desired front-wheel speed [m/s²]. Default 0.4.
    pub accel_mps2: f64,
    /// Speed loop. Default that of the pivot.
    pub speed_loop: SpeedLoopSettings,
    /// Largest error of the wheel angle from 90° [rad]. Default 1.5°.
    pub angle_tolerance_rad: f64,
    /// Below this speed [m/s] the wheel counts as resting. Default 0.02.
    pub standstill_mps: f64,
    /// Time from a command to its effect [s]. Default that of the vehicle.
    pub reaction_s: f64,
    /// Deceleration of the stop [m/s²]. Default 0.3.
    pub stop_decel_mps2: f64,
    /// Preview time of the rate [s]. Default that of the pivot, 0.3, for a reaction of 0.12 s, and longer by what a slower vehicle needs more.
    pub preview_s: f64,
    /// Resting or steering this long is a failure [s]. Default 4.
    pub stall_s: f64,
    /// Largest number of corrections after the first stop. Default 6: with 3, one turn of 1400 ends more than 1° off.
    pub corrections: u32,
}

impl TurnSettings {
    /// The defaults for a vehicle.
    pub(crate) fn new(vehicle: &VehicleResponse) -> Self {
        Self {
            rate: TurnRate::default(),
            wheelbase_m: vehicle.wheelbase_m,
            period_s: PERIOD_S,
            accel_mps2: 0.4,
            speed_loop: SpeedLoopSettings::default(),
            angle_tolerance_rad: 1.5 * RAD_PER_DEG,
            standstill_mps: 0.02,
            reaction_s: vehicle.reaction_s(),
            stop_decel_mps2: 0.3,
            preview_s: 0.3 + (vehicle.reaction_s() - 0.12).max(0.0),
            stall_s: 4.0,
            corrections: 6,
        }
    }

    /// The same with the speed loop, preview and stop of a controller file.
    pub(crate) fn with_loop(self, turn: &SpotTurnKeys) -> Self {
        Self {
            accel_mps2: turn.accel_mps2,
            speed_loop: turn.gains(),
            standstill_mps: turn.standstill_speed_mps,
            stop_decel_mps2: turn.stop_decel_mps2,
            preview_s: turn.preview_s.value().unwrap_or(self.preview_s),
            ..self
        }
    }
}

/// One turn on the spot.
#[derive(Debug, Clone)]
pub(crate) struct SpotTurn {
    settings: TurnSettings,
    stage: DriveStage,
    gear: Gear,
    asked_mps: f64,
    speed_loop: SpeedLoop,
    under_way: UnderWay,
    standing_s: f64,
    stops: u32,
    /// How far the stops of this turn go past their aim [m], 0 or more. The next one aims as much short of the heading.
    overrun_m: f64,
}

impl SpotTurn {
    /// A turn that has not begun.
    pub(crate) fn new(settings: TurnSettings) -> Self {
        let (speed_loop, under_way) = (SpeedLoop::default(), UnderWay::new(settings.reaction_s, settings.period_s));
        Self {
            settings,
            stage: DriveStage::Steering,
            gear: Gear::Forward,
            asked_mps: 0.0,
            speed_loop,
            under_way,
            standing_s: 0.0,
            stops: 0,
            overrun_m: 0.0,
        }
    }

    /// One period towards `heading_rad`. The wheel is at 90° to the left; forward gear turns left, reverse gear right.
    /// [`DriveStage::Arrived`] once it rests within the dead zone, or within twice the dead zone after its last correction.
    pub(crate) fn step<T: TorqueSource + ?Sized>(&mut self, heading_rad: f64, inputs: &Inputs, torque: &T) -> DriveCommand {
        let settings = self.settings;
        if matches!(self.stage, DriveStage::Failed(_) | DriveStage::Arrived) {
            return DriveCommand::hold(FRAC_PI_2, Some(self.gear), self.stage);
        }
        if inputs.estop {
            return self.fail(Trouble::ObstacleStop);
        }
        let Some(front_mps) = inputs.speed_mps else { return self.fail(Trouble::SpeedLost) };
        let error_rad = wrapped(heading_rad - inputs.pose.heading_rad);
        let standing = front_mps.abs() < settings.standstill_mps;
        self.standing_s = if standing { self.standing_s + settings.period_s } else { 0.0 };
        match self.stage {
            DriveStage::Steering => {
                if (inputs.wheel_angle_rad - FRAC_PI_2).abs() < settings.angle_tolerance_rad {
                    self.begin(error_rad);
                } else if self.standing_s > settings.stall_s {
                    return self.fail(Trouble::Steering);
                }
            }
            DriveStage::Turning => {
                let (arrival, left_m) = self.arrival(error_rad, front_mps);
                let slow = (self.gear.sign() * front_mps) <= 2.0 * settings.wheelbase_m * settings.rate.min_rad_s;
                let needed_mps2 = arrival.needed_mps2();
                let must = needed_mps2 >= 3.0 * settings.stop_decel_mps2;
                // a correction smaller than the overrun is stopped as soon as the wheel moves
                let is_short = !standing && left_m <= self.overrun_m;
                if left_m <= 0.0 || is_short || must || (slow && needed_mps2 >= settings.stop_decel_mps2) {
                    (self.stage, self.standing_s) = (DriveStage::Stopping, 0.0);
                } else if self.standing_s > settings.stall_s {
                    return self.fail(Trouble::Stalled);
                }
            }
            _ if self.standing_s >= 0.3 => {
                let small = settings.rate.dead_zone_rad;
                // with less friction than in the map every stop goes too far, in both directions alike: without this, corrections would cycle
                let past_m = -self.gear.sign() * error_rad * settings.wheelbase_m;
                self.overrun_m = (self.overrun_m + past_m).max(0.0);
                if error_rad.abs() <= small || (self.stops >= settings.corrections && error_rad.abs() <= 2.0 * small) {
                    self.stage = DriveStage::Arrived;
                } else if self.stops >= settings.corrections {
                    return self.fail(Trouble::Heading);
                } else {
                    self.stops += 1;
                    self.begin(error_rad);
                }
            }
            _ => {}
        }
        let (sign, speed_mps) = (self.gear.sign(), (self.gear.sign() * front_mps).max(0.0));
        let mut coasts = false;
        let accel_mps2 = match self.stage {
            DriveStage::Turning => {
                let ahead_rad = error_rad - sign * speed_mps / settings.wheelbase_m * settings.preview_s;
                // no faster than the planned deceleration stops it, so that a long vehicle begins to slow down earlier
                let brakes_mps = sqrt(2.0 * settings.stop_decel_mps2 * settings.wheelbase_m * (sign * ahead_rad).max(0.0));
                let rate_mps = settings.wheelbase_m * sign * settings.rate.rate_rad_s(ahead_rad);
                let wanted = rate_mps.min(brakes_mps).max(settings.wheelbase_m * settings.rate.min_rad_s);
                let step = settings.accel_mps2 * settings.period_s;
                self.asked_mps = wanted.max(self.asked_mps - step).min(self.asked_mps + step);
                self.speed_loop.step(&settings.speed_loop, self.asked_mps - speed_mps, false, settings.period_s).0
            }
            DriveStage::Stopping => {
                let wanted = stop_accel(self.arrival(error_rad, front_mps).0, settings.stop_decel_mps2);
                coasts = wanted.is_none();
                wanted.unwrap_or(0.0)
            }
            _ => 0.0,
        };
        let rolls = speed_mps >= settings.standstill_mps || accel_mps2 > 0.0;
        self.under_way.push(accel_mps2);
        let drives = matches!(self.stage, DriveStage::Turning | DriveStage::Stopping) && rolls && !coasts;
        DriveCommand {
            torque_nm: if drives { torque.torque_nm(speed_mps.copysign(sign), sign * accel_mps2, inputs.wheel_angle_rad) } else { 0.0 },
            target_speed_mps: if self.stage == DriveStage::Turning { sign * self.asked_mps } else { 0.0 },
            accel_mps2: sign * accel_mps2,
            ..DriveCommand::hold(FRAC_PI_2, Some(self.gear), self.stage)
        }
    }

    /// The wheel at the time when a command acts, and the arc that is left now [m].
    fn arrival(&self, error_rad: f64, front_mps: f64) -> (Arrival, f64) {
        let (settings, sign) = (&self.settings, self.gear.sign());
        let left_m = sign * error_rad * settings.wheelbase_m;
        let aim_m = left_m - self.overrun_m;
        (Arrival::after(settings.reaction_s, sign * front_mps, self.under_way.mean_mps2(), aim_m), left_m)
    }

    fn begin(&mut self, error_rad: f64) {
        self.gear = if error_rad < 0.0 { Gear::Reverse } else { Gear::Forward };
        (self.stage, self.asked_mps, self.standing_s) = (DriveStage::Turning, 0.0, 0.0);
        self.speed_loop = SpeedLoop::default();
        self.under_way = UnderWay::new(self.settings.reaction_s, self.settings.period_s);
    }

    fn fail(&mut self, trouble: Trouble) -> DriveCommand {
        self.stage = DriveStage::Failed(trouble);
        DriveCommand::hold(FRAC_PI_2, Some(self.gear), self.stage)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control::Pose;

    /// Friction by the map, as the deceleration that it alone would give [m/s²].
    const FRICTION_MPS2: f64 = 0.5;

    /// A wheel on which 1 N·m accelerates by 1 m/s².
    struct Unit;

    impl TorqueSource for Unit {
        fn torque_nm(&self, speed_mps: f64, accel_mps2: f64, _wheel_angle_rad: f64) -> f64 {
            accel_mps2 + FRICTION_MPS2.copysign(speed_mps)
        }
    }

    /// The outcome of a turn to `goal_rad`, the heading at its end [rad] and the number of corrections. A command acts after `delay`
    /// periods; friction is by `easier_mps2` lower than in the map once the wheel moves.
    fn driven(goal_rad: f64, delay: usize, easier_mps2: f64) -> (DriveStage, f64, u32) {
        let settings = TurnSettings::new(&VehicleResponse::quick(0.9));
        let mut turn = SpotTurn::new(settings);
        let (mut heading_rad, mut speed_mps, mut pending) = (0.0, 0.0_f64, std::collections::VecDeque::from(vec![0.0; delay]));
        for _ in 0..2000 {
            let pose = Pose { x_m: 0.0, y_m: 0.0, heading_rad };
            let inputs = Inputs { speed_mps: Some(speed_mps), wheel_angle_rad: FRAC_PI_2, pose, gear: Some(turn.gear), estop: false };
            let command = turn.step(goal_rad, &inputs, &Unit);
            if matches!(command.stage, DriveStage::Arrived | DriveStage::Failed(_)) {
                return (command.stage, heading_rad, turn.stops);
            }
            pending.push_back(command.torque_nm);
            let torque_nm = pending.pop_front().unwrap_or(0.0);
            let sign = turn.gear.sign();
            let moved_mps = speed_mps + (torque_nm - sign * (FRICTION_MPS2 - easier_mps2)) * settings.period_s;
            let moves = speed_mps != 0.0 || torque_nm.abs() > FRICTION_MPS2;
            speed_mps = if moves && moved_mps * sign > 0.0 { moved_mps } else { 0.0 };
            heading_rad += speed_mps / settings.wheelbase_m * settings.period_s;
        }
        (turn.stage, heading_rad, turn.stops)
    }

    #[test]
    fn corrections_do_not_cycle_where_every_stop_goes_too_far() {
        for (delay, easier_mps2) in [(5, 0.0), (5, 0.09), (5, 0.12), (7, 0.15)] {
            for goal_deg in [14.0_f64, -25.0, 60.0, 90.0] {
                let (stage, heading_rad, stops) = driven(goal_deg * RAD_PER_DEG, delay, easier_mps2);
                let off_deg = heading_rad / RAD_PER_DEG - goal_deg;
                let case = format!("{goal_deg}°, {delay} periods, {easier_mps2} m/s²: {off_deg:.2}° off, {stops} corrections");
                assert!(stage == DriveStage::Arrived && off_deg.abs() <= 0.5 && stops <= 1, "{stage:?} {case}");
            }
        }
    }

    #[test]
    fn the_default_controller_file_has_the_defaults_of_path_tracking_and_turns() {
        use crate::guidance::route::follower::FollowerSettings;
        use crate::guidance::route::tracking::{LawName, TrackingSettings};
        let controller = crate::controller::ControllerSettings::default();
        let (vehicle, law) = (VehicleResponse::quick(0.9), TrackingSettings::new(LawName::Lqr));
        let (follower, turn) = (FollowerSettings::new(&vehicle, law), TurnSettings::new(&vehicle));
        assert_eq!(follower.with_loop(&controller.path_tracking), follower);
        assert_eq!(turn.with_loop(&controller.spot_turn), turn);
    }

    #[test]
    fn the_rate_has_two_gains_a_dead_zone_and_limits() {
        let law = TurnRate::default();
        let deg = |d: f64| law.rate_rad_s(d * RAD_PER_DEG);
        assert_eq!((deg(0.4), deg(-0.4), law.rate_rad_s(f64::NAN)), (0.0, 0.0, 0.0));
        assert_eq!((deg(1.0), deg(-1.0)), (0.08, -0.08));
        assert!((deg(20.0) - 0.7 * 20.0 * RAD_PER_DEG).abs() < 1e-12);
        assert_eq!((deg(26.0), deg(-170.0)), (0.6, -0.6));
    }
}
