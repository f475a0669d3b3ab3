//! Drives one leg of a path: a tracking law steers, the speed plan, the speed loop and a torque source drive.
//!
//! Stages: the wheel turns to the law's angle while the vehicle rests; it drives; it stops at its stopping distance from the end. One
//! period: nearest point → wheel angle (law + compensation); preview of the planned speed → speed loop → desired acceleration → torque.

use crate::control::numeric::sin_cos;
use crate::control::{Arrival, Inputs, Preview, SpeedLoop, SpeedLoopSettings, UnderWay};
use crate::controller::module_sections::TrackingKeys;
use crate::guidance::route::leg_speed::LegSpeed;
use crate::guidance::route::path_position::{Leg, Matched, lateral_error_m};
use crate::guidance::route::response::{PERIOD_S, VehicleResponse};
use crate::guidance::route::segment_speed::SegmentSpeed;
use crate::guidance::route::track::{Limits, TrackState};
use crate::guidance::route::tracking::{TrackingLaw, TrackingSettings};
use crate::guidance::torque_source::TorqueSource;
use crate::map::Gear;
use crate::units::RAD_PER_DEG;
use serde::Serialize;

/// Settings of the follower.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub(crate) struct FollowerSettings {
    /// Wheelbase, largest wheel angle, control period.
    pub limits: Limits,
    /// The tracking law.
    pub tracking: TrackingSettings,
    /// Speed plan of a leg.
    pub speed: SegmentSpeed,
    /// Preview of the planned speed.
    pub preview: Preview,
    /// Speed loop. Default that of the pivot with −1.5…1.0 m/s².
    pub speed_loop: SpeedLoopSettings,
    /// Below this speed [m/s] the vehicle counts as resting. Default 0.02.
    pub standstill_mps: f64,
    /// Largest wheel-angle error at the start of the drive [rad]. Default 2°.
    pub angle_tolerance_rad: f64,
    /// Deceleration of the stop [m/s²]. Default 0.3.
    pub stop_decel_mps2: f64,
    /// Time from a command to its effect [s]. Default that of the vehicle: dead time, lag and one period.
    pub reaction_s: f64,
    /// Resting this long while it should drive, or steering this long, is a failure [s]. Default 4.
    pub stall_s: f64,
}

impl FollowerSettings {
    /// The defaults for a vehicle and a law.
    pub(crate) fn new(vehicle: &VehicleResponse, tracking: TrackingSettings) -> Self {
        Self {
            limits: Limits { period_s: PERIOD_S, ..Limits::new(vehicle.wheelbase_m) },
            tracking,
            speed: SegmentSpeed::default(),
            preview: Preview::default(),
            speed_loop: SpeedLoopSettings { min_accel_mps2: -1.5, max_accel_mps2: 1.0, ..SpeedLoopSettings::default() },
            standstill_mps: 0.02,
            angle_tolerance_rad: 2.0 * RAD_PER_DEG,
            stop_decel_mps2: 0.3,
            reaction_s: vehicle.reaction_s(),
            stall_s: 4.0,
        }
    }

    /// The same with the speed loop, preview and stop of a controller file.
    pub(crate) fn with_loop(self, tracking: &TrackingKeys) -> Self {
        Self {
            preview: Preview { lag_s: tracking.lag_s, min_m: tracking.least_distance_m },
            speed_loop: tracking.gains(),
            standstill_mps: tracking.standstill_speed_mps,
            stop_decel_mps2: tracking.stop_decel_mps2,
            ..self
        }
    }

    /// Distance before the end at which the stop from the switch-over speed begins [m]: what is travelled until the command acts, and the
    /// braking.
    pub(crate) fn stop_m(&self) -> f64 {
        let switch_mps = self.speed.switch_mps;
        switch_mps * (self.reaction_s + 0.5 * switch_mps / self.stop_decel_mps2)
    }
}

