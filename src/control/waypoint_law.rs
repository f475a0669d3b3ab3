//! The law of the map: waypoints that carry speeds → preview → desired acceleration → look-up → torque.

use super::Preview;
use super::drive_law::{DriveInputs, DriveLaw};
use super::messages::{DriveStep, PivotRequest, Pose};
use super::numeric::sin_cos;
use super::path::{Nearest, Place};
use super::speed_loop::{SpeedLoop, SpeedLoopSettings};
use super::torque_map::TorqueMap;
use crate::map::Gear;
use serde::Serialize;

/// Settings of the law.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct WaypointLawSettings {
    /// Control period [s]. Default 0.02.
    pub period_s: f64,
    /// Distance from the rear axle to the front wheel's centre [m].
    pub wheelbase_m: f64,
    /// How the wheel is placed on the path. Default projection.
    pub nearest: Nearest,
    /// How far the law looks ahead.
    pub preview: Preview,
    /// Gains and limits of the speed loop.
    pub speed_loop: SpeedLoopSettings,
    /// Below this speed [m/s] the wheel counts as standing: a desired acceleration of zero or less then gives no torque. Default 0.02, above
    /// the quantum of a usual encoder.
    pub standstill_mps: f64,
    /// The end is reached when less than this is left of the arc [m]. Default 0.02.
    pub end_threshold_m: f64,
    /// Fastest change of the torque [N·m/s]; `None`, the default, leaves it free.
    pub torque_rate_nm_s: Option<f64>,
}

impl WaypointLawSettings {
    /// The defaults for a wheelbase [m].
    pub fn new(wheelbase_m: f64) -> Self {
        Self {
            period_s: 0.02,
            wheelbase_m,
            nearest: Nearest::default(),
            preview: Preview::default(),
            speed_loop: SpeedLoopSettings::default(),
            standstill_mps: 0.02,
            end_threshold_m: 0.02,
            torque_rate_nm_s: None,
        }
    }
}

/// The law with its map and memory.
#[derive(Debug, Clone)]
pub struct WaypointLaw<M> {
    settings: WaypointLawSettings,
    map: M,
    place: Place,
    speed_loop: SpeedLoop,
    accel_mps2: f64,
    torque_nm: f64,
    saturated: bool,
}

impl<M: TorqueMap> WaypointLaw<M> {
    /// A law that asks `map`.
    pub fn new(settings: WaypointLawSettings, map: M) -> Self {
        Self { settings, map, place: Place::default(), speed_loop: SpeedLoop::default(), accel_mps2: 0.0, torque_nm: 0.0, saturated: false }
    }
}

impl<M: TorqueMap> DriveLaw for WaypointLaw<M> {
    fn start(&mut self, _request: &PivotRequest, _pose: Pose) {
        self.place = Place::default();
        self.speed_loop = SpeedLoop::default();
        (self.accel_mps2, self.torque_nm, self.saturated) = (0.0, 0.0, false);
    }

    fn step(&mut self, request: &PivotRequest, inputs: &DriveInputs) -> Option<DriveStep> {
        let settings = &self.settings;
        let (path, speed_mps) = (&request.path, inputs.speed_mps);
        let (sin, cos) = sin_cos(inputs.pose.heading_rad);
        let (x_m, y_m) = (inputs.pose.x_m + settings.wheelbase_m * cos, inputs.pose.y_m + settings.wheelbase_m * sin);
        self.place = path.locate(settings.nearest, x_m, y_m, self.place);
        let ahead_m = settings.preview.distance_m(speed_mps, self.accel_mps2);
        let target_speed_mps = path.speed_at(self.place.arc_m + ahead_m, self.place.index);
        let error_mps = target_speed_mps - speed_mps;
        let (accel_mps2, limited) = self.speed_loop.step(&settings.speed_loop, error_mps, self.saturated, settings.period_s);
        // a wheel that the sensor sees rolling back a little is looked up as standing
        let looked_up_mps = if speed_mps < 0.0 { 0.0 } else { speed_mps };
        let found = self.map.torque(request.gear, looked_up_mps, accel_mps2)?;
        // standing, and nothing wanted: the table's row at v = 0 holds the torque of a wheel that just moves, which would be held for nothing
        let wanted_nm = if speed_mps < settings.standstill_mps && accel_mps2 <= 0.0 { 0.0 } else { found.torque_nm };
        let torque_nm = match settings.torque_rate_nm_s {
            Some(rate) => {
                let step = rate.abs() * settings.period_s;
                wanted_nm.max(self.torque_nm - step).min(self.torque_nm + step)
            }
            None => wanted_nm,
        };
        self.saturated = torque_nm != wanted_nm || found.outside;
        (self.accel_mps2, self.torque_nm) = (accel_mps2, torque_nm);
        let end_reached = path.length_m() - self.place.arc_m < settings.end_threshold_m;
        Some(DriveStep {
            torque_nm,
            target_speed_mps,
            speed_mps: looked_up_mps,
            accel_mps2,
            arc_m: self.place.arc_m,
            limited,
            outside_table: found.outside,
            end_reached,
        })
    }

    fn braking_torque_nm(&self, gear: Gear, speed_mps: f64, decel_mps2: f64) -> f64 {
        self.map.torque(gear, speed_mps, -decel_mps2).map_or(0.0, |found| found.torque_nm)
    }
}
