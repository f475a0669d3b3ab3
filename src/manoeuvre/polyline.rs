//! The polyline scenario: eight segments that need every case of the plan, driven by each tracking law.

use crate::control::Pose;
use crate::guidance::route::follower::{FollowerSettings, Stage};
use crate::guidance::route::path_position::{Leg, Offset};
use crate::guidance::route::polyline::{PolylinePlan, PolylineSettings};
use crate::guidance::route::polyline_driver::PolylineDriver;
use crate::guidance::route::tracking::{LawName, TrackingSettings};
use crate::guidance::route::turn_law::TurnSettings;
use crate::manoeuvre::bench::Bench;
use crate::manoeuvre::drive::{Moment, Mounting, Start, drive};
use crate::sim;
use crate::sim::TrueState;
use crate::verify::metric::{Metric, Values};
use crate::verify::{Error, Result};

/// The corners [m]: a left turn of 90°, a right one, a bend of 3° without a stop, a short segment in reverse (half/half), and corners sharper
/// than 90°, which are left in reverse.
pub const DEMO_POINTS: [[f64; 2]; 9] =
    [[0.0, 0.0], [6.0, 0.0], [6.0, 4.0], [10.0, 4.0], [14.0, 4.2], [14.0, 2.8], [8.0, 1.0], [3.0, -2.0], [0.0, -2.0]];

/// Settings of follower and turn for a wheelbase [m] and a law.
pub fn polyline_settings(wheelbase_m: f64, law: LawName) -> (FollowerSettings, TurnSettings) {
    (FollowerSettings::new(wheelbase_m, TrackingSettings::new(law)), TurnSettings::new(wheelbase_m))
}

/// What one leg came to.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct LegResult {
    /// Distance from its end when the vehicle stood there, before or after the turn, the larger one [m].
    pub corner_error_m: f64,
    /// Largest distance from its line while driving [m].
    pub segment_error_m: f64,
    squares: f64,
    way_m: f64,
}

impl LegResult {
    /// Root mean square of the distance from its line, over the way [m].
    pub fn segment_rms_m(&self) -> f64 {
        if self.way_m > 0.0 { (self.squares / self.way_m).sqrt() } else { 0.0 }
    }
}

/// Measures a polyline while it is driven.
struct Watch<'a> {
    plan: &'a PolylinePlan,
    settings: FollowerSettings,
    legs: Vec<LegResult>,
    index: usize,
    leg: usize,
    last: Option<TrueState>,
    squares: f64,
    largest_mps: f64,
    count: f64,
    end_s: f64,
}

impl Watch<'_> {
    fn see(&mut self, moment: &Moment) {
        let state = moment.state;
        let pose = Pose { x_m: state.x_m, y_m: state.y_m, heading_rad: state.heading_rad };
        let moved_m = self.last.map_or(0.0, |l| f64::hypot(state.x_m - l.x_m, state.y_m - l.y_m));
        (self.last, self.end_s) = (Some(state), state.t_s);
        if moment.leg != self.leg || moment.command.stage == Stage::Arrived {
            self.corner(pose);
            (self.leg, self.index) = (moment.leg, 0);
        }
        let Some(leg) = self.plan.legs.get(self.leg).and_then(|p| Leg::first(&p.poses)) else { return };
        if !matches!(moment.command.stage, Stage::Driving | Stage::Stopping) || moment.command.matched.is_none() {
            return;
        }
        let (matched, index) = leg.nearest(pose.x_m, pose.y_m, self.index);
        self.index = index;
        let offset_m = Offset::new(leg.travel_pose(pose), &matched).lateral_m;
        let result = &mut self.legs[self.leg];
        result.segment_error_m = result.segment_error_m.max(offset_m.abs());
        result.squares += moved_m * offset_m * offset_m;
        result.way_m += moved_m;
        if moment.command.stage == Stage::Driving {
            let planned = self.settings.speed.speed_at(matched.s_m - leg.start_m(), leg.end_m() - leg.start_m());
            let error = leg.gear().sign() * state.speed_mps - planned;
            self.squares += error * error;
            self.largest_mps = self.largest_mps.max(error.abs());
            self.count += 1.0;
        }
        // standing at its start after the turn: where did the turn leave it?
        if moment.command.stage == Stage::Driving && self.leg > 0 && moved_m < 1e-9 {
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

/// Drives the points and measures it.
pub(crate) fn run(
    bench: &Bench<'_>,
    law: LawName,
    points_m: &[[f64; 2]],
    plant: &sim::Settings,
    seed: u64,
    mut record: impl FnMut(&Moment),
) -> Result<Values> {
    let plan = PolylinePlan::new(points_m, &PolylineSettings::default()).map_err(Error::Polyline)?;
    let (settings, turn) = polyline_settings(bench.wheelbase_m, law);
    settings.speed.checked()?;
    let mut driver = PolylineDriver::new(&plan, settings, turn);
    let mut watch = Watch {
        plan: &plan,
        settings,
        legs: vec![LegResult::default(); plan.legs.len()],
        index: 0,
        leg: 0,
        last: None,
        squares: 0.0,
        largest_mps: 0.0,
        count: 0.0,
        end_s: 0.0,
    };
    let controller = |inputs: &crate::control::Inputs| {
        let command = driver.step(inputs, &bench.torque, 0.0);
        (command, 0.0, driver.leg())
    };
    let first = plan.legs[0].poses[0];
    let start = Start { pose: Pose { x_m: first.x_m, y_m: first.y_m, heading_rad: first.heading_rad }, wheel_angle_rad: 0.0 };
    let stage = drive(plant, seed, &start, &Mounting::default(), settings.limits.period_s, controller, |moment| {
        watch.see(moment);
        record(moment);
    })?;
    let mut values = Values::default();
    values.set(Metric::AsExpected, f64::from(u8::from(stage == Stage::Arrived)));
    values.set(Metric::CornerErrorM, watch.legs.iter().fold(0.0, |m, l| l.corner_error_m.max(m)));
    values.set(Metric::SegmentErrorM, watch.legs.iter().fold(0.0, |m, l| l.segment_error_m.max(m)));
    let (squares, way) = watch.legs.iter().fold((0.0, 0.0), |(s, w), l| (s + l.squares, w + l.way_m));
    values.set(Metric::SegmentRmsM, (squares / way).sqrt());
    values.set(Metric::SpeedRmsMps, (watch.squares / watch.count).sqrt());
    values.set(Metric::SpeedMaxMps, watch.largest_mps);
    if stage == Stage::Arrived {
        values.set(Metric::TimeS, watch.end_s);
    }
    Ok(values)
}