/// Stage of a manoeuvre.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum DriveStage {
    /// The wheel turns to its angle, the vehicle rests.
    Steering,
    /// It drives along a leg.
    Driving,
    /// It comes to rest.
    Stopping,
    /// It turns on the spot.
    Turning,
    /// The end is reached, and the vehicle rests.
    Arrived,
    /// It has failed and gives no torque.
    Failed(Trouble),
}

/// Why a manoeuvre failed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Trouble {
    /// Emergency stop.
    ObstacleStop,
    /// No speed reading.
    SpeedLost,
    /// The wheel did not reach its angle in time.
    Steering,
    /// It did not move although it should.
    Stalled,
    /// The heading was not reached in the turns allowed.
    Heading,
}

/// Commands of one period, vehicle frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DriveCommand {
    /// Torque [N·m].
    pub torque_nm: f64,
    /// Wheel angle [rad].
    pub wheel_angle_rad: f64,
    /// Gear.
    pub gear: Option<Gear>,
    /// Stage of the manoeuvre.
    pub stage: DriveStage,
    /// Desired front-wheel speed [m/s].
    pub target_speed_mps: f64,
    /// Desired acceleration [m/s²].
    pub accel_mps2: f64,
    /// Nearest point of the path.
    pub matched: Option<Matched>,
    /// Lateral error e of the matched point seen from the vehicle [m], as the controller measures it.
    pub lateral_error_m: f64,
}

impl DriveCommand {
    /// Arrived: no further command.
    pub fn at_rest(wheel_angle_rad: f64) -> Self {
        Self::hold(wheel_angle_rad, None, DriveStage::Arrived)
    }

    /// Only an angle to hold.
    pub(crate) fn hold(wheel_angle_rad: f64, gear: Option<Gear>, stage: DriveStage) -> Self {
        Self { torque_nm: 0.0, wheel_angle_rad, gear, stage, target_speed_mps: 0.0, accel_mps2: 0.0, matched: None, lateral_error_m: 0.0 }
    }
}

/// Drives one leg after the other; the leg is an argument of every period.
#[derive(Debug)]
pub(crate) struct PathFollower {
    settings: FollowerSettings,
    law: TrackingLaw,
    /// Speed along the leg; none for the usual speed over the whole leg.
    speed: Option<LegSpeed>,
    speed_loop: SpeedLoop,
    stage: DriveStage,
    index: usize,
    accel_mps2: f64,
    /// Commands that do not act yet.
    under_way: UnderWay,
    standing_s: f64,
    /// Times that it has driven on after a stop short of the end.
    creeps: u32,
}

/// Acceleration that ends at the end of the way [m/s²], 0.8 to 3 times the planned deceleration: a gentler stop would be at the mercy of
/// friction; `None` if the commands under way suffice
/// to stop, so that friction does the rest: a braking torque that acts after the stop would drive the vehicle back.
pub(crate) fn stop_accel(arrival: Arrival, planned_mps2: f64) -> Option<f64> {
    (arrival.speed_mps > 0.0).then(|| -arrival.needed_mps2().max(0.8 * planned_mps2).min(3.0 * planned_mps2))
}

/// Time at zero speed that counts as at rest [s].
const AT_REST_S: f64 = 0.3;
/// It drives on after a stop if more than this is left [m]: half of what a corner may be missed by.
const SHORT_M: f64 = 0.01;
/// Speed at which it drives on [m/s], and how often at most.
const CREEP_MPS: f64 = 0.09;
const CREEPS: u32 = 3;
/// Remaining distance that counts as none [m]: more than the rounding of a place on the path, far less than any sensor shows.
const AT_END_M: f64 = 1e-6;

impl PathFollower {
    /// A follower at the start of its first leg.
    pub(crate) fn new(settings: FollowerSettings) -> Self {
        let law = TrackingLaw::new(settings.tracking);
        let under_way = UnderWay::new(settings.reaction_s, settings.limits.period_s);
        let speed_loop = SpeedLoop::default();
        Self {
            settings,
            law,
            speed: None,
            speed_loop,
            stage: DriveStage::Steering,
            index: 0,
            accel_mps2: 0.0,
            under_way,
            standing_s: 0.0,
            creeps: 0,
        }
    }

