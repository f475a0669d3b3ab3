//! The metrics of a pivot, computed while it is driven; the definitions are in `docs/controller.md`.

use crate::control::{Direction, Phase, PivotSettings};
use crate::map::Gear;
use crate::sim;
use crate::sim::TrueState;
use crate::units::RAD_PER_DEG;
use crate::verify::bench::{PivotBench, PivotMoment};
use crate::verify::drive::{Observer, Period};
use crate::verify::metric::{Metric, Values};
use crate::verify::pivot_driver::{AskedTurn, PivotDriver};
use crate::verify::pivot_law::PivotControl;
use crate::verify::scenario::{Expected, Scenario};

/// Observes a run and accumulates its metrics. Over several turns it takes the largest value, and the mean of shares.
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
    /// Whether a look-up was reported: a controller that is a process may keep it to itself.
    looks_up: bool,
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
        Self {
            bench,
            settings,
            wheelbase_m: plant.vehicle.wheelbase_m,
            turn: None,
            to_centre_m: 0.0,
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
            looks_up: false,
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
        let direction = if turn_rad < 0.0 { Direction::Right } else { Direction::Left };
        let (sin, cos) = self.settings.planning.wheel_and_gear(direction).0.sin_cos();
        self.to_centre_m = self.wheelbase_m * cos / sin;
        (self.start, self.turn_rad, self.begun_s) = (*state, turn_rad, state.t_s);
        self.start_direction = state.heading_rad.sin_cos().into();
        self.length_m = self.wheelbase_m * turn_rad.abs() / sin.abs();
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
            // 1e-6: an interpolated table value at its limit may miss it by its rounding
            let torque_nm = command.drive.map_or(command.torque_nm, |drive| drive.torque_nm);
            self.saturated += f64::from(u8::from(torque_nm.abs() >= self.limit_nm - 1e-6));
            if let Some(drive) = command.drive {
                self.looks_up = true;
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
        let to_centre_m = self.to_centre_m;
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
    pub(crate) fn values<C: PivotControl>(mut self, scenario: &Scenario, driver: &PivotDriver<'_, C>, state: &TrueState) -> Values {
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
            // a turn that failed has an error too: the missing angle
            values.set(Metric::HeadingErrorDeg, self.heading_error_rad / RAD_PER_DEG);
            values.set(Metric::OvershootDeg, self.overshoot_rad / RAD_PER_DEG);
        }
        if self.driving_periods > 0.0 {
            values.set(Metric::DriftM, self.drift_m);
            values.set(Metric::SpeedRmsMps, (self.squares / self.driving_periods).sqrt());
            values.set(Metric::SpeedMaxMps, self.largest_mps);
            values.set(Metric::StartJerkMps3, self.start_jerk_mps3);
            values.set(Metric::SaturatedShare, self.saturated / self.driving_periods);
            if self.looks_up {
                values.set(Metric::OutsideShare, self.outside / self.driving_periods);
            }
        }
        values
    }
}

