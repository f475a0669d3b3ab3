//! The polyline scenario: eight segments with every case of the plan, driven by each tracking law.

use crate::control::{Inputs, Pose};
use crate::guidance::route::follower::{DriveStage, FollowerSettings};
use crate::guidance::route::path_position::{Leg, Offset};
use crate::guidance::route::polyline::{PolylinePlan, PolylinePoint, PolylineSettings};
use crate::guidance::route::polyline_driver::PolylineDriver;
use crate::guidance::route::response::PERIOD_S;
use crate::guidance::route::tracking::{LawName, TrackingSettings};
use crate::guidance::route::turn_law::TurnSettings;
use crate::manoeuvre::Result;
use crate::manoeuvre::bench::ManoeuvreBench;
use crate::manoeuvre::drive::{Commanded, ManoeuvreDriver, ManoeuvreMoment, ManoeuvreObserver, ManoeuvreStart, Mounting, drive_manoeuvre};
use crate::manoeuvre::endings::DriveEnd;
use crate::sim;
use crate::sim::TrueState;
use crate::verify::drive::{Observer, Period};
use crate::verify::{Metric, Values};

/// The corners [m]: a left turn of 90°, a right one, a bend of 3° without a stop, a short segment in reverse (split into halves), and
/// corners sharper than 90°, after which the vehicle drives in reverse.
pub const DEMO_POINTS: [[f64; 2]; 9] =
    [[0.0, 0.0], [6.0, 0.0], [6.0, 4.0], [10.0, 4.0], [14.0, 4.2], [14.0, 2.8], [8.0, 1.0], [3.0, -2.0], [0.0, -2.0]];

/// The corners at the usual speed.
pub fn demo_points() -> Vec<PolylinePoint> {
    DEMO_POINTS.map(PolylinePoint::from).to_vec()
}

/// Set speeds of the segments of [`DEMO_POINTS`] for the scenario with a speed per segment [m/s]: a slow one after a corner, and a joint
/// without a stop at which the speed rises.
pub(crate) const DEMO_SPEEDS_MPS: [Option<f64>; 9] =
    [Some(1.0), Some(0.5), Some(0.4), Some(0.9), None, Some(0.6), Some(0.3), Some(0.7), None];

/// Settings of follower and turn for a vehicle and a law.
fn polyline_settings(bench: &ManoeuvreBench<'_>, law: LawName) -> (FollowerSettings, TurnSettings) {
    let vehicle = &bench.vehicle;
    let mut tracking = TrackingSettings::new(law);
    if let TrackingSettings::Mpc(mpc) = &mut tracking {
        // what a first-order lag covers of its way in a step; two periods pass from a reading to the wheel
        mpc.steering_share = 1.0 - (-mpc.step_s / (vehicle.steering_lag_s + 2.0 * PERIOD_S)).exp();
    }
    (
        FollowerSettings::new(vehicle, tracking).with_loop(&bench.controller.path_tracking),
        TurnSettings::new(vehicle).with_loop(&bench.controller.spot_turn),
    )
}

/// Measurements on one leg.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct LegResult {
    /// Distance from its end while the vehicle rests there: the larger of the values before and after the turn [m].
    corner_error_m: f64,
    /// Largest distance from its line while driving [m].
    segment_error_m: f64,
    /// Integral of the square of that distance over the driven distance, and the driven distance [m].
    squares: f64,
    way_m: f64,
}

/// Observes a polyline and accumulates its metrics.
struct PolylineMetrics<'a> {
    plan: &'a PolylinePlan,
    stop_m: f64,
    legs: Vec<LegResult>,
    index: usize,
    leg: usize,
    last: Option<TrueState>,
    squares: f64,
    largest_mps: f64,
    count: f64,
    end_s: f64,
}

impl<'a> PolylineMetrics<'a> {
    fn new(plan: &'a PolylinePlan, stop_m: f64) -> Self {
        Self {
            plan,
            stop_m,
            legs: vec![LegResult::default(); plan.legs.len()],
            index: 0,
            leg: 0,
            last: None,
            squares: 0.0,
            largest_mps: 0.0,
            count: 0.0,
            end_s: 0.0,
        }
    }

    /// The metrics of a drive that ended in `stage`.
    fn values(&self, stage: DriveStage) -> Values {
        let mut values = Values::default();
        values.set(Metric::AsExpected, f64::from(u8::from(stage == DriveStage::Arrived)));
        values.set(Metric::CornerErrorM, self.legs.iter().fold(0.0, |m, l| l.corner_error_m.max(m)));
        values.set(Metric::SegmentErrorM, self.legs.iter().fold(0.0, |m, l| l.segment_error_m.max(m)));
        let (squares, way) = self.legs.iter().fold((0.0, 0.0), |(s, w), l| (s + l.squares, w + l.way_m));
        values.set(Metric::SegmentRmsM, (squares / way).sqrt());
        values.set(Metric::SpeedRmsMps, (self.squares / self.count).sqrt());
        values.set(Metric::SpeedMaxMps, self.largest_mps);
        if stage == DriveStage::Arrived {
            values.set(Metric::TimeS, self.end_s);
        }
        values
    }

