//! The compensation scenario: a path driven with mounting errors, once without and once with the run-time law, on the same noise.

use crate::control::{CompensationEntry, CompensationSettings, CompensationTable, Inputs, LateralCompensation};
use crate::guidance::path::PosePath;
use crate::guidance::route::clothoid_path::{ClothoidPiece, course};
use crate::guidance::route::follower::{DriveStage, FollowerSettings};
use crate::guidance::route::tracking::{LawName, TrackingSettings};
use crate::manoeuvre::Result;
use crate::manoeuvre::bench::ManoeuvreBench;
use crate::manoeuvre::drive::{Commanded, ManoeuvreObserver, ManoeuvreStart, Mounting, drive_manoeuvre};
use crate::manoeuvre::lateral_metrics::{LateralFigures, LateralMetrics, compared};
use crate::manoeuvre::legs_driver::LegsDriver;
use crate::map::{Gear, LateralTableFile};
use crate::sim;
use crate::units::RAD_PER_DEG;
use crate::verify::Values;
use serde::Serialize;

/// The task and the mounting errors.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct CompensationScenario {
    /// Direction of travel.
    pub direction: Gear,
    /// Tracking law; the same as in the calibration.
    pub law: LawName,
    /// Navigation's heading minus the vehicle's [°]. Default 1.0.
    pub yaw_deg: f64,
    /// True wheel angle minus reported wheel angle [°]. Default −0.8 forward, 0.8 in reverse, so that both errors push to the same side.
    pub steering_zero_deg: f64,
    /// Distance on which the compensation is estimated [m]. Default 50.
    pub learning_m: f64,
    /// Distance on which both drives are compared [m]: a straight, a bend of 90° and a straight. Default 35.
    pub measured_m: f64,
}

/// The file's table as the run-time law reads it.
fn table(file: &LateralTableFile) -> Result<CompensationTable> {
    let entries: Vec<_> = file.entries.iter().map(|e| CompensationEntry { error_m: e.error_m, angle_rad: e.angle_rad }).collect();
    let curve = file.curve.error_m.iter().zip(&file.curve.angle_rad);
    let points: Vec<_> = curve.map(|(&error_m, &angle_rad)| CompensationEntry { error_m, angle_rad }).collect();
    Ok(CompensationTable::new(&entries, &points)?)
}

impl CompensationScenario {
    /// The default errors.
    pub fn new(direction: Gear) -> Self {
        Self { direction, law: LawName::Lqr, yaw_deg: 1.0, steering_zero_deg: -direction.sign() * 0.8, learning_m: 50.0, measured_m: 35.0 }
    }

    /// The path: straight, then the measured stretch with its bend.
    pub fn path(&self, wheelbase_m: f64) -> PosePath {
        let bend = [
            ClothoidPiece::bend(2.0, 0.0, 0.2),
            ClothoidPiece::bend(2.5 * std::f64::consts::PI - 2.0, 0.2, 0.2),
            ClothoidPiece::bend(2.0, 0.2, 0.0),
        ];
        let bend_m: f64 = bend.iter().map(|p| p.length_m).sum();
        let straight_m = 0.5 * (self.measured_m - bend_m).max(1.0);
        let mut pieces = vec![ClothoidPiece::straight(self.learning_m + straight_m)];
        pieces.extend(bend);
        pieces.push(ClothoidPiece::straight(straight_m + 1.0));
        let turned = |p: ClothoidPiece| if self.direction == Gear::Reverse { p.reversed() } else { p };
        course(&pieces.into_iter().map(turned).collect::<Vec<_>>(), wheelbase_m)
    }

    /// Drives the path twice, without and with the compensation, and compares. `uncompensated` observes the first drive, `observer` the second.
    pub(crate) fn run(
        &self,
        bench: &ManoeuvreBench<'_>,
        plant: &sim::WorldSettings,
        seed: u64,
        uncompensated: impl ManoeuvreObserver,
        observer: impl ManoeuvreObserver,
    ) -> Result<Values> {
        let (before, before_stage) = self.once(bench, plant, seed, None, uncompensated)?;
        let law = match &bench.maps.lateral {
            Some(file) => Some(LateralCompensation::new(CompensationSettings::default(), table(file)?)),
            None => None,
        };
        let (after, after_stage) = self.once(bench, plant, seed, law, observer)?;
        let ended = before_stage == DriveStage::Arrived && after_stage == DriveStage::Arrived;
        Ok(compared(&before, &after, ended))
    }

    /// One of the two drives.
    fn once(
        &self,
        bench: &ManoeuvreBench<'_>,
        plant: &sim::WorldSettings,
        seed: u64,
        mut law: Option<LateralCompensation>,
        observer: impl ManoeuvreObserver,
    ) -> Result<(LateralFigures, DriveStage)> {
        let path = self.path(bench.wheelbase_m);
        let settings = FollowerSettings::new(bench.wheelbase_m, TrackingSettings::new(self.law));
        let mut driver = LegsDriver::new(&path, settings);
        let mounting = Mounting { yaw_rad: self.yaw_deg * RAD_PER_DEG, steering_zero_rad: self.steering_zero_deg * RAD_PER_DEG };
        let (mut compensation_rad, mut last_s_m) = (0.0, 0.0);
        let controller = |inputs: &Inputs| {
            let used_rad = compensation_rad;
            let command = driver.step(inputs, &bench.torque, used_rad);
            if let (Some(law), Some(matched)) = (&mut law, &command.matched) {
                let travelled_m = (matched.s_m - last_s_m).max(0.0);
                let tracking = command.stage == DriveStage::Driving;
                compensation_rad = law.step(self.direction, command.lateral_error_m, travelled_m, matched.curvature_per_m, tracking);
                last_s_m = matched.s_m;
            }
            Commanded { command, compensation_rad: used_rad, leg: driver.leg() }
        };
        let measured_m = self.learning_m..self.learning_m + self.measured_m;
        let mut observers = (LateralMetrics::new(&path, measured_m, bench.wheelbase_m), observer);
        let start = ManoeuvreStart::default();
        let stage = drive_manoeuvre(plant, seed, &start, &mounting, settings.limits.period_s, controller, &mut observers)?;
        Ok((observers.0.figures, stage))
    }
}
