//! The physical plant in motion: integrates the equation of `plant.rs`, with true stiction.
//!
//! At rest the wheel stays exactly at rest while the torque does not exceed static friction. A wheel that comes to rest inside a step ends
//! the step at rest. In motion, a step is of fourth order.

use crate::map::Vehicle;
use crate::sim::error::Result;
use crate::sim::load::{Load, runge_kutta};
use crate::sim::plant::{AtAngle, Curve, FrictionDirection, PhysicalSettings, Plant};
use crate::sim::pose::{SpeedStep, WheelAngleTerms};
use crate::sim::random::{Random, RandomDisturbance, Stream};

/// The physical plant's state.
#[derive(Debug, Clone)]
pub(crate) struct PhysicalMotion {
    plant: Plant,
    step_s: f64,
    at: [AtAngle; 3],
    steady: bool,
    /// Friction forward and in reverse at the steady angle, for this run.
    curves: [Curve; 2],
    speed_mps: f64,
    accel_mps2: f64,
    run_factor: f64,
    steps: u64,
    run: Random,
    disturbance: RandomDisturbance,
}

impl PhysicalMotion {
    /// At rest, wheel straight ahead.
    ///
    /// # Errors
    /// A setting is out of its range.
    pub(crate) fn new(settings: &PhysicalSettings, vehicle: &Vehicle, step_s: f64, seed: u64) -> Result<Self> {
        let plant = Plant::new(settings, vehicle)?;
        let mut motion = Self {
            plant,
            step_s,
            at: [plant.at_angle(0.0, 1.0); 3],
            steady: true,
            curves: [Curve::default(); 2],
            speed_mps: 0.0,
            accel_mps2: 0.0,
            run_factor: 1.0,
            steps: 0,
            run: Random::new(seed, Stream::Run),
            disturbance: RandomDisturbance::new(seed, settings.disturbance_nm, settings.disturbance_time_s, step_s),
        };
        motion.begin_run();
        Ok(motion)
    }

    /// Draws the friction of the next run (never below a fifth of the nominal), of the vehicle as warm as it is by then.
    pub(crate) fn begin_run(&mut self) {
        let spread = self.plant.settings.friction_spread;
        let drawn = if spread > 0.0 { (1.0 + spread * self.run.normal()).max(0.2) } else { 1.0 };
        self.run_factor = drawn * self.plant.warmed(self.steps as f64 * self.step_s);
        self.draw_curves();
    }

