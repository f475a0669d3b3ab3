//! The compensation scenario: a path driven with mounting errors, once without and once with the run-time law, on the same noise.

use crate::control::lateral_compensation::{CompensationEntry, CompensationSettings, CompensationTable, LateralCompensation};
use crate::control::{Inputs, Pose};
use crate::guidance::path::PosePath;
use crate::guidance::route::clothoid_path::{Piece, course};
use crate::guidance::route::follower::{DriveCommand, Stage};
use crate::guidance::route::path_position::{Leg, lateral_error_m};
use crate::guidance::route::tracking::LawName;
use crate::manoeuvre::bench::Bench;
use crate::manoeuvre::drive::{Moment, Mounting, Start, drive};
use crate::manoeuvre::lateral_run::{LegsDriver, follower_settings};
use crate::map::{Gear, LateralTableFile};
use crate::sim;
use crate::units::RAD_PER_DEG;
use crate::verify::Result;
use crate::verify::metric::{Metric, Values};
use serde::Serialize;

/// What is driven and what is mounted wrongly.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct CompensationScenario {
    /// Direction of travel.
    pub direction: Gear,
    /// Tracking law; that of the calibration.
    pub law: LawName,
    /// Navigation's heading minus the vehicle's [°]. Default 1.0.
    pub yaw_deg: f64,
    /// The wheel's angle minus what the steering takes it for [°]. Default −0.8 forward, 0.8 in reverse, so that both errors push to the same side.
    pub steering_zero_deg: f64,
    /// Way on which the compensation is found [m]. Default 50.
    pub learning_m: f64,
    /// Way on which before and after are compared [m]: a straight, a bend of 90° and a straight. Default 35.
    pub measured_m: f64,
}

/// What one of the two drives came to.
#[derive(Debug, Clone, Copy, Default)]
struct Figures {
    error_m: f64,
    way_m: f64,
    /// Σ θ̇² and their number over the whole stretch, and over its straights alone.
    rates: [(f64, f64); 2],
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
        let bend = [Piece::bend(2.0, 0.0, 0.2), Piece::bend(2.5 * std::f64::consts::PI - 2.0, 0.2, 0.2), Piece::bend(2.0, 0.2, 0.0)];
        let bend_m: f64 = bend.iter().map(|p| p.length_m).sum();
        let straight_m = 0.5 * (self.measured_m - bend_m).max(1.0);
        let mut pieces = vec![Piece::straight(self.learning_m + straight_m)];
        pieces.extend(bend);
        pieces.push(Piece::straight(straight_m + 1.0));
        let turned = |p: Piece| if self.direction == Gear::Reverse { p.reversed() } else { p };
        course(&pieces.into_iter().map(turned).collect::<Vec<_>>(), wheelbase_m)
    }

    pub(crate) fn run(&self, bench: &Bench<'_>, plant: &sim::Settings, seed: u64, record: impl FnMut(&Moment)) -> Result<Values> {
        let (mut before_stage, mut record) = (Stage::Arrived, record);
        let before = self.once(bench, plant, seed, None, &mut before_stage, |_| {})?;
        let mut after_stage = Stage::Arrived;
        let law = match &bench.maps.lateral {
            Some(file) => Some(LateralCompensation::new(CompensationSettings::default(), table(file)?)),
            None => None,
        };
        let after = self.once(bench, plant, seed, law, &mut after_stage, &mut record)?;
        let mut values = Values::default();
        let ended = before_stage == Stage::Arrived && after_stage == Stage::Arrived;
        values.set(Metric::AsExpected, f64::from(u8::from(ended)));
        let (before_m, after_m) = ((before.error_m / before.way_m).abs(), (after.error_m / after.way_m).abs());
        values.set(Metric::LateralBeforeM, before_m);
        values.set(Metric::LateralAfterM, after_m);
        values.set(Metric::LateralRatio, after_m / before_m);
        // on the straights nothing hides an oscillation: the larger ratio counts
        let ratio = |k: usize| {
            let rms = |f: &Figures| (f.rates[k].0 / f.rates[k].1).sqrt();
            rms(&after) / rms(&before)
        };
        values.set(Metric::HeadingRateRatio, ratio(0).max(ratio(1)));
        Ok(values)
    }

    fn once(
        &self,
        bench: &Bench<'_>,
        plant: &sim::Settings,
        seed: u64,
        mut law: Option<LateralCompensation>,
        stage: &mut Stage,
        mut record: impl FnMut(&Moment),
    ) -> Result<Figures> {
        let path = self.path(bench.wheelbase_m);
        let settings = follower_settings(bench.wheelbase_m, self.law);
        let mut driver = LegsDriver::new(&path, settings);
        let mounting = Mounting { yaw_rad: self.yaw_deg * RAD_PER_DEG, steering_zero_rad: self.steering_zero_deg * RAD_PER_DEG };
        let (mut compensation_rad, mut last_s_m) = (0.0, 0.0);
        let controller = |inputs: &Inputs| {
            let used_rad = compensation_rad;
            let command = driver.step(inputs, &bench.torque, used_rad).unwrap_or_else(|| DriveCommand::at_rest(inputs.wheel_angle_rad));
            if let (Some(law), Some(matched)) = (&mut law, &command.matched) {
                let travelled_m = (matched.s_m - last_s_m).max(0.0);
                let tracking = command.stage == Stage::Driving;
                compensation_rad = law.step(self.direction, command.lateral_error_m, travelled_m, matched.curvature_per_m, tracking);
                last_s_m = matched.s_m;
            }
            (command, used_rad, driver.leg())
        };
        let leg = Leg::first(&path.poses);
        let (mut figures, mut index, mut last_m) = (Figures::default(), 0, 0.0);
        *stage = drive(plant, seed, &Start::default(), &mounting, settings.limits.period_s, controller, |moment| {
            record(moment);
            let Some(leg) = leg else { return };
            let state = moment.state;
            let (matched, found) = leg.nearest(state.x_m, state.y_m, index);
            index = found;
            let way_m = (matched.s_m - last_m).max(0.0);
            last_m = matched.s_m;
            if (self.learning_m..self.learning_m + self.measured_m).contains(&matched.s_m) {
                let pose = Pose { x_m: state.x_m, y_m: state.y_m, heading_rad: state.heading_rad };
                let error_m = lateral_error_m(pose, matched.x_m, matched.y_m);
                let rate_rad_s = state.speed_mps * state.wheel_angle_rad.sin() / bench.wheelbase_m;
                figures.error_m += way_m * error_m;
                figures.way_m += way_m;
                let straight = matched.curvature_per_m == 0.0;
                for (squares, count) in &mut figures.rates[..if straight { 2 } else { 1 }] {
                    *squares += rate_rad_s * rate_rad_s;
                    *count += 1.0;
                }
            }
        })?;
        Ok(figures)
    }
}
