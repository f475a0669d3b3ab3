//! The physical plant: effective inertia, friction, scrub, slope, true stiction.
//!
//! At wheel angle δ, with rolling radius r and wheelbase L, the effective mass M(δ) acts at the front wheel's rim:
//!
//! ```text
//! M v̇ = [η·τ + τ_ext − sign(v)·(T_f(|v|, δ) + T_brake)]/r
//! M(δ) = m cos²δ + J sin²δ/L² + J_w/r²
//! T_f(s, δ) = T_c + T_scrub sin²δ + (T_s − T_c)/(1 + (s/v_s)²) + b s + c s²
//! ```
//!
//! η differs between driving and braking. A wheel at rest stays exactly at rest while `|η·τ + τ_ext| ≤ T_f(0, δ) + T_brake`. The friction
//! curve is the Stribeck curve in the rational form of Hess & Soom (1990), *Friction at a Lubricated Line Contact Operating at Oscillating
//! Sliding Velocities*. The change of M during steering is neglected: campaigns and pivots steer at rest.

use crate::map::Vehicle;
use crate::sim::error::{Result, within};
use serde::{Deserialize, Serialize};

/// Settings of the physical plant. Torques are at the wheel.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct PhysicalSettings {
    /// Mass m of the vehicle [kg].
    pub mass_kg: f64,
    /// Moment of inertia J about the vertical axis through the rear axle's middle [kg·m²].
    pub yaw_inertia_kgm2: f64,
    /// Moment of inertia `J_w` of wheel, gear and motor at the wheel [kg·m²].
    pub wheel_inertia_kgm2: f64,
    /// Coulomb friction `T_c` [N·m].
    pub coulomb_nm: f64,
    /// Friction at standstill `T_s` [N·m], at least `T_c`; breakaway torque = `T_s` + scrub torque.
    pub static_nm: f64,
    /// Speed `v_s` over which static friction fades [m/s].
    pub stribeck_speed_mps: f64,
    /// Viscous friction b [N·m per m/s].
    pub viscous_nm_s_m: f64,
    /// Quadratic friction c [N·m per (m/s)²].
    pub quadratic_nm_s2_m2: f64,
    /// Scrub torque of the tyres at 90° [N·m].
    pub scrub_nm: f64,
    /// Share η of the torque that reaches the wheel when driving.
    pub drive_efficiency: f64,
    /// The same when braking; above 1 if the transmission's losses help to brake.
    pub brake_efficiency: f64,
    /// Friction in reverse over friction forward.
    pub reverse_friction_factor: f64,
    /// Largest mechanical power of the drive [W]; unlimited if absent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub power_limit_w: Option<f64>,
    /// Speeds between which a governor takes the driving torque away [m/s]: all of it from the second on. Default: none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub governor_mps: Option<[f64; 2]>,
    /// Share by which friction falls while the vehicle warms up, below 1; negative if it rises. Default 0.
    pub friction_fall: f64,
    /// Time constant of the warming [s]: friction has fallen by 63 % of its fall then. Default 300.
    pub warming_time_s: f64,
    /// Share of the effective mass on which a slope acts along the wheel, 0 to 1. For a pivot: distance of the centre of mass from the rear
    /// axle, divided by the wheelbase.
    pub slope_share: f64,
    /// Standard deviation of friction between runs, as a share (warm-up, floor, battery).
    pub friction_spread: f64,
    /// Standard deviation of the slow disturbance while moving [N·m].
    pub disturbance_nm: f64,
    /// Its time constant [s].
    pub disturbance_time_s: f64,
}

impl Default for PhysicalSettings {
    /// A scrubber with an effective mass of 110 kg at 90°, breakaway near 8 N·m, and no random parts.
    fn default() -> Self {
        Self {
            mass_kg: 190.0,
            yaw_inertia_kgm2: 84.0,
            wheel_inertia_kgm2: 0.09,
            coulomb_nm: 3.6,
            static_nm: 5.2,
            stribeck_speed_mps: 0.06,
            viscous_nm_s_m: 5.0,
            quadratic_nm_s2_m2: 1.2,
            scrub_nm: 2.4,
            drive_efficiency: 0.95,
            brake_efficiency: 1.03,
            reverse_friction_factor: 1.04,
            power_limit_w: None,
            governor_mps: None,
            friction_fall: 0.0,
            warming_time_s: 300.0,
            slope_share: 0.5,
            friction_spread: 0.0,
            disturbance_nm: 0.0,
            disturbance_time_s: 0.3,
        }
    }
}

