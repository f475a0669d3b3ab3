//! A path driven by a tracking law with a fixed compensation angle, as a run of the lateral calibration, and its log.

use crate::control::Inputs;
use crate::guidance::path::PosePath;
use crate::guidance::route::clothoid_path::{course, lateral_task};
use crate::guidance::route::follower::{DriveCommand, Follower, FollowerSettings, Stage};
use crate::guidance::route::path_position::Leg;
use crate::guidance::route::tracking::{LawName, TrackingSettings};
use crate::guidance::torque_source::TorqueSource;
use crate::manoeuvre::drive::{Moment, Mounting, Start, drive};
use crate::manoeuvre::log::Log;
use crate::manoeuvre::torque::ExactTorque;
use crate::sim;
use crate::verify::Result;

/// One run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LateralRun {
    /// The tracking law.
    pub law: LawName,
    /// Compensation angle [rad].
    pub compensation_rad: f64,
    /// What is mounted wrongly.
    pub mounting: Mounting,
    /// Seed of everything random.
    pub seed: u64,
}

/// In what form a log holds the reference.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum LoggedReference {
    /// The matched point, every period.
    Point,
    /// The whole path, once.
    Path,
    /// Both.
    #[default]
    Both,
}

/// Drives the legs of a path one after the other; `compensation` is told each command's error and gives the angle for the next period.
pub(crate) struct LegsDriver<'a> {
    path: &'a PosePath,
    first: usize,
    leg: usize,
    follower: Follower,
}

impl<'a> LegsDriver<'a> {
    pub(crate) fn new(path: &'a PosePath, settings: FollowerSettings) -> Self {
        Self { path, first: 0, leg: 0, follower: Follower::new(settings) }
    }

    pub(crate) fn leg(&self) -> usize {
        self.leg
    }

    pub(crate) fn current(&self) -> Option<Leg<'a>> {
        Leg::first(self.path.poses.get(self.first..)?)
    }

    pub(crate) fn step<T: TorqueSource>(&mut self, inputs: &Inputs, torque: &T, compensation_rad: f64) -> Option<DriveCommand> {
        let leg = self.current()?;
        let command = self.follower.step(leg, inputs, torque, compensation_rad);
        let end = self.first + leg.last_index();
        if command.stage == Stage::Arrived && end + 1 < self.path.poses.len() {
            (self.first, self.leg) = (end, self.leg + 1);
            self.follower.start();
            return Some(DriveCommand { stage: Stage::Stopping, ..command });
        }
        Some(command)
    }
}

/// The follower of the lateral calibration.
pub(crate) fn follower_settings(wheelbase_m: f64, law: LawName) -> FollowerSettings {
    FollowerSettings::new(wheelbase_m, TrackingSettings::new(law))
}

/// Drives the lateral task (a straight, a bend, around an obstacle, reverse) and shows every period to `record`; returns how it ended.
///
/// # Errors
/// A vehicle that cannot be simulated.
pub fn lateral_run(vehicle: &sim::Settings, run: &LateralRun, mut record: impl FnMut(&Moment)) -> Result<Stage> {
    let wheelbase_m = vehicle.vehicle.wheelbase_m;
    let path = course(&lateral_task(), wheelbase_m);
    let settings = follower_settings(wheelbase_m, run.law);
    let torque = ExactTorque::new(vehicle)?;
    let mut driver = LegsDriver::new(&path, settings);
    let controller = |inputs: &Inputs| {
        let command = driver.step(inputs, &torque, run.compensation_rad).unwrap_or_else(|| DriveCommand::at_rest(inputs.wheel_angle_rad));
        (command, run.compensation_rad, driver.leg())
    };
    drive(vehicle, run.seed, &Start::default(), &run.mounting, settings.limits.period_s, controller, |m| record(m))
}

/// The log of a run: the bytes of an MCAP file, and how it ended.
///
/// # Errors
/// As [`lateral_run`], and what the MCAP writer refuses.
pub fn lateral_log(vehicle: &sim::Settings, run: &LateralRun, reference: LoggedReference) -> Result<(Vec<u8>, Stage)> {
    let mut log = Log::new(&vehicle.vehicle);
    if reference == LoggedReference::Path {
        log = log.without_points();
    }
    if reference != LoggedReference::Point {
        log.reference(&course(&lateral_task(), vehicle.vehicle.wheelbase_m))?;
    }
    let mut outcome = Ok(());
    let stage = lateral_run(vehicle, run, |moment| {
        if outcome.is_ok() {
            outcome = log.write(moment);
        }
    })?;
    outcome?;
    Ok((log.finish()?, stage))
}
