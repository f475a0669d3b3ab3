//! The closed loop: read, command, let the world go on, once a control period.
//!
//! In: a [`World`], a [`Driver`] that commands it, and an [`Observer`] that sees every period. Metrics, traces and logs are observers, so that
//! one drive yields all of them.

use crate::control::{Inputs, Pose};
use crate::sim::{Measurement, World, WorldCommand};
use crate::verify::Result;

/// What commands the world. `Moment` is one control period: what was true, what was read, what was commanded.
pub(crate) trait Driver {
    /// One control period.
    type Moment;

    /// Prepares the next period: a task begins, a disturbance sets in. `false` ends the drive.
    ///
    /// # Errors
    /// A task that cannot be driven.
    fn prepare(&mut self, world: &mut World) -> Result<bool>;

    /// Reads the world and decides what to command for one period.
    fn command(&mut self, world: &World) -> (Self::Moment, WorldCommand);
}

/// What is seen of a period after it.
pub(crate) struct Period<'a, D: Driver> {
    /// The driver, as its command left it.
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
}

/// Nobody looks.
impl<D: Driver> Observer<D> for () {
    fn see(&mut self, _: &Period<'_, D>) {}
}

impl<D: Driver, A: Observer<D>, B: Observer<D>> Observer<D> for (A, B) {
    fn see(&mut self, period: &Period<'_, D>) {
        self.0.see(period);
        self.1.see(period);
    }
}

impl<D: Driver, O: Observer<D>> Observer<D> for Option<O> {
    fn see(&mut self, period: &Period<'_, D>) {
        if let Some(observer) = self {
            observer.see(period);
        }
    }
}

impl<D: Driver, O: Observer<D>> Observer<D> for &mut O {
    fn see(&mut self, period: &Period<'_, D>) {
        (**self).see(period);
    }
}

/// Keeps or passes on every moment.
pub(crate) struct EachMoment<F>(pub(crate) F);

impl<D: Driver, F: FnMut(&D::Moment)> Observer<D> for EachMoment<F> {
    fn see(&mut self, period: &Period<'_, D>) {
        (self.0)(period.moment);
    }
}

/// Drives until the driver ends it. A period is `steps` steps of the world, at least one.
///
/// # Errors
/// What the driver refuses.
pub(crate) fn drive<D: Driver>(world: &mut World, steps: usize, driver: &mut D, observer: &mut impl Observer<D>) -> Result<()> {
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

/// What a controller sees of a measurement.
pub(crate) fn inputs(seen: &Measurement) -> Inputs {
    Inputs { speed_mps: seen.speed_mps, wheel_angle_rad: seen.wheel_angle_rad, pose: pose(seen), gear: seen.gear, estop: seen.estop }
}

/// The pose as it was measured.
pub(crate) fn pose(seen: &Measurement) -> Pose {
    Pose { x_m: seen.x_m, y_m: seen.y_m, heading_rad: seen.heading_rad }
}