impl PhysicalSettings {
    /// Checks every number.
    ///
    /// # Errors
    /// The first field that is out of its range.
    pub fn check(&self) -> Result<()> {
        let torque = 0.0..=1e5;
        within("motion.mass_kg", self.mass_kg, 1.0..=1e5, "1 to 1e5")?;
        within("motion.yaw_inertia_kgm2", self.yaw_inertia_kgm2, 1e-3..=1e6, "0.001 to 1e6")?;
        within("motion.wheel_inertia_kgm2", self.wheel_inertia_kgm2, 1e-6..=1e4, "1e-6 to 1e4")?;
        within("motion.coulomb_nm", self.coulomb_nm, torque.clone(), "0 to 1e5")?;
        within("motion.static_nm", self.static_nm, self.coulomb_nm..=1e5, "coulomb_nm to 1e5")?;
        within("motion.stribeck_speed_mps", self.stribeck_speed_mps, 1e-3..=10.0, "0.001 to 10")?;
        within("motion.viscous_nm_s_m", self.viscous_nm_s_m, torque.clone(), "0 to 1e5")?;
        within("motion.quadratic_nm_s2_m2", self.quadratic_nm_s2_m2, torque.clone(), "0 to 1e5")?;
        within("motion.scrub_nm", self.scrub_nm, torque.clone(), "0 to 1e5")?;
        within("motion.drive_efficiency", self.drive_efficiency, 0.1..=1.5, "0.1 to 1.5")?;
        within("motion.brake_efficiency", self.brake_efficiency, 0.1..=2.0, "0.1 to 2")?;
        within("motion.reverse_friction_factor", self.reverse_friction_factor, 0.1..=10.0, "0.1 to 10")?;
        within("motion.power_limit_w", self.power_limit_w.unwrap_or(1.0), 1e-3..=1e7, "0.001 to 1e7")?;
        let [from, to] = self.governor_mps.unwrap_or([0.5, 0.6]);
        within("motion.governor_mps[0]", from, 0.0..=100.0, "0 to 100")?;
        within("motion.governor_mps[1]", to, from + 1e-3..=100.0, "above the first to 100")?;
        within("motion.friction_fall", self.friction_fall, -2.0..=0.9, "-2 to 0.9")?;
        within("motion.warming_time_s", self.warming_time_s, 1e-3..=1e6, "0.001 to 1e6")?;
        within("motion.slope_share", self.slope_share, 0.0..=1.0, "0 to 1")?;
        within("motion.friction_spread", self.friction_spread, 0.0..=0.5, "0 to 0.5")?;
        within("motion.disturbance_nm", self.disturbance_nm, torque, "0 to 1e5")?;
        within("motion.disturbance_time_s", self.disturbance_time_s, 1e-3..=1e4, "0.001 to 1e4")
    }
}

/// The plant's constants, without its state.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Plant {
    pub(crate) settings: PhysicalSettings,
    radius_m: f64,
    yaw_mass_kg: f64,
    pub(crate) wheel_mass_kg: f64,
    pub(crate) per_stribeck2: f64,
    pub(crate) power_nm_mps: f64,
}

/// Terms that depend on the wheel angle.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct AtAngle {
    /// 1/(M r) [m/s² per N·m].
    pub(crate) accel_per_nm: f64,
    /// `T_c + T_scrub sin²δ` [N·m].
    coulomb_nm: f64,
}

/// Direction of motion and its friction.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FrictionDirection {
    /// +1 forward, −1 in reverse.
    pub(crate) sign: f64,
    /// Factor on all friction.
    pub(crate) friction: f64,
}

impl Plant {
    pub(crate) fn new(settings: &PhysicalSettings, vehicle: &Vehicle) -> Result<Self> {
        settings.check()?;
        let vehicle = vehicle.checked()?;
        let radius_m = vehicle.wheel_radius_m;
        Ok(Self {
            settings: *settings,
            radius_m,
            yaw_mass_kg: settings.yaw_inertia_kgm2 / vehicle.wheelbase_m.powi(2),
            wheel_mass_kg: settings.wheel_inertia_kgm2 / radius_m.powi(2),
            per_stribeck2: settings.stribeck_speed_mps.powi(-2),
            power_nm_mps: settings.power_limit_w.map_or(f64::INFINITY, |power| power * radius_m),
        })
    }

    /// M(δ) [kg].
    pub(crate) fn effective_mass_kg(&self, sin: f64, cos: f64) -> f64 {
        self.settings.mass_kg * cos * cos + self.yaw_mass_kg * sin * sin + self.wheel_mass_kg
    }

