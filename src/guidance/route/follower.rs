//! Drives one leg of a path: a tracking law steers, the speed plan, the speed loop and a torque source drive.
//!
//! Stages: the wheel turns to the law's angle while the vehicle rests; it drives; it stops at its stopping distance from the end. One
//! period: nearest point → wheel angle (law + compensation); preview of the planned speed → speed loop → desired acceleration → torque.

use crate::control::numeric::sin_cos;
use crate::control::{Inputs, Preview, SpeedLoop, SpeedLoopSettings};
use crate::guidance::route::path_position::{Leg, Matched, lateral_error_m};
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
    /// Time from a command to its effect [s]. Default 0.12: dead time, lag and one period.
    pub reaction_s: f64,
    /// Resting this long while it should drive, or steering this long, is a failure [s]. Default 4.
    pub stall_s: f64,
}

impl FollowerSettings {
    /// The defaults for a wheelbase [m] and a law.
    pub(crate) fn new(wheelbase_m: f64, tracking: TrackingSettings) -> Self {
        Self {
            limits: Limits::new(wheelbase_m),
            tracking,
            speed: SegmentSpeed::default(),
            preview: Preview::default(),
            speed_loop: SpeedLoopSettings { min_accel_mps2: -1.5, max_accel_mps2: 1.0, ..SpeedLoopSettings::default() },
            standstill_mps: 0.02,
            angle_tolerance_rad: 2.0 * RAD_PER_DEG,
            stop_decel_mps2: 0.3,
            reaction_s: 0.12,
            stall_s: 4.0,
        }
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
    speed_loop: SpeedLoop,
    stage: DriveStage,
    index: usize,
    accel_mps2: f64,
    standing_s: f64,
}

/// Deceleration that ends within the remaining distance [m/s²], from a quarter to three times the planned one.
pub(crate) fn stop_decel(speed_mps: f64, left_m: f64, planned_mps2: f64) -> f64 {
    let exact = if left_m > 0.0 { 0.5 * speed_mps * speed_mps / left_m } else { f64::INFINITY };
    exact.max(0.25 * planned_mps2).min(3.0 * planned_mps2)
}

/// Time at zero speed that counts as at rest [s].
const AT_REST_S: f64 = 0.3;
/// Remaining distance that counts as none [m]: more than the rounding of a place on the path, far less than any sensor shows.
const AT_END_M: f64 = 1e-6;

impl PathFollower {
    /// A follower at the start of its first leg.
    pub(crate) fn new(settings: FollowerSettings) -> Self {
        let law = TrackingLaw::new(settings.tracking);
        Self { settings, law, speed_loop: SpeedLoop::default(), stage: DriveStage::Steering, index: 0, accel_mps2: 0.0, standing_s: 0.0 }
    }

    /// Resets the state for a new leg.
    pub(crate) fn start(&mut self) {
        self.law.start();
        (self.speed_loop, self.stage, self.index) = (SpeedLoop::default(), DriveStage::Steering, 0);
        (self.accel_mps2, self.standing_s) = (0.0, 0.0);
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
        self.standing_s = if speed_mps < settings.standstill_mps { self.standing_s + period_s } else { 0.0 };
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
                let needs_m = track.speed_mps * (settings.reaction_s + 0.5 * track.speed_mps / settings.stop_decel_mps2);
                // above that speed the speed loop is still decelerating to the switch-over speed
                let slow = speed_mps <= 2.0 * settings.speed.switch_mps;
                if left_m <= AT_END_M || (slow && left_m <= needs_m) {
                    (self.stage, self.standing_s) = (DriveStage::Stopping, 0.0);
                } else if self.standing_s > settings.stall_s {
                    return self.fail(Trouble::Stalled, inputs, gear);
                }
            }
            DriveStage::Stopping if self.standing_s >= AT_REST_S => self.stage = DriveStage::Arrived,
            _ => {}
        }
        let (target_speed_mps, accel_mps2) = match self.stage {
            DriveStage::Driving => {
                let cos = sin_cos(inputs.wheel_angle_rad).1.max(0.1);
                let ahead_m = settings.preview.distance_m(speed_mps, self.accel_mps2) * cos;
                let target = settings.speed.speed_at(track.matched.s_m - leg.start_m() + ahead_m, leg.end_m() - leg.start_m());
                (target, self.speed_loop.step(&settings.speed_loop, target - speed_mps, false, period_s).0)
            }
            DriveStage::Stopping => (0.0, -stop_decel(track.speed_mps, left_m, settings.stop_decel_mps2)),
            _ => (0.0, 0.0),
        };
        self.accel_mps2 = accel_mps2;
        let rolls = speed_mps >= settings.standstill_mps || accel_mps2 > 0.0;
        let drives = matches!(self.stage, DriveStage::Driving | DriveStage::Stopping) && rolls;
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