impl<'b, C: PivotControl> Observer<PivotDriver<'b, C>> for PivotMetrics<'_> {
    fn see(&mut self, period: &Period<'_, PivotDriver<'b, C>>) {
        let (asked, state) = (period.driver.turn(), &period.moment.state);
        if let Some(turn) = asked.filter(|_| asked != self.turn) {
            // the previous turn ended where this one begins
            if self.turn.is_some() {
                self.end(state);
            }
            self.turn = asked;
            self.begin(state, turn.turn_rad);
        }
        self.add(period.moment, period.mean_speed_mps);
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::control::{AngleStatus, DriveStep, LateralTask, Outputs};
    use crate::map::{Table2File, Vehicle};
    use crate::sim::{Measurement, PhysicalSettings, WorldSettings};
    use crate::verify::measured_region::Region;
    use crate::verify::reference_maps::known_maps;
    use std::f64::consts::FRAC_PI_2;

    const PERIOD_S: f64 = 0.02;

    fn world() -> WorldSettings {
        let vehicle = Vehicle {
            wheelbase_m: 0.92,
            wheel_radius_m: 0.12,
            test_angle_deg: 90.0,
            torque_limit_nm: Some(44.0),
            torque_full_scale_nm: None,
        };
        WorldSettings::physical(vehicle, PhysicalSettings::default())
    }

    /// Calls `look` with the metrics of a turn by 90° that begins at rest at the origin.
    fn with_metrics(look: impl FnOnce(&mut PivotMetrics<'_>)) {
        let table2: Table2File = known_maps(&world()).unwrap().1;
        let (control, region) = (PivotSettings::new(0.92, FRAC_PI_2), Region::new(&table2));
        let bench = PivotBench {
            control: &control,
            period_s: PERIOD_S,
            torque_limit_nm: 44.0,
            breakaway_nm: 5.0,
            planned_nm: [10.0, 20.0],
            region: &region,
        };
        let mut metrics = PivotMetrics::new(&bench, &control, &world());
        metrics.begin(&TrueState::default(), FRAC_PI_2);
        look(&mut metrics);
    }

    fn moment(phase: Phase, state: TrueState, torque_nm: f64) -> PivotMoment {
        let drive = DriveStep { torque_nm, speed_mps: 0.2, ..DriveStep::default() };
        let command = Outputs {
            torque_nm,
            wheel_angle_rad: FRAC_PI_2,
            gear: Some(Gear::Forward),
            phase,
            direction: None,
            angle: AngleStatus::Reached,
            task: LateralTask::Hold(FRAC_PI_2),
            restore: false,
            drive: (phase == Phase::Driving).then_some(drive),
        };
        PivotMoment { state, seen: Measurement::default(), command }
    }

    #[test]
    fn acceleration_and_jerk_are_differences_of_the_mean_speeds() {
        with_metrics(|metrics| {
            for mean_mps in [0.0, 0.02, 0.02, 0.02] {
                metrics.add(&moment(Phase::Driving, TrueState::default(), 10.0), mean_mps);
            }
            // 0.02 m/s within a period of 0.02 s, and the acceleration gone in the next one
            assert!((metrics.peak_accel_mps2 - 1.0).abs() < 1e-9 && (metrics.peak_jerk_mps3 - 50.0).abs() < 1e-9);
            assert_eq!(metrics.start_jerk_mps3, metrics.peak_jerk_mps3);
            assert!((metrics.arc_m - 0.06 * PERIOD_S).abs() < 1e-12);
        });
    }

    #[test]
    fn a_jerk_later_than_half_a_second_is_none_of_the_start() {
        with_metrics(|metrics| {
            for k in 0..40 {
                metrics.add(&moment(Phase::Driving, TrueState::default(), 10.0), if k < 30 { 0.0 } else { 0.1 });
            }
            assert!(metrics.peak_jerk_mps3 > 200.0 && metrics.start_jerk_mps3 == 0.0);
        });
    }

    #[test]
    fn the_drift_is_the_way_of_the_reference_point_and_torque_at_the_limit_is_saturated() {
        with_metrics(|metrics| {
            let away = TrueState { x_m: 0.03, y_m: -0.04, ..TrueState::default() };
            metrics.add(&moment(Phase::Driving, away, 44.0), 0.0);
            metrics.add(&moment(Phase::Driving, TrueState::default(), 43.0), 0.0);
            assert!((metrics.drift_m - 0.05).abs() < 1e-9);
            assert_eq!((metrics.saturated, metrics.driving_periods), (1.0, 2.0));
        });
    }

    #[test]
    fn a_turn_beyond_its_end_overshoots_and_its_error_is_what_remains() {
        with_metrics(|metrics| {
            let turned = |deg: f64| TrueState { heading_rad: deg * RAD_PER_DEG, t_s: 4.0, ..TrueState::default() };
            metrics.add(&moment(Phase::Driving, turned(92.0), 0.0), 0.0);
            metrics.end(&turned(89.5));
            assert!((metrics.overshoot_rad / RAD_PER_DEG - 2.0).abs() < 1e-9);
            assert!((metrics.heading_error_rad / RAD_PER_DEG - 0.5).abs() < 1e-9 && metrics.time_s == 4.0);
        });
    }

    #[test]
    fn after_a_failure_only_torque_that_drives_counts() {
        with_metrics(|metrics| {
            let failed = Phase::Failed(crate::control::Failure::ObstacleStop);
            metrics.add(&moment(failed, TrueState::default(), -20.0), 0.1);
            assert_eq!(metrics.drive_after_failure_nm, 0.0);
            assert!((metrics.travel_after_failure_m - 0.1 * PERIOD_S).abs() < 1e-12);
        });
    }
}