    fn draw_curves(&mut self) {
        self.curves = [1.0, -1.0].map(|sign| self.plant.curve(self.at[0], self.plant.way(sign, self.run_factor)));
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

    /// Sets the wheel angle at start, middle and end of the next steps.
    pub(crate) fn set_angle(&mut self, angle: &WheelAngleTerms) {
        self.steady = angle.sin[0] == angle.sin[1] && angle.sin[1] == angle.sin[2];
        for (at, (sin, cos)) in self.at.iter_mut().zip(angle.sin.into_iter().zip(angle.cos)) {
            *at = self.plant.at_angle(sin, cos);
        }
        if self.steady {
            self.draw_curves();
        }
    }

    /// Torque that the drive delivers of a requested one now [N·m].
    pub(crate) fn delivered_nm(&self, torque_nm: f64) -> f64 {
        self.plant.delivered_at_nm(self.speed_mps, torque_nm)
    }

    /// Mass on which a slope acts along the wheel [kg].
    pub(crate) fn slope_mass_kg(&self) -> f64 {
        self.plant.settings.slope_share * self.plant.effective_mass_kg(1.0, 0.0)
    }

    /// Inertia of wheel and motor as mass at the rim [kg].
    pub(crate) fn wheel_mass_kg(&self) -> f64 {
        self.plant.wheel_mass_kg
    }

    /// One step of fourth order with two evaluations of the friction curve, for a steady wheel angle and no power limit.
    /// `ṡ = d(t) − φ(s)` splits into drive and friction: with `z = s − ∫d dt` and `z̈ = −φ'(s)·ṡ`, `z₁ = z₀ + h ż₀ + h²(z̈₀ + 2 z̈_½)/6`.
    /// The middle comes from the integral of the line through `z̈₀` and `z̈_½`. Half the work of the classical Runge-Kutta method.
    ///
    /// Source: Chan & Tsai (2010), *On explicit two-derivative Runge-Kutta methods*, the fourth-order method of two stages.
    #[inline]
    fn two_derivatives(&self, way: FrictionDirection, torque_nm: [f64; 3], external_nm: f64, brake_nm: f64) -> (SpeedStep, f64) {
        let (plant, h, sign) = (&self.plant, self.step_s, way.sign);
        let (k, per_stribeck2) = (self.at[0].accel_per_nm, plant.per_stribeck2);
        let curve = &self.curves[usize::from(sign < 0.0)];
        let s0 = sign * self.speed_mps;
        // below the power limit the torque at the wheel does not depend on speed
        let (driving, braking) = (sign * k * plant.settings.drive_efficiency, sign * k * plant.settings.brake_efficiency);
        let d = torque_nm.map(|t| t * if t * sign >= 0.0 { driving } else { braking });
        let constant = k * (sign * external_nm - brake_nm);
        let driven_mid = h * (5.0 * d[0] + 8.0 * d[1] - d[2]) * (1.0 / 24.0);
        let driven_end = h * (d[0] + 4.0 * d[1] + d[2]) * (1.0 / 6.0);
        let (friction, slope) = curve.at(s0, per_stribeck2);
        let z1 = constant - friction;
        let z2 = -slope * (d[0] + z1);
        let s_mid = s0 + driven_mid + 0.5 * h * z1 + 0.125 * h * h * z2;
        let (friction, slope) = curve.at(s_mid.max(0.0), per_stribeck2);
        let z2_mid = -slope * (d[1] + constant - friction);
        let speed = SpeedStep {
            start_mps: self.speed_mps,
            mid_mps: sign * (s0 + driven_mid + 0.5 * h * z1 + h * h * (z2 * (1.0 / 12.0) + z2_mid * (1.0 / 24.0))),
            end_mps: sign * (s0 + driven_end + h * z1 + h * h * (z2 + 2.0 * z2_mid) * (1.0 / 6.0)),
        };
        (speed, sign * (d[2] + z1 + h * z2_mid))
    }

    /// Advances one step.
    #[inline]
    pub(crate) fn step(&mut self, load: &Load) -> SpeedStep {
        self.steps += 1;
        let start_mps = self.speed_mps;
        let mut external_nm = load.external_nm;
        let sign = if start_mps == 0.0 {
            // at rest: the wheel moves only if the torque exceeds static friction
            let torque = load.torque.start_nm;
            let toward = self.plant.way((torque + external_nm).signum(), self.run_factor);
            let net = self.plant.arriving_nm(toward, 0.0, torque) + external_nm;
            if net.abs() <= self.plant.friction_nm(self.at[0], toward, 0.0) + load.brake_nm {
                self.accel_mps2 = 0.0;
                return SpeedStep::default();
            }
            net.signum()
        } else {
            start_mps.signum()
        };
        external_nm += self.disturbance.step();
        let way = self.plant.way(sign, self.run_factor);
        let torque = [load.torque.start_nm, load.torque.mid_nm, load.torque.end_nm];
        let largest_nm = torque[0].abs().max(torque[1].abs()).max(torque[2].abs());
        // room for the speed to rise within the step
        let is_limited = largest_nm * (start_mps.abs() + 0.1) >= self.plant.power_nm_mps || self.plant.settings.governor_mps.is_some();
        let (mut speed, accel_mps2) = if self.steady && !is_limited {
            self.two_derivatives(way, torque, external_nm, load.brake_nm)
        } else {
            runge_kutta(self.step_s, start_mps, |stage, v| {
                self.plant.accel(self.at[stage], way, v, torque[stage], external_nm, load.brake_nm)
            })
        };
        self.accel_mps2 = accel_mps2;
        if speed.end_mps * sign <= 0.0 {
            // it came to rest inside the step; the next step decides whether it starts in the other direction
            speed.end_mps = 0.0;
            speed.mid_mps = if speed.mid_mps * sign <= 0.0 { 0.0 } else { speed.mid_mps };
            self.accel_mps2 = 0.0;
        }
        self.speed_mps = speed.end_mps;
        speed
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::sim::drive::TorqueStep;

    const STEP_S: f64 = 1e-3;

    fn vehicle() -> Vehicle {
        Vehicle { wheelbase_m: 0.9, wheel_radius_m: 0.12, test_angle_deg: 90.0, torque_limit_nm: None, torque_full_scale_nm: None }
    }

    fn motion(settings: &PhysicalSettings, step_s: f64) -> PhysicalMotion {
        let mut motion = PhysicalMotion::new(settings, &vehicle(), step_s, 1).unwrap();
        motion.set_angle(&WheelAngleTerms::fixed(std::f64::consts::FRAC_PI_2));
        motion
    }

    fn load(torque_nm: f64) -> Load {
        let torque = TorqueStep { start_nm: torque_nm, mid_nm: torque_nm, end_nm: torque_nm };
        Load { torque, external_nm: 0.0, brake_nm: 0.0, gear: None }
    }

    #[test]
    fn below_breakaway_the_wheel_does_not_creep_at_all() {
        let settings = PhysicalSettings::default();
        let breakaway_nm = (settings.static_nm + settings.scrub_nm) / settings.drive_efficiency;
        let mut motion = motion(&settings, STEP_S);
        for torque_nm in [breakaway_nm * 0.999, -breakaway_nm * 0.999 * settings.reverse_friction_factor] {
            for _ in 0..60_000 {
                motion.step(&load(torque_nm));
            }
            assert_eq!(motion.speed_mps(), 0.0, "a minute at {torque_nm} N·m");
        }
        motion.step(&load(breakaway_nm * 1.001));
        assert!(motion.speed_mps() > 0.0);
    }

    #[test]
    fn a_coasting_vehicle_stops_and_stays_stopped() {
        let mut motion = motion(&PhysicalSettings::default(), STEP_S);
        motion.set_speed(-0.6);
        for _ in 0..5000 {
            motion.step(&load(0.0));
        }
        assert_eq!(motion.speed_mps(), 0.0);
    }

    #[test]
    fn work_in_is_kinetic_energy_plus_friction_work() {
        let settings = PhysicalSettings { friction_spread: 0.05, disturbance_nm: 0.0, ..PhysicalSettings::default() };
        let mut motion = motion(&settings, STEP_S);
        let mass_kg = motion.plant.effective_mass_kg(1.0, 0.0);
        let (mut work_j, mut friction_j) = (0.0, 0.0);
        let way = motion.plant.way(1.0, motion.run_factor);
        for k in 0..6000 {
            let torque = if k < 3000 { 30.0 } else { 12.0 };
            let step = motion.step(&load(torque));
            let power = |v: f64| motion.plant.arriving_nm(way, v, torque) * v / 0.12;
            let loss = |v: f64| motion.plant.friction_nm(motion.at[0], way, v) * v / 0.12;
            let simpson = |f: &dyn Fn(f64) -> f64| STEP_S * (f(step.start_mps) + 4.0 * f(step.mid_mps) + f(step.end_mps)) / 6.0;
            work_j += simpson(&power);
            friction_j += simpson(&loss);
        }
        let kinetic_j = 0.5 * mass_kg * motion.speed_mps().powi(2);
        // three independent sums: the trapezoids of the energies agree to the integrator's error
        assert!(work_j > 50.0 && (work_j - friction_j - kinetic_j).abs() < 1e-8 * work_j, "{work_j} {friction_j} {kinetic_j}");
    }

    #[test]
    fn with_viscous_friction_alone_the_speed_is_the_analytic_exponential() {
        let settings = PhysicalSettings {
            coulomb_nm: 0.0,
            static_nm: 0.0,
            scrub_nm: 0.0,
            quadratic_nm_s2_m2: 0.0,
            drive_efficiency: 1.0,
            ..PhysicalSettings::default()
        };
        let mut motion = motion(&settings, STEP_S);
        let mass_kg = motion.plant.effective_mass_kg(1.0, 0.0);
        for _ in 0..2000 {
            motion.step(&load(10.0));
        }
        let rate = settings.viscous_nm_s_m / (mass_kg * 0.12);
        let expected = 10.0 / settings.viscous_nm_s_m * (1.0 - (-rate * 2.0).exp());
        assert!((motion.speed_mps() - expected).abs() < 1e-12, "{} for {expected}", motion.speed_mps());
    }

    #[test]
    fn halving_the_step_divides_the_speed_error_by_sixteen() {
        let speed_after_2_s = |steps: u32| {
            let step_s = 2.0 / f64::from(steps);
            let mut motion = motion(&PhysicalSettings { stribeck_speed_mps: 0.2, ..PhysicalSettings::default() }, step_s);
            motion.set_speed(0.05);
            for k in 0..steps {
                let torque = |part: f64| 25.0 + 10.0 * (4.0 * (f64::from(k) + part) * step_s).sin();
                let torque = TorqueStep { start_nm: torque(0.0), mid_nm: torque(0.5), end_nm: torque(1.0) };
                motion.step(&Load { torque, ..load(0.0) });
            }
            motion.speed_mps()
        };
        let exact = speed_after_2_s(20_000);
        let error = |steps| (speed_after_2_s(steps) - exact).abs();
        let (coarse, fine, finest) = (error(80), error(160), error(320));
        for order in [(coarse / fine).log2(), (fine / finest).log2()] {
            assert!((3.6..4.6).contains(&order), "order {order}: errors {coarse:e} {fine:e} {finest:e}");
        }
    }

    #[test]
    fn both_integrators_agree_to_their_order() {
        let mut fast = motion(&PhysicalSettings::default(), STEP_S);
        let mut classical = fast.clone();
        classical.steady = false;
        for k in 0..3000 {
            let torque = if k < 1500 { 30.0 } else { -12.0 };
            for motion in [&mut fast, &mut classical] {
                motion.step(&load(torque));
            }
            let apart = (fast.speed_mps() - classical.speed_mps()).abs();
            assert!(apart < 1e-7, "step {k}: {apart:e} m/s apart");
            assert!((fast.accel_mps2() - classical.accel_mps2()).abs() < 1e-3, "step {k}");
        }
    }

    #[test]
    fn a_governor_takes_the_torque_away_between_its_speeds_and_a_warm_vehicle_has_less_friction() {
        let governed = PhysicalSettings { governor_mps: Some([0.5, 0.6]), ..PhysicalSettings::default() };
        let settled_mps = |settings: &PhysicalSettings| {
            let mut motion = motion(settings, STEP_S);
            for _ in 0..20_000 {
                motion.step(&load(40.0));
            }
            motion.speed_mps()
        };
        let speed_mps = settled_mps(&governed);
        assert!((0.5..0.6).contains(&speed_mps) && settled_mps(&PhysicalSettings::default()) > 2.0, "{speed_mps}");
        let mut warming = motion(&PhysicalSettings { friction_fall: 0.2, warming_time_s: 10.0, ..PhysicalSettings::default() }, STEP_S);
        for _ in 0..20_000 {
            warming.step(&load(0.0));
        }
        warming.begin_run();
        let expected = 1.0 - 0.2 * (1.0 - (-2.0f64).exp());
        assert!((warming.run_factor - expected).abs() < 1e-9, "{}", warming.run_factor);
    }

    #[test]
    fn above_the_power_limit_the_torque_falls_with_speed() {
        let mut motion = motion(&PhysicalSettings { power_limit_w: Some(60.0), ..PhysicalSettings::default() }, STEP_S);
        for _ in 0..60_000 {
            motion.step(&load(40.0));
        }
        // at equilibrium the power at the wheel equals the friction power
        let v = motion.speed_mps();
        let friction_nm = motion.plant.friction_nm(motion.at[0], motion.plant.way(1.0, 1.0), v);
        assert!((friction_nm * v / 0.12 - 0.95 * 60.0).abs() < 1e-6, "{v} m/s");
    }

    #[test]
    fn an_impossible_setting_is_reported_with_the_allowed_range() {
        let settings = PhysicalSettings { static_nm: 1.0, ..PhysicalSettings::default() };
        let error = PhysicalMotion::new(&settings, &vehicle(), STEP_S, 1).unwrap_err();
        assert_eq!(error.to_string(), "motion.static_nm is 1; allowed: coulomb_nm to 1e5");
    }
}