    fn add(&mut self, moment: &ManoeuvreMoment) {
        let state = moment.state;
        let pose = Pose { x_m: state.x_m, y_m: state.y_m, heading_rad: state.heading_rad };
        let moved_m = self.last.map_or(0.0, |l| f64::hypot(state.x_m - l.x_m, state.y_m - l.y_m));
        (self.last, self.end_s) = (Some(state), state.t_s);
        if moment.leg != self.leg || moment.command.stage == DriveStage::Arrived {
            self.corner(pose);
            (self.leg, self.index) = (moment.leg, 0);
        }
        let Some(leg) = self.plan.legs.get(self.leg).and_then(|p| Leg::first(&p.poses)) else { return };
        if !matches!(moment.command.stage, DriveStage::Driving | DriveStage::Stopping) || moment.command.matched.is_none() {
            return;
        }
        let (matched, index) = leg.nearest(pose.x_m, pose.y_m, self.index);
        self.index = index;
        let offset_m = Offset::new(leg.travel_pose(pose), &matched).lateral_m;
        let result = &mut self.legs[self.leg];
        result.segment_error_m = result.segment_error_m.max(offset_m.abs());
        result.squares += moved_m * offset_m * offset_m;
        result.way_m += moved_m;
        if moment.command.stage == DriveStage::Driving {
            let planned = self.plan.speeds[self.leg].speed_at(matched.s_m - leg.start_m(), self.stop_m);
            let error = leg.gear().sign() * state.speed_mps - planned;
            self.squares += error * error;
            self.largest_mps = self.largest_mps.max(error.abs());
            self.count += 1.0;
        }
        // at rest at its start after the turn: position error of the turn
        let at_start = self.legs[self.leg].way_m < 0.05;
        if moment.command.stage == DriveStage::Driving && self.leg > 0 && at_start && moved_m < 1e-9 {
            let start = self.plan.legs[self.leg].poses[0];
            let error_m = f64::hypot(pose.x_m - start.x_m, pose.y_m - start.y_m);
            let before = &mut self.legs[self.leg - 1];
            before.corner_error_m = before.corner_error_m.max(error_m);
        }
    }

    fn corner(&mut self, pose: Pose) {
        if let (Some(end), Some(result)) = (self.plan.legs.get(self.leg).and_then(|l| l.poses.last()), self.legs.get_mut(self.leg)) {
            result.corner_error_m = result.corner_error_m.max(f64::hypot(pose.x_m - end.x_m, pose.y_m - end.y_m));
        }
    }
}

impl<'b> Observer<ManoeuvreDriver<'b>> for PolylineMetrics<'_> {
    fn see(&mut self, period: &Period<'_, ManoeuvreDriver<'b>>) {
        self.add(period.moment);
    }
}

/// Drives a plan that was made with these settings, and computes the metrics.
pub(crate) fn run(
    bench: &ManoeuvreBench<'_>,
    law: LawName,
    (plan, planning): (&PolylinePlan, &PolylineSettings),
    plant: &sim::WorldSettings,
    seed: u64,
    observer: impl ManoeuvreObserver,
) -> Result<(Values, DriveEnd)> {
    let (mut settings, turn) = polyline_settings(bench, law);
    settings.speed = planning.speed;
    let mut driver = PolylineDriver::new(plan, settings, turn);
    let controller = |inputs: &Inputs| {
        let command = driver.step(inputs, &bench.torque, 0.0);
        Commanded { command, compensation_rad: 0.0, leg: driver.leg() }
    };
    let first = plan.legs[0].poses[0];
    let heading_rad = planning.start_heading_rad.unwrap_or(first.heading_rad);
    let pose = Pose { x_m: first.x_m, y_m: first.y_m, heading_rad };
    let start = ManoeuvreStart { pose, wheel_angle_rad: 0.0 };
    let mut observers = (PolylineMetrics::new(plan, settings.stop_m()), observer);
    let end = drive_manoeuvre(plant, seed, &start, &Mounting::default(), settings.limits.period_s, controller, &mut observers)?;
    Ok((observers.0.values(end.stage), end))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::guidance::route::follower::DriveCommand;
    use crate::guidance::route::path_position::Matched;
    use crate::sim::Measurement;

    fn moment(leg: usize, stage: DriveStage, x_m: f64, y_m: f64, speed_mps: f64) -> ManoeuvreMoment {
        let command = DriveCommand { stage, matched: Some(Matched::default()), ..DriveCommand::at_rest(0.0) };
        let state = TrueState { t_s: x_m, x_m, y_m, speed_mps, ..TrueState::default() };
        ManoeuvreMoment { state, seen: Measurement::default(), command, compensation_rad: 0.0, leg }
    }

    #[test]
    fn errors_are_those_of_the_leg_and_the_corner_where_they_are_made() {
        let plan = PolylinePlan::new(&[[0.0, 0.0], [6.0, 0.0], [6.0, 4.0]].map(PolylinePoint::from), &PolylineSettings::default()).unwrap();
        let mut metrics = PolylineMetrics::new(&plan, 0.0);
        let driving = DriveStage::Driving;
        for (x_m, y_m) in [(0.0, 0.0), (1.0, 0.02), (3.0, -0.05)] {
            metrics.add(&moment(0, driving, x_m, y_m, plan.speeds[0].speed_at(x_m, 0.0) + 0.1));
        }
        // a corner cut by 0.3 m is not a lateral error
        metrics.add(&moment(1, DriveStage::Turning, 5.7, 0.0, 0.0));
        metrics.add(&moment(1, driving, 6.04, 2.0, plan.speeds[1].speed_at(2.0, 0.0)));
        metrics.add(&moment(1, DriveStage::Arrived, 6.0, 3.9, 0.0));
        let values = metrics.values(DriveStage::Arrived);
        let get = |metric| values.get(metric).unwrap();
        assert!((get(Metric::CornerErrorM) - 0.3).abs() < 1e-9 && (get(Metric::SegmentErrorM) - 0.05).abs() < 1e-9);
        assert!((get(Metric::SpeedMaxMps) - 0.1).abs() < 1e-9 && get(Metric::SpeedRmsMps) < 0.1);
        assert_eq!(metrics.values(DriveStage::Driving).get(Metric::TimeS), None);
    }
}
