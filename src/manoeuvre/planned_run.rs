//! Parking and the U-turn in closed loop: the planned path is driven leg by leg, and the body's true clearance is measured.

use crate::control::{Inputs, Pose};
use crate::guidance::look_ahead::largest_steps;
use crate::guidance::route::follower::{DriveStage, FollowerSettings};
use crate::guidance::route::path_position::{Leg, Offset};
use crate::guidance::route::rear_axle::RearAxle;
use crate::guidance::route::response::VehicleResponse;
use crate::guidance::route::segment_speed::SegmentSpeed;
use crate::guidance::route::tracking::TrackingSettings;
use crate::manoeuvre::Result;
use crate::manoeuvre::bench::ManoeuvreBench;
use crate::manoeuvre::drive::{Commanded, ManoeuvreDriver, ManoeuvreObserver, ManoeuvreStart, Mounting, drive_manoeuvre};
use crate::manoeuvre::endings::DriveEnd;
use crate::manoeuvre::legs_driver::LegsDriver;
use crate::manoeuvre::planned_task::Planned;
use crate::sim;
use crate::sim::TrueState;
use crate::units::RAD_PER_DEG;
use crate::verify::drive::{Observer, Period};
use crate::verify::{Metric, Values};
use std::f64::consts::PI;

fn follower_settings(planned: &Planned, vehicle: &VehicleResponse) -> FollowerSettings {
    // feedback over about a turning radius: it returns to the path within a metre
    let law = RearAxle { offset_gain_per_m2: 4.0, heading_gain_per_m: 4.0 };
    let mut settings = FollowerSettings::new(vehicle, TrackingSettings::RearAxle(law));
    let cruise_mps = planned.cruise_mps.min(steerable_mps(planned, vehicle)).max(0.1);
    settings.speed =
        SegmentSpeed { start_mps: cruise_mps.min(0.15), accelerating_m: 0.4, cruise_mps, decelerating_m: 0.6, switch_mps: 0.1 };
    settings
}

/// Largest speed at which the steering follows every change of the wheel angle along the path [m/s].
fn steerable_mps(planned: &Planned, vehicle: &VehicleResponse) -> f64 {
    let steepest_per_m = planned.path.poses.windows(2).map(|pair| {
        let moved_m = pair[1].s_m - pair[0].s_m;
        if moved_m > 1e-6 { (pair[1].wheel_angle_rad - pair[0].wheel_angle_rad).abs() / moved_m } else { 0.0 }
    });
    // 1e-6: a steering of exactly the rate that is needed suffices
    vehicle.steering_rate_rad_s * (1.0 + 1e-6) / steepest_per_m.fold(1e-9, f64::max)
}

/// Observes a planned manoeuvre and accumulates its metrics.
struct PlannedMetrics<'a> {
    planned: &'a Planned,
    clearance_m: f64,
    largest_m: f64,
    squares: f64,
    way_m: f64,
    /// Index of the first pose of the leg, its number, and the vehicle's last piece of it.
    leg_from: usize,
    leg: usize,
    index: usize,
    last: Option<TrueState>,
}

impl<'a> PlannedMetrics<'a> {
    fn new(planned: &'a Planned) -> Self {
        let clearance_m = f64::INFINITY;
        Self { planned, clearance_m, largest_m: 0.0, squares: 0.0, way_m: 0.0, leg_from: 0, leg: 0, index: 0, last: None }
    }

    /// The metrics of a drive that ended in `stage`.
    fn values(&self, stage: DriveStage) -> Values {
        let mut values = Values::default();
        values.set(Metric::AsExpected, f64::from(u8::from(stage == DriveStage::Arrived)));
        if let (Some(end), Some(goal)) = (self.last, self.planned.path.poses.last()) {
            let off = (end.heading_rad - goal.heading_rad + PI).rem_euclid(2.0 * PI) - PI;
            values.set(Metric::FinalPositionM, (end.x_m - goal.x_m).hypot(end.y_m - goal.y_m));
            values.set(Metric::HeadingErrorDeg, off.abs() / RAD_PER_DEG);
            values.set(Metric::TimeS, end.t_s);
        }
        values.set(Metric::SegmentErrorM, self.largest_m);
        values.set(Metric::SegmentRmsM, (self.squares / self.way_m).sqrt());
        values.set(Metric::ClearanceM, self.clearance_m);
        values.set(Metric::ClearanceLossM, (self.planned.clearance_m - self.clearance_m).max(0.0));
        values.set(Metric::CurvatureStepPerM, largest_steps(&self.planned.path).1);
        values
    }
}

