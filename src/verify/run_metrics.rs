//! What is measured of a pivot while it is driven; the definitions are in `docs/controller.md`.

use crate::control::{DriveLaw, Phase, PivotSettings};
use crate::map::Gear;
use crate::sim;
use crate::sim::TrueState;
use crate::units::RAD_PER_DEG;
use crate::verify::bench::{PivotBench, PivotMoment};
use crate::verify::drive::{Observer, Period};
use crate::verify::metric::{Metric, Values};
use crate::verify::pivot_driver::{AskedTurn, PivotDriver};
use crate::verify::scenario::{Expected, Scenario};

/// Observes a run and adds up its metrics. Over several turns the largest counts, and the mean of shares.
pub(crate) struct PivotMetrics<'a> {
    bench: &'a PivotBench<'a>,
    settings: &'a PivotSettings,
    wheelbase_m: f64,
    turn: Option<AskedTurn>,
    /// Distance of the reference point from the centre of its circle [m], to the left.
    to_centre_m: f64,
    start: TrueState,
    /// Sine and cosine of the heading there.
    start_direction: [f64; 2],
    turn_rad: f64,
    length_m: f64,
    gear: Gear,
    arc_m: f64,
    heading_error_rad: f64,
    overshoot_rad: f64,
    drift_m: f64,
    squares: f64,
    largest_mps: f64,
    driving_periods: f64,
    saturated: f64,
    outside: f64,
    limit_nm: f64,
    peak_accel_mps2: f64,
    peak_jerk_mps3: f64,
    start_jerk_mps3: f64,
    means_mps: [f64; 2],
    since_drive_s: Option<f64>,
    standing_since_s: f64,
    settling_s: f64,
    begun_s: f64,
    time_s: f64,
    failed: bool,
    drive_after_failure_nm: f64,
    travel_after_failure_m: f64,
}

impl<'a> PivotMetrics<'a> {
    pub(crate) fn new(bench: &'a PivotBench<'a>, settings: &'a PivotSettings, plant: &sim::WorldSettings) -> Self {
        let (sin, cos) = settings.planning.test_angle_rad.sin_cos();
        Self {
            bench,
            settings,
            wheelbase_m: plant.vehicle.wheelbase_m,
            turn: None,
            to_centre_m: plant.vehicle.wheelbase_m * cos / sin,
            start: TrueState::default(),
            start_direction: [0.0, 1.0],
            turn_rad: 0.0,
            length_m: 0.0,
            gear: Gear::Forward,
            arc_m: 0.0,
            heading_error_rad: 0.0,
            overshoot_rad: 0.0,
            drift_m: 0.0,
            squares: 0.0,
            largest_mps: 0.0,
            driving_periods: 0.0,
            saturated: 0.0,
            outside: 0.0,
            limit_nm: bench.torque_limit_nm.min(plant.drive.torque_limit_nm),
            peak_accel_mps2: 0.0,
            peak_jerk_mps3: 0.0,
            start_jerk_mps3: 0.0,
            means_mps: [0.0; 2],
            since_drive_s: None,
            standing_since_s: 0.0,
            settling_s: 0.0,
            begun_s: 0.0,
            time_s: 0.0,
            failed: false,
            drive_after_failure_nm: 0.0,
            travel_after_failure_m: 0.0,
        }
    }

    /// A turn of `turn_rad` begins.
    fn begin(&mut self, state: &TrueState, turn_rad: f64) {
        let sin = (self.settings.planning.test_angle_rad).sin().abs();
        (self.start, self.turn_rad, self.begun_s) = (*state, turn_rad, state.t_s);
        self.start_direction = state.heading_rad.sin_cos().into();
        self.length_m = self.wheelbase_m * turn_rad.abs() / sin;
        self.arc_m = 0.0;
        self.since_drive_s = None;
        self.means_mps = [state.speed_mps; 2];
    }

