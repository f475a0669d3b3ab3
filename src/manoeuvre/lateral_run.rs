//! A path driven by a tracking law with a fixed compensation angle, as a run of the lateral calibration, and its log.

use crate::control::Inputs;
use crate::guidance::path::PosePath;
use crate::guidance::route::clothoid_path::{course, lateral_task};
use crate::guidance::route::follower::{DriveStage, FollowerSettings};
use crate::guidance::route::tracking::{LawName, TrackingSettings};
use crate::manoeuvre::Result;
use crate::manoeuvre::drive::{Commanded, ManoeuvreObserver, ManoeuvreStart, Mounting, drive_manoeuvre};
use crate::manoeuvre::legs_driver::LegsDriver;
use crate::manoeuvre::manoeuvre_log::ManoeuvreLog;
use crate::manoeuvre::torque::ExactTorque;
use crate::sim;

/// One run of the lateral calibration.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct CalibrationDrive {
    /// The tracking law.
    pub law: LawName,
    /// Compensation angle [rad].
    pub compensation_rad: f64,
    /// Mounting errors.
    pub mounting: Mounting,
    /// Seed of everything random.
    pub seed: u64,
}

/// Form of the reference in a log.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) enum LoggedReference {
    /// The matched point, every period.
    Point,
    /// The whole path, once.
    Path,
    /// Both.
    #[default]
    Both,
}

/// The path of the lateral calibration: a straight, a bend, around an obstacle, reverse.
fn task(vehicle: &sim::WorldSettings) -> PosePath {
    course(&lateral_task(), vehicle.vehicle.wheelbase_m)
}

/// Drives the path of the lateral calibration; returns the last stage.
fn lateral_run(vehicle: &sim::WorldSettings, run: &CalibrationDrive, observer: impl ManoeuvreObserver) -> Result<DriveStage> {
    let path = task(vehicle);
    let settings = FollowerSettings::new(vehicle.vehicle.wheelbase_m, TrackingSettings::new(run.law));
    let torque = ExactTorque::new(vehicle)?;
    let mut driver = LegsDriver::new(&path, settings);
    let controller = |inputs: &Inputs| {
        let command = driver.step(inputs, &torque, run.compensation_rad);
        Commanded { command, compensation_rad: run.compensation_rad, leg: driver.leg() }
    };
    drive_manoeuvre(vehicle, run.seed, &ManoeuvreStart::default(), &run.mounting, settings.limits.period_s, controller, observer)
}

/// The log of a run: the bytes of an MCAP file, and the last stage.
///
/// # Errors
/// A vehicle that cannot be simulated, or any error of the MCAP writer.
pub(crate) fn lateral_log(
    vehicle: &sim::WorldSettings,
    run: &CalibrationDrive,
    reference: LoggedReference,
) -> Result<(Vec<u8>, DriveStage)> {
    let mut log = ManoeuvreLog::new(&vehicle.vehicle);
    if reference == LoggedReference::Path {
        log = log.without_points();
    }
    if reference != LoggedReference::Point {
        log.reference(&task(vehicle))?;
    }
    let stage = lateral_run(vehicle, run, &mut log)?;
    Ok((log.finish()?, stage))
}