    /// Resets the state for a new leg, with its own speeds or the usual one.
    pub(crate) fn start(&mut self, speed: Option<LegSpeed>) {
        self.speed = speed;
        self.law.start();
        (self.speed_loop, self.stage, self.index) = (SpeedLoop::default(), DriveStage::Steering, 0);
        (self.accel_mps2, self.standing_s, self.creeps) = (0.0, 0.0, 0);
        self.under_way = UnderWay::new(self.settings.reaction_s, self.settings.limits.period_s);
    }

    /// One period along `leg`. `compensation_rad` is added to the law's wheel angle.
    pub(crate) fn step<T: TorqueSource + ?Sized>(
        &mut self,
        leg: Leg<'_>,
        inputs: &Inputs,
        torque: &T,
        compensation_rad: f64,
    ) -> DriveCommand {
        let settings = self.settings;
        let (gear, sign) = (leg.gear(), leg.gear().sign());
        if matches!(self.stage, DriveStage::Failed(_)) {
            return DriveCommand::hold(inputs.wheel_angle_rad, Some(gear), self.stage);
        }
        if inputs.estop {
            return self.fail(Trouble::ObstacleStop, inputs, gear);
        }
        let Some(front_mps) = inputs.speed_mps else { return self.fail(Trouble::SpeedLost, inputs, gear) };
        let track = TrackState::new(leg, inputs.pose, self.index, front_mps, inputs.wheel_angle_rad, &settings.limits);
        self.index = track.index;
        let max_rad = settings.limits.max_wheel_rad;
        let wheel_angle_rad = (self.law.wheel_angle_rad(&track) + compensation_rad).max(-max_rad).min(max_rad);
        let speed_mps = (sign * front_mps).max(0.0);
        let left_m = leg.end_m() - track.matched.s_m;
        let period_s = settings.limits.period_s;
        let arrival = Arrival::after(settings.reaction_s, track.speed_mps, self.under_way.mean_mps2(), left_m);
        self.standing_s = if front_mps.abs() < settings.standstill_mps { self.standing_s + period_s } else { 0.0 };
        match self.stage {
            DriveStage::Steering => {
                let off = wheel_angle_rad - inputs.wheel_angle_rad;
                if off.abs() < settings.angle_tolerance_rad {
                    (self.stage, self.standing_s) = (DriveStage::Driving, 0.0);
                } else if self.standing_s > settings.stall_s {
                    return self.fail(Trouble::Steering, inputs, gear);
                }
            }
            DriveStage::Driving => {
                // above that speed the speed loop is still decelerating to the switch-over speed
                let slow = speed_mps <= 1.3 * settings.speed.switch_mps;
                let needed_mps2 = arrival.needed_mps2();
                let must = needed_mps2 >= 3.0 * settings.stop_decel_mps2;
                if left_m <= AT_END_M || must || (slow && needed_mps2 >= settings.stop_decel_mps2) {
                    (self.stage, self.standing_s) = (DriveStage::Stopping, 0.0);
                } else if self.standing_s > settings.stall_s {
                    return self.fail(Trouble::Stalled, inputs, gear);
                }
            }
            DriveStage::Stopping if self.standing_s >= AT_REST_S => {
                // at rest short of the end: on, slowly
                if left_m > SHORT_M && self.creeps < CREEPS {
                    (self.stage, self.standing_s, self.creeps) = (DriveStage::Driving, 0.0, self.creeps + 1);
                    self.speed_loop = SpeedLoop::default();
                    self.under_way = UnderWay::new(settings.reaction_s, period_s);
                } else {
                    self.stage = DriveStage::Arrived;
                }
            }
            _ => {}
        }
        let mut coasts = false;
        let (target_speed_mps, accel_mps2) = match self.stage {
            DriveStage::Driving => {
                let cos = sin_cos(inputs.wheel_angle_rad).1.max(0.1);
                let ahead_m = settings.preview.distance_m(speed_mps, self.accel_mps2) * cos;
                let at_m = track.matched.s_m - leg.start_m() + ahead_m;
                let (length_m, stop_m) = (leg.end_m() - leg.start_m(), settings.stop_m());
                let usual = || settings.speed.speed_at(at_m, length_m - stop_m.min(0.5 * length_m));
                let planned = self.speed.as_ref().map_or_else(usual, |speed| speed.speed_at(at_m, stop_m));
                let target = if self.creeps > 0 { planned.min(CREEP_MPS) } else { planned };
                (target, self.speed_loop.step(&settings.speed_loop, target - speed_mps, false, period_s).0)
            }
            DriveStage::Stopping => {
                let wanted = stop_accel(arrival, settings.stop_decel_mps2);
                coasts = wanted.is_none();
                (0.0, wanted.unwrap_or(0.0))
            }
            _ => (0.0, 0.0),
        };
        self.accel_mps2 = accel_mps2;
        self.under_way.push(accel_mps2);
        let rolls = speed_mps >= settings.standstill_mps || accel_mps2 > 0.0;
        let drives = matches!(self.stage, DriveStage::Driving | DriveStage::Stopping) && rolls && !coasts;
        let torque_nm = if drives { torque.torque_nm(speed_mps.copysign(sign), sign * accel_mps2, inputs.wheel_angle_rad) } else { 0.0 };
        DriveCommand {
            torque_nm,
            wheel_angle_rad,
            gear: Some(gear),
            stage: self.stage,
            target_speed_mps: sign * target_speed_mps,
            accel_mps2: sign * accel_mps2,
            matched: Some(track.matched),
            lateral_error_m: lateral_error_m(inputs.pose, track.matched.x_m, track.matched.y_m),
        }
    }

