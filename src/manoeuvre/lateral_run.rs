//! A path driven by a tracking law with a fixed compensation angle, as a run of the lateral calibration, and its log.

use crate::control::Inputs;
use crate::guidance::path::PosePath;
use crate::guidance::route::clothoid_path::{course, lateral_task};
use crate::guidance::route::follower::{DriveStage, FollowerSettings};
use crate::guidance::route::tracking::{LawName, TrackingSettings};
use crate::manoeuvre::Result;
use crate::manoeuvre::bench::response_of;
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
    let settings = FollowerSettings::new(&response_of(vehicle), TrackingSettings::new(run.law));
    let torque = ExactTorque::new(vehicle)?;
    let mut driver = LegsDriver::new(&path, settings);
    let controller = |inputs: &Inputs| {
        let command = driver.step(inputs, &torque, run.compensation_rad);
        Commanded { command, compensation_rad: run.compensation_rad, leg: driver.leg() }
    };
    let start = ManoeuvreStart::default();
    Ok(drive_manoeuvre(vehicle, run.seed, &start, &run.mounting, settings.limits.period_s, controller, observer)?.stage)
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

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::sim::VehicleFile;
    use std::collections::BTreeMap;

    /// Messages by topic, and the last stage.
    fn logged(reference: LoggedReference) -> (BTreeMap<String, usize>, DriveStage) {
        let run = CalibrationDrive { law: LawName::Lqr, compensation_rad: 0.0, mounting: Mounting::default(), seed: 1 };
        let (bytes, stage) = lateral_log(&VehicleFile::bundled().unwrap().settings(), &run, reference).unwrap();
        let mut topics = BTreeMap::new();
        for message in mcap::MessageStream::new(&bytes).unwrap() {
            *topics.entry(message.unwrap().channel.topic.clone()).or_insert(0) += 1;
        }
        (topics, stage)
    }

    #[test]
    fn the_reference_is_in_the_log_as_it_was_asked_for() {
        let (points, stage) = logged(LoggedReference::Point);
        assert_eq!(stage, DriveStage::Arrived);
        assert!(points["/reference/matched_point"] > 1000 && !points.contains_key("/reference/path"), "{points:?}");
        let (path, _) = logged(LoggedReference::Path);
        assert_eq!(path["/reference/path"], 1);
        assert!(!path.contains_key("/reference/matched_point"), "{path:?}");
        // the rest of the log is the same
        assert_eq!(path["/odom"], points["/odom"]);
    }
}
