//! a(v, τ): the physical plant's exact steady map, without dead time, lag and random parts. It is the reference for fits.

use crate::map::{Gear, Vehicle};
use crate::sim::error::Result;
use crate::sim::plant::{PhysicalSettings, Plant};

/// The exact map of a physical plant.
#[derive(Debug, Clone, Copy)]
pub struct Truth {
    plant: Plant,
}

impl Truth {
    /// The map of a plant with these settings.
    ///
    /// # Errors
    /// A setting is out of its range.
    pub fn new(settings: &PhysicalSettings, vehicle: &Vehicle) -> Result<Self> {
        Ok(Self { plant: Plant::new(settings, vehicle)? })
    }

    /// v̇ [m/s²] of a moving wheel at `speed_mps` under the effective torque `torque_nm`, vehicle frame. Speed 0 means "just moving
    /// forward", −0.0 "just moving in reverse"; stiction is not part of the map.
    pub fn accel_mps2(&self, speed_mps: f64, torque_nm: f64, wheel_angle_rad: f64) -> f64 {
        let (sin, cos) = wheel_angle_rad.sin_cos();
        let way = self.plant.way(1.0_f64.copysign(speed_mps), 1.0);
        self.plant.accel(self.plant.at_angle(sin, cos), way, speed_mps, torque_nm, 0.0, 0.0)
    }

    /// The same in the frame of `gear`: speed ≥ 0 in the direction of travel, torque positive if it drives in that direction.
    pub fn gear_accel_mps2(&self, gear: Gear, speed_mps: f64, torque_nm: f64, wheel_angle_rad: f64) -> f64 {
        let sign = gear.sign();
        sign * self.accel_mps2(speed_mps.abs().copysign(sign), sign * torque_nm, wheel_angle_rad)
    }

    /// Torque [N·m] that sets a resting wheel in motion in `gear`, gear frame.
    pub fn breakaway_nm(&self, gear: Gear, wheel_angle_rad: f64) -> f64 {
        let (sin, cos) = wheel_angle_rad.sin_cos();
        let way = self.plant.way(gear.sign(), 1.0);
        let driving = way.sign * self.plant.arriving_nm(way, 0.0, way.sign);
        self.plant.friction_nm(self.plant.at_angle(sin, cos), way, 0.0) / driving
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use std::f64::consts::FRAC_PI_2;

    fn truth() -> (Truth, PhysicalSettings) {
        let settings = PhysicalSettings::default();
        let vehicle =
            Vehicle { wheelbase_m: 0.9, wheel_radius_m: 0.12, test_angle_deg: 90.0, torque_limit_nm: None, torque_full_scale_nm: None };
        (Truth::new(&settings, &vehicle).unwrap(), settings)
    }

    #[test]
    fn the_map_is_the_equation_written_out() {
        let (truth, p) = truth();
        let (v, torque) = (0.4, 30.0);
        let mass = p.yaw_inertia_kgm2 / 0.81 + p.wheel_inertia_kgm2 / 0.0144;
        let friction = p.coulomb_nm
            + p.scrub_nm
            + (p.static_nm - p.coulomb_nm) / (1.0 + (v / p.stribeck_speed_mps).powi(2))
            + p.viscous_nm_s_m * v
            + p.quadratic_nm_s2_m2 * v * v;
        let expected = (p.drive_efficiency * torque - friction) / (mass * 0.12);
        assert!((truth.accel_mps2(v, torque, FRAC_PI_2) - expected).abs() < 1e-12);
        assert!((truth.gear_accel_mps2(Gear::Forward, v, torque, FRAC_PI_2) - expected).abs() < 1e-12);
    }

    #[test]
    fn breakaway_is_where_the_just_moving_map_crosses_zero() {
        let (truth, _) = truth();
        for gear in Gear::ALL {
            let breakaway_nm = truth.breakaway_nm(gear, FRAC_PI_2);
            assert!((7.0..9.5).contains(&breakaway_nm), "{breakaway_nm}");
            assert!(truth.gear_accel_mps2(gear, 0.0, breakaway_nm, FRAC_PI_2).abs() < 1e-12);
        }
        assert!(truth.breakaway_nm(Gear::Reverse, FRAC_PI_2) > truth.breakaway_nm(Gear::Forward, FRAC_PI_2));
    }
}