    /// One period. `mean_mps`: mean of the true speed over the period that `moment` began.
    fn add(&mut self, moment: &PivotMoment, mean_mps: f64) {
        let (state, command, period_s) = (&moment.state, &moment.command, self.bench.period_s);
        if let Some(gear) = command.gear {
            self.gear = gear;
        }
        let sign = self.gear.sign();
        let accel = (mean_mps - self.means_mps[1]) / period_s;
        let jerk = (mean_mps - 2.0 * self.means_mps[1] + self.means_mps[0]) / (period_s * period_s);
        self.means_mps = [self.means_mps[1], mean_mps];
        self.peak_accel_mps2 = self.peak_accel_mps2.max(accel.abs());
        self.peak_jerk_mps3 = self.peak_jerk_mps3.max(jerk.abs());
        if command.phase == Phase::Driving {
            let since_s = self.since_drive_s.map_or(0.0, |s| s + period_s);
            self.since_drive_s = Some(since_s);
            if since_s <= 0.5 {
                self.start_jerk_mps3 = self.start_jerk_mps3.max(jerk.abs());
            }
            let error_mps = sign * state.speed_mps - self.settings.planning.profile.speed_at(self.arc_m, self.length_m);
            self.squares += error_mps * error_mps;
            self.largest_mps = self.largest_mps.max(error_mps.abs());
            self.driving_periods += 1.0;
            if let Some(drive) = command.drive {
                // 1e-6: an interpolated table value at its limit may miss it by its rounding
                self.saturated += f64::from(u8::from(drive.torque_nm.abs() >= self.limit_nm - 1e-6));
                self.outside += f64::from(u8::from(!self.bench.region.contains(self.gear, drive.speed_mps, drive.accel_mps2)));
            }
            self.drift_m = self.drift_m.max(self.drift(state));
        } else if let Some(since_s) = self.since_drive_s.as_mut() {
            *since_s += period_s;
        }
        if mean_mps.abs() > 1e-3 {
            self.standing_since_s = self.since_drive_s.unwrap_or(0.0);
        }
        let turned_rad = (state.heading_rad - self.start.heading_rad) * self.turn_rad.signum();
        if command.phase.is_active() || matches!(command.phase, Phase::Succeeded) {
            self.overshoot_rad = self.overshoot_rad.max(turned_rad - self.turn_rad.abs());
        }
        if matches!(command.phase, Phase::Failed(_)) {
            self.drive_after_failure_nm = self.drive_after_failure_nm.max(sign * command.torque_nm);
            self.travel_after_failure_m += mean_mps.abs() * period_s;
        }
        self.arc_m += sign * mean_mps * period_s;
    }

    /// Distance of the reference point from its place on the circle that it should follow [m].
    fn drift(&self, state: &TrueState) -> f64 {
        let mirrored = self.gear == Gear::Forward && self.turn_rad < 0.0;
        let to_centre_m = self.to_centre_m * if mirrored { -1.0 } else { 1.0 };
        let centre = |s: &TrueState, [sin, cos]: [f64; 2]| (s.x_m - sin * to_centre_m, s.y_m + cos * to_centre_m);
        let (sin, cos) = state.heading_rad.sin_cos();
        let ((x0, y0), (x, y)) = (centre(&self.start, self.start_direction), centre(state, [sin, cos]));
        f64::hypot(x - x0, y - y0)
    }

    /// The turn has ended.
    fn end(&mut self, state: &TrueState) {
        let turned_rad = state.heading_rad - self.start.heading_rad;
        self.heading_error_rad = self.heading_error_rad.max((turned_rad - self.turn_rad).abs());
        self.settling_s = self.settling_s.max(self.standing_since_s);
        self.time_s += state.t_s - self.begun_s;
    }

    /// The metrics of the run, which ended at `state` with its last turn.
    pub(crate) fn values<L: DriveLaw>(mut self, scenario: &Scenario, driver: &PivotDriver<'_, L>, state: &TrueState) -> Values {
        if self.turn.is_some() {
            self.end(state);
        }
        self.failed = driver.failed();
        let mut values = Values::default();
        values.set(Metric::AsExpected, f64::from(u8::from(driver.as_expected())));
        values.set(Metric::PeakAccelMps2, self.peak_accel_mps2);
        values.set(Metric::PeakJerkMps3, self.peak_jerk_mps3);
        if self.failed {
            values.set(Metric::DriveAfterFailureNm, self.drive_after_failure_nm);
            values.set(Metric::TravelAfterFailureM, self.travel_after_failure_m);
        } else {
            values.set(Metric::TimeS, self.time_s);
            values.set(Metric::SettlingTimeS, self.settling_s);
        }
        if scenario.expected == Expected::Success {
            // a turn that failed has an error too: what is missing
            values.set(Metric::HeadingErrorDeg, self.heading_error_rad / RAD_PER_DEG);
            values.set(Metric::OvershootDeg, self.overshoot_rad / RAD_PER_DEG);
        }
        if self.driving_periods > 0.0 {
            values.set(Metric::DriftM, self.drift_m);
            values.set(Metric::SpeedRmsMps, (self.squares / self.driving_periods).sqrt());
            values.set(Metric::SpeedMaxMps, self.largest_mps);
            values.set(Metric::StartJerkMps3, self.start_jerk_mps3);
            values.set(Metric::SaturatedShare, self.saturated / self.driving_periods);
            values.set(Metric::OutsideShare, self.outside / self.driving_periods);
        }
        values
    }
}

impl<'b, L: DriveLaw> Observer<PivotDriver<'b, L>> for PivotMetrics<'_> {
    fn see(&mut self, period: &Period<'_, PivotDriver<'b, L>>) {
        let (asked, state) = (period.driver.turn(), &period.moment.state);
        if let Some(turn) = asked.filter(|_| asked != self.turn) {
            // the turn before ended where this one begins
            if self.turn.is_some() {
                self.end(state);
            }
            self.turn = asked;
            self.begin(state, turn.turn_rad);
        }
        self.add(period.moment, period.mean_speed_mps);
    }
}
