//! The identified plant: the fitted surface of a Table 1 with the disturbance and the run-to-run offset of its fit. With it a map can be
//! verified on a vehicle whose physics is not known.
//!
//! `v̇ = A(v, τ) + b + d(t)` in forward motion. In reverse the same equation holds in the reverse table's frame, or in the mirrored frame
//! of the forward table if reverse was not tested. A wheel at rest stays at rest until the engaged gear's torque exceeds the breakaway
//! torque: braking never pushes a wheel backwards. The surface was measured at one wheel angle and is used for every angle. Beyond its
//! torques it is extrapolated linearly; beyond its speeds the last column is used. A step solves the cell's linear equation exactly;
//! crossing a cell's edge inside a step has an error of O(h²).

use crate::map::{AccelTable, Gear, LimitKind, Table1File, Vehicle};
use crate::sim::error::{Error, Result, within};
use crate::sim::load::Load;
use crate::sim::pose::SpeedStep;
use crate::sim::random::{Random, RandomDisturbance, Stream};
use crate::sim::surface::{Cell, Surface};

/// The surface of one direction of travel, in its gear's frame.
#[derive(Debug, Clone, PartialEq)]
pub struct GearSurface {
    /// a(v, τ).
    pub table: AccelTable,
    /// Breakaway torque: it sets a resting wheel in motion [N·m].
    pub breakaway_nm: f64,
}

/// Settings of the identified plant.
#[derive(Debug, Clone, PartialEq)]
pub struct IdentifiedSettings {
    /// The forward surface.
    pub forward: GearSurface,
    /// The reverse surface, if reverse was tested.
    pub reverse: Option<GearSurface>,
    /// Largest driving torque times speed that the drive delivers [N·m·m/s]; infinite without such a limit.
    pub power_limit_nm_mps: f64,
    /// Standard deviation of the disturbance, an Ornstein-Uhlenbeck process while moving [m/s²].
    pub disturbance_mps2: f64,
    /// Its time constant [s].
    pub disturbance_time_s: f64,
    /// Standard deviation of the constant acceleration offset per run [m/s²].
    pub run_offset_mps2: f64,
    /// Share of the effective mass on which a slope acts along the wheel, 0 to 1. Default 0.5.
    pub slope_share: f64,
    /// Inertia of wheel and motor as mass at the rim [kg], for slip only. Default 8.
    pub wheel_mass_kg: f64,
}

impl IdentifiedSettings {
    /// The plant of a fit.
    ///
    /// # Errors
    /// There is no forward map at the vehicle's test angle, or a table is not valid.
    pub fn from_table1(file: &Table1File) -> Result<Self> {
        let direction = |gear| -> Result<Option<GearSurface>> {
            let Some(map) = file.map_at_test_angle(gear) else { return Ok(None) };
            Ok(Some(GearSurface { table: map.surface.table()?, breakaway_nm: map.breakaway.torque_nm }))
        };
        Ok(Self {
            forward: direction(Gear::Forward)?.ok_or(Error::NoForwardMap { wheel_angle_deg: file.vehicle.test_angle_deg })?,
            reverse: direction(Gear::Reverse)?,
            power_limit_nm_mps: power_limit(file),
            disturbance_mps2: file.noise.disturbance_mps2,
            disturbance_time_s: file.noise.disturbance_time_s,
            run_offset_mps2: file.noise.run_offset_mps2,
            slope_share: 0.5,
            wheel_mass_kg: 8.0,
        })
    }

    /// Largest torque of the surfaces [N·m].
    pub fn largest_torque_nm(&self) -> f64 {
        let largest = |d: &GearSurface| d.table.torque_nm().last().max(-d.table.torque_nm().first());
        self.reverse.as_ref().map_or(0.0, largest).max(largest(&self.forward))
    }

    fn check(&self) -> Result<()> {
        for direction in std::iter::once(&self.forward).chain(&self.reverse) {
            within("breakaway.torque_nm", direction.breakaway_nm, 0.0..=1e5, "0 to 1e5")?;
        }
        within("noise.disturbance_mps2", self.disturbance_mps2, 0.0..=100.0, "0 to 100")?;
        within("noise.disturbance_time_s", self.disturbance_time_s, 0.0..=1e6, "0 to 1e6")?;
        within("noise.run_offset_mps2", self.run_offset_mps2, 0.0..=100.0, "0 to 100")?;
        within("slope_share", self.slope_share, 0.0..=1.0, "0 to 1")?;
        within("wheel_mass_kg", self.wheel_mass_kg, 1e-3..=1e5, "0.001 to 1e5")
    }
}