    fn fail(&mut self, trouble: Trouble, inputs: &Inputs, gear: Gear) -> DriveCommand {
        self.stage = DriveStage::Failed(trouble);
        DriveCommand::hold(inputs.wheel_angle_rad, Some(gear), self.stage)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::guidance::route::tracking::LawName;

    #[test]
    fn a_stop_that_is_already_under_way_brakes_no_further() {
        // 0.1 m/s, and −0.5 m/s² under way for 0.215 s: at rest before a new command acts
        assert_eq!(stop_accel(Arrival::after(0.215, 0.1, -0.5, 0.02), 0.3), None);
        // nothing under way: after 0.215 s 28.5 mm of 50 are left, and 0.1²/(2·0.0285) = 0.1754 m/s² are needed: 0.8·0.3 at least
        assert_eq!(stop_accel(Arrival::after(0.215, 0.1, 0.0, 0.05), 0.3), Some(-0.24));
        let needed = stop_accel(Arrival::after(0.215, 0.1, 0.0, 0.034), 0.3);
        assert!(needed.is_some_and(|a| (a + 0.005 / 0.0125).abs() < 1e-9), "{needed:?}");
        // past the end: three times as hard
        assert!(stop_accel(Arrival::after(0.215, 0.2, 0.0, 0.0), 0.3).is_some_and(|a| (a + 0.9).abs() < 1e-12));
    }

    #[test]
    fn a_slower_vehicle_begins_its_stop_earlier() {
        let quick = VehicleResponse::quick(0.9);
        let slow = VehicleResponse { dead_time_s: 0.085, lag_s: 0.11, ..quick };
        let stop_m = |vehicle: &VehicleResponse| FollowerSettings::new(vehicle, TrackingSettings::new(LawName::Lqr)).stop_m();
        // 0.12 m/s over 0.12 s or 0.215 s, and 0.12²/(2·0.3) of braking
        assert!((stop_m(&quick) - (0.0144 + 0.024)).abs() < 1e-12 && (stop_m(&slow) - (0.0258 + 0.024)).abs() < 1e-12);
    }
}
