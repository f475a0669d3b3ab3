//! The closed loop: read, command, step the world, once per control period.
//!
//! In: a [`World`], a [`Driver`] that commands it, and an [`Observer`] that sees every period. Metrics, traces and logs are observers, so that
//! one drive yields all of them.

use crate::control::{Inputs, Pose};
use crate::sim::{Measurement, World, WorldCommand};
use crate::verify::Result;

/// Commands the world. `Moment` is one control period: true state, readings, command.
pub(crate) trait Driver {
    /// One control period.
    type Moment;

    /// Prepares the next period: a task begins, a disturbance sets in. `false` ends the drive.
    ///
    /// # Errors
    /// The task cannot be driven.
    fn prepare(&mut self, world: &mut World) -> Result<bool>;

    /// Reads the world and decides what to command for one period.
    fn command(&mut self, world: &World) -> (Self::Moment, WorldCommand);
}

/// The record of a period after its end.
pub(crate) struct Period<'a, D: Driver> {
    /// The driver after its command.
    pub(crate) driver: &'a D,
    /// Truth, readings and command at the start of the period.
    pub(crate) moment: &'a D::Moment,
    /// Mean of the true front-wheel speed over the period [m/s].
    pub(crate) mean_speed_mps: f64,
}

/// Sees every period of a drive.
pub(crate) trait Observer<D: Driver> {
    /// One period has passed.
    fn see(&mut self, period: &Period<'_, D>);

    /// Whether it reads the measured yaw rate, which no controller does. The gyro is simulated only then.
    fn reads_yaw_rate(&self) -> bool {
        false
    }
}

/// Records nothing.
impl<D: Driver> Observer<D> for () {
    fn see(&mut self, _: &Period<'_, D>) {}
}

impl<D: Driver, A: Observer<D>, B: Observer<D>> Observer<D> for (A, B) {
    fn see(&mut self, period: &Period<'_, D>) {
        self.0.see(period);
        self.1.see(period);
    }

    fn reads_yaw_rate(&self) -> bool {
        self.0.reads_yaw_rate() || self.1.reads_yaw_rate()
    }
}

impl<D: Driver, O: Observer<D>> Observer<D> for Option<O> {
    fn see(&mut self, period: &Period<'_, D>) {
        if let Some(observer) = self {
            observer.see(period);
        }
    }

    fn reads_yaw_rate(&self) -> bool {
        self.as_ref().is_some_and(Observer::reads_yaw_rate)
    }
}

impl<D: Driver, O: Observer<D>> Observer<D> for &mut O {
    fn see(&mut self, period: &Period<'_, D>) {
        (**self).see(period);
    }

    fn reads_yaw_rate(&self) -> bool {
        (**self).reads_yaw_rate()
    }
}

/// Keeps or passes on every moment.
pub(crate) struct EachMoment<F>(pub(crate) F);

impl<D: Driver, F: FnMut(&D::Moment)> Observer<D> for EachMoment<F> {
    fn see(&mut self, period: &Period<'_, D>) {
        (self.0)(period.moment);
    }