impl GearSurface {
    /// `a' = A(v, τ − (φ − 1)·τ_f(v))/f`: the same plant with its inertia multiplied by f and its friction by φ. `τ_f(v)` is the torque
    /// that holds the speed. Computed on the surface's own grid.
    #[must_use]
    pub fn perturbed(&self, inertia_factor: f64, friction_factor: f64) -> Self {
        let (speed, torque) = (self.table.speed_mps(), self.table.torque_nm());
        let surface = Surface::new(&self.table);
        let mut values = Vec::with_capacity(speed.len() * torque.len());
        let shifts_nm: Vec<f64> = (0..speed.len()).map(|j| (friction_factor - 1.0) * self.holding_nm(j)).collect();
        let mut cell = Cell::default();
        for &u in torque.breaks() {
            for (&v, shift_nm) in speed.breaks().iter().zip(&shifts_nm) {
                values.push(surface.accel(&mut cell, v, u - shift_nm) / inertia_factor);
            }
        }
        // same axes, and finite values divided by finite factors: the table is refused only if a factor is zero or not finite
        let table = AccelTable::new(speed.clone(), torque.clone(), values).unwrap_or_else(|_| self.table.clone());
        Self { table, breakaway_nm: self.breakaway_nm * friction_factor }
    }

    /// Torque [N·m] at which the surface crosses zero at speed break `j`; the nearest end if there is no crossing.
    fn holding_nm(&self, j: usize) -> f64 {
        let breaks = self.table.torque_nm().breaks();
        let a = |i: usize| self.table.at(j, i);
        match (1..breaks.len()).find(|&i| a(i - 1) < 0.0 && a(i) >= 0.0) {
            Some(i) => breaks[i - 1] + (breaks[i] - breaks[i - 1]) * (-a(i - 1) / (a(i) - a(i - 1))),
            None if a(0) >= 0.0 => 0.0,
            None => breaks[breaks.len() - 1],
        }
    }
}

/// (eˣ − 1)/x for small x: the mean of an exponential over a step.
#[inline]
fn mean_growth(x: f64) -> f64 {
    1.0 + x * (0.5 + x * (1.0 / 6.0 + x * (1.0 / 24.0)))
}

#[derive(Debug, Clone)]
struct GearMotion {
    surface: Surface,
    breakaway_nm: f64,
}

/// The identified plant's state.
#[derive(Debug, Clone)]
pub(crate) struct IdentifiedMotion {
    forward: GearMotion,
    reverse: Option<GearMotion>,
    cell: Cell,
    step_s: f64,
    speed_mps: f64,
    accel_mps2: f64,
    run_offset_std_dev: f64,
    run_offset_mps2: f64,
    run: Random,
    disturbance: RandomDisturbance,
    slope_mass_kg: f64,
    wheel_mass_kg: f64,
    brake_accel_per_nm: f64,
    power_limit_nm_mps: f64,
}

/// The power limit of the drive that a fit found.
fn power_limit(file: &Table1File) -> f64 {
    let limit = file.actuator.drive.as_ref().and_then(|d| d.limit);
    limit.filter(|l| l.kind == LimitKind::Power).map_or(f64::INFINITY, |l| l.value)
}

impl IdentifiedMotion {
    /// At rest.
    ///
    /// # Errors
    /// A number is out of its range, or the vehicle never moves on the surface.
    pub(crate) fn new(settings: &IdentifiedSettings, vehicle: &Vehicle, step_s: f64, seed: u64) -> Result<Self> {
        settings.check()?;
        let vehicle = vehicle.checked()?;
        let way = |d: &GearSurface| GearMotion { surface: Surface::new(&d.table), breakaway_nm: d.breakaway_nm };
        let forward = way(&settings.forward);
        // slope of the surface at standstill between breakaway and the largest torque: 1/(M r)
        let largest_nm = settings.forward.table.torque_nm().last();
        let rise = forward.surface.accel(&mut Cell::default(), 0.0, largest_nm)
            - forward.surface.accel(&mut Cell::default(), 0.0, forward.breakaway_nm);
        let accel_per_nm = rise / (largest_nm - forward.breakaway_nm);
        if accel_per_nm.is_nan() || accel_per_nm <= 0.0 || largest_nm <= forward.breakaway_nm {
            return Err(Error::NeverMoves { largest_nm });
        }
        let mut motion = Self {
            forward,
            reverse: settings.reverse.as_ref().map(way),
            cell: Cell::default(),
            step_s,
            speed_mps: 0.0,
            accel_mps2: 0.0,
            run_offset_std_dev: settings.run_offset_mps2,
            run_offset_mps2: 0.0,
            run: Random::new(seed, Stream::Run),
            disturbance: RandomDisturbance::new(seed, settings.disturbance_mps2, settings.disturbance_time_s, step_s),
            slope_mass_kg: settings.slope_share / (accel_per_nm * vehicle.wheel_radius_m),
            wheel_mass_kg: settings.wheel_mass_kg,
            brake_accel_per_nm: accel_per_nm,
            power_limit_nm_mps: settings.power_limit_nm_mps,
        };
        motion.begin_run();
        Ok(motion)
    }

