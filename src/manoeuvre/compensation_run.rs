//! The compensation scenario: a path driven with mounting errors, once without and once with the run-time law, on the same noise.

use crate::control::{Accumulation, CompensationEntry, CompensationSettings, CompensationTable, Inputs, LateralCompensation};
use crate::guidance::path::PosePath;
use crate::guidance::route::clothoid_path::{ClothoidPiece, course};
use crate::guidance::route::follower::{DriveStage, FollowerSettings};
use crate::guidance::route::tracking::{LawName, TrackingSettings};
use crate::manoeuvre::Result;
use crate::manoeuvre::bench::ManoeuvreBench;
use crate::manoeuvre::drive::{Commanded, ManoeuvreObserver, ManoeuvreStart, Mounting, drive_manoeuvre};
use crate::manoeuvre::endings::DriveEnd;
use crate::manoeuvre::lateral_metrics::{LateralFigures, LateralMetrics, compared};
use crate::manoeuvre::legs_driver::LegsDriver;
use crate::map::{Gear, LateralTableFile};
use crate::scene::RouteKeys;
use crate::sim;
use crate::units::RAD_PER_DEG;
use crate::verify::Values;
use serde::Serialize;

/// The task and the mounting errors.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CompensationScenario {
    /// Direction of travel.
    pub direction: Gear,
    /// Tracking law; the same as in the calibration.
    pub law: LawName,
    /// Navigation's heading minus the vehicle's [°]. Default 1.0.
    pub yaw_deg: f64,
    /// True wheel angle minus reported wheel angle [°]. Default −0.8 forward, 0.8 in reverse, so that both errors push to the same side.
    pub steering_zero_deg: f64,
    /// Averaging length of the error in the run-time law. Default a distance of 5 m.
    pub accumulation: Accumulation,
    /// Distance on which the compensation is estimated [m]. Default 50.
    pub learning_m: f64,
    /// Distance on which both drives are compared [m]: a straight, a bend of 90° and a straight. Default 35.
    pub measured_m: f64,
    /// The pieces of a route of the user's in place of that path.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) route: Option<Vec<ClothoidPiece>>,
}

/// Control periods in which 5 m pass at the usual 0.8 m/s.
pub(crate) const PERIODS: Accumulation = Accumulation::Periods(313);

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
        let accumulation = CompensationSettings::default().accumulation;
        let steering_zero_deg = -direction.sign() * 0.8;
        Self {
            direction,
            law: LawName::Lqr,
            yaw_deg: 1.0,
            steering_zero_deg,
            accumulation,
            learning_m: 50.0,
            measured_m: 35.0,
            route: None,
        }
    }

    /// Along the route of a scene file.
    pub(crate) fn of_route(keys: &RouteKeys) -> Self {
        let ([yaw_deg, steering_zero_deg], [learning_m, measured_m]) = (keys.mounting_deg(), keys.stretches_m());
        let (direction, law, accumulation) = (keys.gear(), keys.law(), keys.accumulation());
        Self { direction, law, yaw_deg, steering_zero_deg, accumulation, learning_m, measured_m, route: Some(keys.pieces()) }
    }

    /// The path: straight, then the measured stretch with its bend; or the route of a scene file.
    pub fn path(&self, wheelbase_m: f64) -> PosePath {
        if let Some(route) = &self.route {
            return course(route, wheelbase_m);
        }
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
    ) -> Result<(Values, DriveEnd)> {
        let (before, before_end) = self.once(bench, plant, seed, None, uncompensated)?;
        let law = match &bench.maps.lateral {
            Some(file) => Some(LateralCompensation::new(
                CompensationSettings { accumulation: self.accumulation, ..CompensationSettings::default() }.checked()?,
                table(file)?,
            )),
            None => None,
        };
        let (after, after_end) = self.once(bench, plant, seed, law, observer)?;
        let ended = before_end.arrived() && after_end.arrived();
        Ok((compared(&before, &after, ended), if before_end.arrived() { after_end } else { before_end }))
    }

    /// One of the two drives.
    fn once(
        &self,
        bench: &ManoeuvreBench<'_>,
        plant: &sim::WorldSettings,
        seed: u64,
        mut law: Option<LateralCompensation>,
        observer: impl ManoeuvreObserver,
    ) -> Result<(LateralFigures, DriveEnd)> {
        let path = self.path(bench.vehicle.wheelbase_m);
        let settings = FollowerSettings::new(&bench.vehicle, TrackingSettings::new(self.law)).with_loop(&bench.controller.path_tracking);
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
        let mut observers = (LateralMetrics::new(&path, measured_m, bench.vehicle.wheelbase_m), observer);
        let start = ManoeuvreStart::default();
        let end = drive_manoeuvre(plant, seed, &start, &mounting, settings.limits.period_s, controller, &mut observers)?;
        Ok((observers.0.figures, end))
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::manoeuvre::{Manoeuvre, ManoeuvreKind, ManoeuvreSettings, replay_manoeuvre};
    use crate::verify::reference_maps::known_maps;
    use crate::verify::{Maps, Metric};

    #[test]
    fn the_path_is_learned_on_and_then_measured_round_a_bend_of_90_degrees() {
        for direction in Gear::ALL {
            let scenario = CompensationScenario::new(direction);
            let path = scenario.path(0.9);
            // a metre beyond the measured stretch, for the stop
            assert!((path.length_m() - (scenario.learning_m + scenario.measured_m + 1.0)).abs() < 1e-6, "{} m", path.length_m());
            assert!(path.poses.iter().all(|pose| pose.direction == direction));
            let turned_rad = path.poses.last().unwrap().heading_rad - path.poses[0].heading_rad;
            assert!((turned_rad - direction.sign() * std::f64::consts::FRAC_PI_2).abs() < 1e-6, "{turned_rad}");
            // no bend where the compensation is estimated
            assert!(path.poses.iter().filter(|pose| pose.s_m < scenario.learning_m).all(|pose| pose.curvature_per_m == 0.0));
        }
    }

    #[test]
    fn both_errors_push_to_the_same_side_in_either_direction() {
        for direction in Gear::ALL {
            let scenario = CompensationScenario::new(direction);
            assert!(scenario.yaw_deg * direction.sign() * scenario.steering_zero_deg < 0.0, "{scenario:?}");
        }
    }

    #[test]
    fn without_a_table_both_drives_are_the_same() {
        let settings = ManoeuvreSettings::new().unwrap();
        let (table1, table2) = known_maps(&settings.vehicle).unwrap();
        let maps = Maps::new(table1, table2).unwrap();
        let manoeuvre = Manoeuvre::all().into_iter().find(|m| matches!(m.kind, ManoeuvreKind::Compensation(_))).unwrap();
        let mut compensated = 0;
        let values = replay_manoeuvre(&maps, &settings, &manoeuvre, |m| compensated += u32::from(m.compensation_rad != 0.0)).unwrap();
        assert_eq!((values.get(Metric::AsExpected), values.get(Metric::LateralRatio), compensated), (Some(1.0), Some(1.0), 0));
        assert!(values.get(Metric::LateralBeforeM).unwrap() > 0.01, "the mounting errors must show");
    }
}