    fn reads_yaw_rate(&self) -> bool {
        true
    }
}

/// Drives until the driver ends it. A period is `steps` steps of the world, at least one.
///
/// # Errors
/// Any error of the driver.
pub(crate) fn drive<D: Driver>(world: &mut World, steps: usize, driver: &mut D, observer: &mut impl Observer<D>) -> Result<()> {
    world.leave_out_unread_sensors(observer.reads_yaw_rate());
    while driver.prepare(world)? {
        let (moment, order) = driver.command(world);
        let mut sum_mps = 0.0;
        for _ in 0..steps {
            world.step(&order);
            sum_mps += world.state().speed_mps;
        }
        observer.see(&Period { driver, moment: &moment, mean_speed_mps: sum_mps / steps as f64 });
    }
    Ok(())
}

/// Steps of the world in a control period.
pub(crate) fn steps_of(period_s: f64, step_s: f64) -> usize {
    (period_s / step_s).round().max(1.0) as usize
}

/// The part of a measurement that a controller reads.
pub(crate) fn inputs(seen: &Measurement) -> Inputs {
    Inputs { speed_mps: seen.speed_mps, wheel_angle_rad: seen.wheel_angle_rad, pose: pose(seen), gear: seen.gear, estop: seen.estop }
}

/// The measured pose.
pub(crate) fn pose(seen: &Measurement) -> Pose {
    Pose { x_m: seen.x_m, y_m: seen.y_m, heading_rad: seen.heading_rad }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::map::{Gear, Vehicle};
    use crate::sim::{PhysicalSettings, WorldSettings};

    /// Commands a torque for a number of periods.
    struct Counted {
        left: usize,
        torque_nm: f64,
    }

    impl Driver for Counted {
        type Moment = f64;

        fn prepare(&mut self, _: &mut World) -> Result<bool> {
            self.left = self.left.wrapping_sub(1);
            Ok(self.left != usize::MAX)
        }

        fn command(&mut self, world: &World) -> (f64, WorldCommand) {
            (world.state().t_s, WorldCommand { torque_nm: self.torque_nm, wheel_angle_rad: 0.0, gear: Some(Gear::Forward) })
        }
    }

    /// Keeps the periods left and the mean speeds.
    #[derive(Default)]
    struct Kept(Vec<(usize, f64)>);

    impl Observer<Counted> for Kept {
        fn see(&mut self, period: &Period<'_, Counted>) {
            self.0.push((period.driver.left, period.mean_speed_mps));
        }
    }

    fn world() -> World {
        let vehicle =
            Vehicle { wheelbase_m: 0.9, wheel_radius_m: 0.12, test_angle_deg: 90.0, torque_limit_nm: None, torque_full_scale_nm: None };
        World::new(&WorldSettings::physical(vehicle, PhysicalSettings::default()), 1).unwrap()
    }

    #[test]
    fn every_observer_sees_every_period_after_it_with_its_mean_speed() {
        let (mut kept, mut starts_s) = (Kept::default(), Vec::new());
        let mut driver = Counted { left: 30, torque_nm: 30.0 };
        let mut world = world();
        drive(&mut world, 20, &mut driver, &mut (Some(&mut kept), EachMoment(|t_s: &f64| starts_s.push(*t_s)))).unwrap();
        assert_eq!((kept.0.len(), kept.0[0].0, starts_s.len()), (30, 29, 30));
        assert!((starts_s[29] - 0.58).abs() < 1e-9 && (world.state().t_s - 0.6).abs() < 1e-9, "{starts_s:?}");
        let (mean_mps, end_mps) = (kept.0[29].1, world.state().speed_mps);
        // under constant torque the mean is below the final speed, by half of the speed change in the period
        let half_mps = 0.5 * 0.02 * world.state().accel_mps2;
        assert!(end_mps > 0.1 && (end_mps - mean_mps - half_mps).abs() < 0.1 * half_mps, "{mean_mps} {end_mps} {half_mps}");
    }

    #[test]
    fn the_gyro_is_simulated_for_those_who_read_it_and_changes_no_other_reading() {
        let seen = |observer: &mut dyn FnMut(&mut World)| {
            let mut world = world();
            observer(&mut world);
            world.measure()
        };
        let without = seen(&mut |world| drive(world, 20, &mut Counted { left: 50, torque_nm: 30.0 }, &mut ()).unwrap());
        let with = seen(&mut |world| drive(world, 20, &mut Counted { left: 50, torque_nm: 30.0 }, &mut EachMoment(|_: &f64| ())).unwrap());
        assert_eq!(without.yaw_rate_rad_s, 0.0);
        assert_ne!(with.yaw_rate_rad_s, 0.0);
        assert_eq!(Measurement { yaw_rate_rad_s: 0.0, ..with }, without);
    }

    #[test]
    fn a_period_is_a_whole_number_of_steps_and_at_least_one() {
        assert_eq!((steps_of(0.02, 0.001), steps_of(0.02, 0.0013), steps_of(0.0001, 0.001)), (20, 15, 1));
    }
}