    /// Draws the offset of the next run.
    pub(crate) fn begin_run(&mut self) {
        self.run_offset_mps2 = if self.run_offset_std_dev > 0.0 { self.run_offset_std_dev * self.run.normal() } else { 0.0 };
    }

    /// Current speed [m/s].
    #[inline]
    pub(crate) fn speed_mps(&self) -> f64 {
        self.speed_mps
    }

    /// Acceleration at the end of the last step [m/s²].
    #[inline]
    pub(crate) fn accel_mps2(&self) -> f64 {
        self.accel_mps2
    }

    /// Sets the speed directly [m/s].
    pub(crate) fn set_speed(&mut self, speed_mps: f64) {
        self.speed_mps = speed_mps;
        self.accel_mps2 = 0.0;
    }

    /// Mass on which a slope acts along the wheel [kg].
    pub(crate) fn slope_mass_kg(&self) -> f64 {
        self.slope_mass_kg
    }

    /// Inertia of wheel and motor as mass at the rim [kg].
    pub(crate) fn wheel_mass_kg(&self) -> f64 {
        self.wheel_mass_kg
    }

    #[inline]
    fn way(&self, sign: f64) -> &GearMotion {
        if sign < 0.0 { self.reverse.as_ref().unwrap_or(&self.forward) } else { &self.forward }
    }

    /// Direction in which a resting wheel starts to move; `None` while it stays at rest.
    fn departure(&self, load: &Load) -> Option<f64> {
        let drive_nm = match load.gear {
            Some(gear) if load.torque.start_nm * gear.sign() > 0.0 => load.torque.start_nm,
            _ => 0.0,
        };
        let net_nm = drive_nm + load.external_nm;
        let sign = net_nm.signum();
        (net_nm.abs() > self.way(sign).breakaway_nm + load.brake_nm).then_some(sign)
    }