impl<'b> Observer<ManoeuvreDriver<'b>> for PlannedMetrics<'_> {
    fn see(&mut self, period: &Period<'_, ManoeuvreDriver<'b>>) {
        let (state, poses) = (period.moment.state, &self.planned.path.poses);
        self.clearance_m = self.clearance_m.min(self.planned.clearance_at_m(state.x_m, state.y_m, state.heading_rad));
        if period.moment.leg != self.leg {
            self.leg_from += Leg::first(&poses[self.leg_from..]).map_or(0, |l| l.last_index());
            (self.leg, self.index) = (period.moment.leg, 0);
        }
        if let Some(leg) = Leg::first(&poses[self.leg_from..]) {
            let pose = Pose { x_m: state.x_m, y_m: state.y_m, heading_rad: state.heading_rad };
            let (matched, found) = leg.nearest(pose.x_m, pose.y_m, self.index);
            self.index = found;
            let lateral_m = Offset::new(leg.travel_pose(pose), &matched).lateral_m;
            let moved_m = self.last.map_or(0.0, |e| (state.x_m - e.x_m).hypot(state.y_m - e.y_m));
            self.largest_m = self.largest_m.max(lateral_m.abs());
            self.squares += moved_m * lateral_m * lateral_m;
            self.way_m += moved_m;
        }
        self.last = Some(state);
    }
}

/// Drives a plan and computes its metrics.
pub(crate) fn run(
    bench: &ManoeuvreBench<'_>,
    planned: &Planned,
    plant: &sim::WorldSettings,
    seed: u64,
    observer: impl ManoeuvreObserver,
) -> Result<(Values, DriveEnd)> {
    let settings = follower_settings(planned, &bench.vehicle).with_loop(&bench.controller.path_tracking);
    let first = planned.path.poses[0];
    let pose = Pose { x_m: first.x_m, y_m: first.y_m, heading_rad: first.heading_rad };
    let start = ManoeuvreStart { pose, wheel_angle_rad: first.wheel_angle_rad };
    let mut driver = LegsDriver::new(&planned.path, settings);
    let controller = |inputs: &Inputs| {
        let leg = driver.leg();
        let mut command = driver.step(inputs, &bench.torque, 0.0);
        if driver.leg() != leg {
            // the wheel turns at once to the angle of the next leg
            command.stage = DriveStage::Steering;
        }
        Commanded { command, compensation_rad: 0.0, leg: driver.leg() }
    };
    let mut observers = (PlannedMetrics::new(planned), observer);
    let end = drive_manoeuvre(plant, seed, &start, &Mounting::default(), settings.limits.period_s, controller, &mut observers)?;
    Ok((observers.0.values(end.stage), end))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::manoeuvre::{Manoeuvre, ManoeuvreKind, ManoeuvreSettings, replay_manoeuvre};
    use crate::verify::Maps;
    use crate::verify::reference_maps::known_maps;

    #[test]
    fn every_planned_manoeuvre_ends_where_it_should_and_touches_nothing() {
        let settings = ManoeuvreSettings::new().unwrap();
        let (table1, table2) = known_maps(&settings.vehicle).unwrap();
        let maps = Maps::new(table1, table2).unwrap();
        for manoeuvre in Manoeuvre::all().into_iter().filter(|m| matches!(m.kind, ManoeuvreKind::Planned(_))) {
            let mut legs = 0;
            let values = replay_manoeuvre(&maps, &settings, &manoeuvre, |moment| legs = legs.max(moment.leg)).unwrap();
            let figures: Vec<_> = Metric::ALL.into_iter().filter_map(|m| values.get(m).map(|v| format!("{}: {v:.4}", m.title()))).collect();
            let (parking, get) = (manoeuvre.name.starts_with("parking"), |m| values.get(m).unwrap());
            assert_eq!(get(Metric::AsExpected), 1.0, "{}", manoeuvre.name);
            assert!(get(Metric::FinalPositionM) < 0.05 && get(Metric::HeadingErrorDeg) < 1.0, "{}: {figures:?}", manoeuvre.name);
            assert!(get(Metric::ClearanceM) > if parking { 0.05 } else { 0.2 }, "{}: {figures:?}", manoeuvre.name);
            match manoeuvre.name.as_str() {
                "parking-shuffle" => assert!(legs > 1, "{}: {legs} changes of direction", manoeuvre.name),
                name => assert_eq!(legs, usize::from(parking && name != "parking-nose-in"), "parking drives up and backs in"),
            }
        }
    }
}