    pub(crate) fn at_angle(&self, sin: f64, cos: f64) -> AtAngle {
        AtAngle {
            accel_per_nm: 1.0 / (self.effective_mass_kg(sin, cos) * self.radius_m),
            coulomb_nm: self.settings.coulomb_nm + self.settings.scrub_nm * sin * sin,
        }
    }

    #[inline]
    pub(crate) fn way(&self, sign: f64, run_factor: f64) -> FrictionDirection {
        let friction = if sign < 0.0 { self.settings.reverse_friction_factor } else { 1.0 };
        FrictionDirection { sign, friction: friction * run_factor }
    }

    /// Torque that reaches the wheel [N·m] at speed `s` ≥ 0 along `way`.
    #[inline]
    pub(crate) fn arriving_nm(&self, way: FrictionDirection, s: f64, torque_nm: f64) -> f64 {
        if torque_nm * way.sign >= 0.0 {
            self.settings.drive_efficiency * self.delivered_nm(s, torque_nm)
        } else {
            self.settings.brake_efficiency * torque_nm
        }
    }

    /// Driving torque that the drive delivers at speed `s` ≥ 0 of a requested one [N·m].
    #[inline]
    fn delivered_nm(&self, s: f64, torque_nm: f64) -> f64 {
        let within_power = torque_nm.abs() * s <= self.power_nm_mps;
        let torque_nm = if within_power { torque_nm } else { (self.power_nm_mps / s).copysign(torque_nm) };
        match self.settings.governor_mps {
            None => torque_nm,
            Some([from, to]) => torque_nm * ((to - s) / (to - from)).clamp(0.0, 1.0),
        }
    }

    /// Torque that the drive delivers of a requested one [N·m], at a speed [m/s] of either sign.
    pub(crate) fn delivered_at_nm(&self, speed_mps: f64, torque_nm: f64) -> f64 {
        if torque_nm * speed_mps > 0.0 { self.delivered_nm(speed_mps.abs(), torque_nm) } else { torque_nm }
    }

    /// Friction after a time of warming, relative to that at the start.
    pub(crate) fn warmed(&self, t_s: f64) -> f64 {
        1.0 - self.settings.friction_fall * (1.0 - (-t_s / self.settings.warming_time_s).exp())
    }

    /// `T_f` [N·m] at speed `s` ≥ 0.
    #[inline]
    pub(crate) fn friction_nm(&self, at: AtAngle, way: FrictionDirection, s: f64) -> f64 {
        let p = &self.settings;
        let fading = (p.static_nm - p.coulomb_nm) / (1.0 + s * s * self.per_stribeck2);
        way.friction * (at.coulomb_nm + fading + (p.viscous_nm_s_m + p.quadratic_nm_s2_m2 * s) * s)
    }

    /// The friction curve of one direction at one angle.
    pub(crate) fn curve(&self, at: AtAngle, way: FrictionDirection) -> Curve {
        let p = &self.settings;
        let scale = at.accel_per_nm * way.friction;
        Curve {
            constant: scale * at.coulomb_nm,
            fading: scale * (p.static_nm - p.coulomb_nm),
            viscous: scale * p.viscous_nm_s_m,
            quadratic: scale * p.quadratic_nm_s2_m2,
        }
    }

    /// v̇ [m/s²] while moving along `way`, vehicle frame.
    #[inline]
    pub(crate) fn accel(
        &self,
        at: AtAngle,
        way: FrictionDirection,
        speed_mps: f64,
        torque_nm: f64,
        external_nm: f64,
        brake_nm: f64,
    ) -> f64 {
        // a stage of the integrator may be slightly past a stop
        let s = (speed_mps * way.sign).max(0.0);
        let friction = self.friction_nm(at, way, s) + brake_nm;
        at.accel_per_nm * (self.arriving_nm(way, s, torque_nm) + external_nm - way.sign * friction)
    }
}

/// `T_f/(M r)` [m/s²] over speed: the friction curve in units of acceleration.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Curve {
    constant: f64,
    fading: f64,
    viscous: f64,
    quadratic: f64,
}

impl Curve {
    /// Value at `s` ≥ 0 and derivative by `s`.
    #[inline]
    pub(crate) fn at(&self, s: f64, per_stribeck2: f64) -> (f64, f64) {
        let fraction = 1.0 / (1.0 + s * s * per_stribeck2);
        let fading = self.fading * fraction;
        let linear = self.viscous + self.quadratic * s;
        let value = self.constant + fading + linear * s;
        (value, linear + (self.quadratic - 2.0 * per_stribeck2 * (fading * fraction)) * s)
    }
}