    /// Advances one step.
    #[allow(clippy::inline_always)] // three numbers returned through memory would stall every step of the world
    #[inline(always)]
    pub(crate) fn step(&mut self, load: &Load) -> SpeedStep {
        let start_mps = self.speed_mps;
        let sign = if start_mps == 0.0 {
            let Some(sign) = self.departure(load) else {
                self.accel_mps2 = 0.0;
                return SpeedStep::default();
            };
            sign
        } else {
            start_mps.signum()
        };
        let random_mps2 = self.disturbance.step() + self.run_offset_mps2 - load.brake_nm * self.brake_accel_per_nm;
        let (h, s0) = (self.step_s, sign * start_mps);
        let most_nm = self.power_limit_nm_mps / s0.max(1e-6);
        let u = [load.torque.start_nm, load.torque.mid_nm, load.torque.end_nm].map(|t| (sign * t).min(most_nm) + sign * load.external_nm);
        // within a cell v̇ = a + A_v·(v − v₀) + A_τ·(τ − τ̄): exact for the step's mean torque τ̄, at the middle for that of its first half
        let mean = (u[0] + 4.0 * u[1] + u[2]) * (1.0 / 6.0);
        let mean_of_first_half = (5.0 * u[0] + 8.0 * u[1] - u[2]) * (1.0 / 12.0);
        let mut cell = self.cell;
        let plane = self.way(sign).surface.plane(&mut cell, s0, mean);
        self.cell = cell;
        let accel = plane.accel + random_mps2;
        let half_way = accel + plane.by_torque * (mean_of_first_half - mean);
        let mid = s0 + 0.5 * h * half_way * mean_growth(0.5 * h * plane.by_speed);
        let end = s0 + h * accel * mean_growth(h * plane.by_speed);
        if end <= 0.0 {
            self.speed_mps = 0.0;
            self.accel_mps2 = 0.0;
            return SpeedStep { start_mps, mid_mps: sign * mid.max(0.0), end_mps: 0.0 };
        }
        self.speed_mps = sign * end;
        self.accel_mps2 = sign * (accel + plane.by_speed * (end - s0) + plane.by_torque * (u[2] - mean));
        SpeedStep { start_mps, mid_mps: sign * mid, end_mps: self.speed_mps }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::map::Axis;
    use crate::sim::drive::TorqueStep;

    /// a = (τ − 8 − 5 v)/13, linear, so that bilinear interpolation is exact.
    pub(crate) fn linear() -> GearSurface {
        let speed = Axis::uniform("speed", 0.0, 0.1, 2.0).unwrap();
        let torque = Axis::uniform("torque", -40.0, 4.0, 40.0).unwrap();
        let values = torque.breaks().iter().flat_map(|u| speed.breaks().iter().map(move |v| (u - 8.0 - 5.0 * v) / 13.0)).collect();
        GearSurface { table: AccelTable::new(speed, torque, values).unwrap(), breakaway_nm: 8.0 }
    }

    fn settings() -> IdentifiedSettings {
        IdentifiedSettings {
            forward: linear(),
            reverse: None,
            power_limit_nm_mps: f64::INFINITY,
            disturbance_mps2: 0.0,
            disturbance_time_s: 0.3,
            run_offset_mps2: 0.0,
            slope_share: 0.5,
            wheel_mass_kg: 8.0,
        }
    }

    fn motion() -> IdentifiedMotion {
        let vehicle =
            Vehicle { wheelbase_m: 0.9, wheel_radius_m: 0.12, test_angle_deg: 90.0, torque_limit_nm: None, torque_full_scale_nm: None };
        IdentifiedMotion::new(&settings(), &vehicle, 1e-3, 1).unwrap()
    }

    fn load(torque_nm: f64, gear: Option<Gear>) -> Load {
        let torque = TorqueStep { start_nm: torque_nm, mid_nm: torque_nm, end_nm: torque_nm };
        Load { torque, external_nm: 0.0, brake_nm: 0.0, gear }
    }

    #[test]
    fn a_linear_surface_gives_the_analytic_exponential() {
        let mut motion = motion();
        for _ in 0..2000 {
            motion.step(&load(16.0, Some(Gear::Forward)));
        }
        let expected = 8.0 / 5.0 * (1.0 - (-5.0 / 13.0 * 2.0_f64).exp());
        assert!((motion.speed_mps() - expected).abs() < 1e-11, "{} for {expected}", motion.speed_mps());
    }

    #[test]
    fn braking_stops_the_wheel_and_never_pushes_it_backwards() {
        let mut motion = motion();
        motion.set_speed(0.5);
        for _ in 0..5000 {
            let step = motion.step(&load(-40.0, Some(Gear::Forward)));
            assert!(step.end_mps >= 0.0 && step.mid_mps >= 0.0);
        }
        assert_eq!(motion.speed_mps(), 0.0);
        motion.step(&load(-40.0, Some(Gear::Reverse)));
        assert!(motion.speed_mps() < 0.0, "the same torque drives in reverse gear");
    }

    #[test]
    fn at_rest_torque_below_breakaway_or_in_neutral_moves_nothing() {
        let mut motion = motion();
        for (torque, gear) in [(7.99, Some(Gear::Forward)), (-7.99, Some(Gear::Reverse)), (40.0, None)] {
            for _ in 0..1000 {
                motion.step(&load(torque, gear));
            }
            assert_eq!(motion.speed_mps(), 0.0);
        }
    }

    #[test]
    fn perturbed_friction_and_inertia_change_the_surface_by_the_equation() {
        let perturbed = linear().perturbed(1.2, 1.1);
        assert!((perturbed.breakaway_nm - 8.8).abs() < 1e-12);
        let expected = (20.0 - 1.1 * (8.0 + 5.0 * 0.5)) / 13.0 / 1.2;
        let found = perturbed.table.accel_from_torque(0.5, 20.0).unwrap();
        assert!((found - expected).abs() < 1e-12, "{found} for {expected}");
    }

    #[test]
    fn beyond_the_torque_axis_the_surface_is_extrapolated_linearly() {
        let surface = Surface::new(&linear().table);
        assert!((surface.accel(&mut Cell::default(), 0.2, 60.0) - (60.0 - 8.0 - 1.0) / 13.0).abs() < 1e-12);
        let edge = surface.accel(&mut Cell::default(), 2.0, 20.0);
        assert_eq!(surface.accel(&mut Cell { speed: 3, torque: 2 }, 9.0, 20.0), edge);
    }
}
