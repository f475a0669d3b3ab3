//! Torque for a manoeuvre: the maps under test over the wheel angle. With the map of one angle only, that map is used at its angle and
//! the exact inverse of the physical plant at all others.

use crate::control::{AngleTable, AngleTables, GearTerms, OutsidePolicy, Tables, TorqueFromAccel};
use crate::guidance::torque_source::TorqueSource;
use crate::manoeuvre::Result;
use crate::map::{Gear, SAME_ANGLE_DEG, Side, TorqueTable};
use crate::sim;
use crate::sim::{MotionSettings, Truth};
use crate::units::RAD_PER_DEG;
use crate::verify::Maps;

/// A perfect map of every wheel angle: the plant's own equation, solved for the torque.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ExactTorque {
    truth: Option<Truth>,
    limit_nm: f64,
}

/// Halvings of the torque range: 88 N·m to 1e-10 N·m.
const HALVINGS: u32 = 40;

impl ExactTorque {
    /// For a world with a physical plant; an identified plant has no other wheel angle and gives no torque.
    ///
    /// # Errors
    /// A plant out of its range.
    pub(crate) fn new(world: &sim::WorldSettings) -> Result<Self> {
        let truth = match &world.motion {
            MotionSettings::Physical(physical) => Some(Truth::new(physical, &world.vehicle)?),
            MotionSettings::Identified(_) => None,
        };
        let limit_nm = world.drive.torque_limit_nm.min(world.vehicle.torque_limit_nm.unwrap_or(f64::INFINITY));
        Ok(Self { truth, limit_nm })
    }
}

impl TorqueSource for ExactTorque {
    fn torque_nm(&self, speed_mps: f64, accel_mps2: f64, wheel_angle_rad: f64) -> f64 {
        let Some(truth) = &self.truth else { return 0.0 };
        if !(speed_mps.is_finite() && accel_mps2.is_finite() && wheel_angle_rad.is_finite()) {
            return 0.0;
        }
        let (mut low, mut high) = (-self.limit_nm, self.limit_nm);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            if truth.accel_mps2(speed_mps, middle, wheel_angle_rad) < accel_mps2 {
                low = middle;
            } else {
                high = middle;
            }
        }
        0.5 * (low + high)
    }
}

/// The map is used within this of its wheel angle [rad]: the tolerance within which the wheel is held during a turn.
const AT_MAP_RAD: f64 = 3.0 * RAD_PER_DEG;

/// The maps under test: over the measured wheel angles if there are several, otherwise for pivots only. The exact inverse is used at every
/// other angle.
#[derive(Debug, Clone)]
pub(crate) struct ManoeuvreTorque<'a> {
    tables: Option<Tables<'a>>,
    angle_rad: f64,
    angles: Vec<AngleTable<'a>>,
    terms: Vec<GearTerms<'a>>,
    exact: ExactTorque,
}

impl<'a> ManoeuvreTorque<'a> {
    /// For a map and a physical world; without a map the exact inverse is used everywhere.
    ///
    /// # Errors
    /// A plant out of its range.
    pub(crate) fn new(maps: Option<&'a Maps>, world: &sim::WorldSettings) -> Result<Self> {
        let tables = maps.map(|m| Tables {
            forward: m.forward.view(),
            reverse: m.reverse.as_ref().map(TorqueTable::view),
            policy: OutsidePolicy::Clamp,
        });
        let angle_deg = maps.map_or(90.0, |m| m.table2.vehicle.test_angle_deg);
        let angles = maps.iter().flat_map(|m| &m.angles);
        let angles =
            angles.map(|m| AngleTable { gear: m.gear, wheel_angle_rad: m.wheel_angle_deg * RAD_PER_DEG, table: m.table.view() }).collect();
        let families = maps.iter().flat_map(|m| &m.table2.families);
        let terms = families.map(|f| GearTerms { gear: f.gear, left: f.side == Side::Left, terms: f.terms() }).collect();
        Ok(Self { tables, angle_rad: angle_deg * RAD_PER_DEG, angles, terms, exact: ExactTorque::new(world)? })
    }

    /// The torque source of the manoeuvres, in words.
    pub(crate) fn what(maps: &Maps) -> String {
        if maps.angles.is_empty() {
            let angle_deg = maps.table2.vehicle.test_angle_deg;
            return format!("manoeuvres: torque from the map at {angle_deg}°; at other wheel angles from the exact inverse of the plant");
        }
        let of = |gear: Gear| {
            let mut angles: Vec<f64> = maps.angles.iter().filter(|m| m.gear == gear).map(|m| m.wheel_angle_deg).collect();
            angles.sort_unstable_by(f64::total_cmp);
            let angles: Vec<String> = angles.iter().map(|a| format!("{a}°")).collect();
            if angles.is_empty() { "no angle".to_owned() } else { angles.join(", ") }
        };
        let sided = |left: bool| maps.angles.iter().any(|m| m.wheel_angle_deg.abs() > SAME_ANGLE_DEG && (m.wheel_angle_deg > 0.0) == left);
        let symmetry = if sided(true) && sided(false) { "" } else { "; the other side's maps are mirrored: symmetry assumed" };
        format!(
            "manoeuvres: torque from the maps at {} (forward) and {} (reverse); at larger angles from the exact inverse of the plant{symmetry}",
            of(Gear::Forward),
            of(Gear::Reverse)
        )
    }

    /// What a pass is about, if it is not about the map: with a map of one wheel angle the plant's own inverse drives at every other angle.
    pub(crate) fn about(maps: &Maps) -> Option<String> {
        let angle_deg = maps.table2.vehicle.test_angle_deg;
        maps.angles
            .is_empty()
            .then(|| format!("the path planner and its laws, not the map: torque away from {angle_deg}° is the plant's exact inverse"))
    }

    /// Torque of the test angle's map, if the wheel is at that angle.
    fn at_test_angle(&self, gear: Gear, speed_mps: f64, accel_mps2: f64, wheel_angle_rad: f64) -> Option<f64> {
        let tables = self.tables.as_ref().filter(|_| (wheel_angle_rad - self.angle_rad).abs() <= AT_MAP_RAD)?;
        Some(tables.torque(gear, speed_mps, accel_mps2)?.torque_nm)
    }
}

impl TorqueSource for ManoeuvreTorque<'_> {
    fn torque_nm(&self, speed_mps: f64, accel_mps2: f64, wheel_angle_rad: f64) -> f64 {
        let gear = if speed_mps.is_sign_negative() { Gear::Reverse } else { Gear::Forward };
        let (speed, accel) = (speed_mps.abs(), gear.sign() * accel_mps2);
        let found = if self.angles.is_empty() {
            self.at_test_angle(gear, speed, accel, wheel_angle_rad)
        } else {
            // a map holds nothing beyond the measured angles
            let maps = AngleTables { tables: &self.angles, terms: &self.terms };
            maps.torque_clamped(gear, speed, accel, wheel_angle_rad).filter(|found| !found.beyond_angles).map(|found| found.torque_nm)
        };
        found.map_or_else(|| self.exact.torque_nm(speed_mps, accel_mps2, wheel_angle_rad), |torque_nm| gear.sign() * torque_nm)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::sim::VehicleFile;

    #[test]
    fn the_exact_torque_gives_the_acceleration_at_every_angle_in_both_directions() {
        let world = VehicleFile::bundled().unwrap().settings();
        let exact = ExactTorque::new(&world).unwrap();
        let truth = exact.truth.unwrap();
        for angle_deg in [0.0, 30.0, -60.0, 90.0] {
            for (v, a) in [(0.0, 0.3), (0.5, -0.6), (-0.0, -0.3), (-0.5, 0.4)] {
                let angle = angle_deg * RAD_PER_DEG;
                let torque_nm = exact.torque_nm(v, a, angle);
                assert!((truth.accel_mps2(v, torque_nm, angle) - a).abs() < 1e-6, "{angle_deg} {v} {a}: {torque_nm}");
            }
        }
        assert_eq!(exact.torque_nm(f64::NAN, 0.0, 0.0), 0.0);
    }
}
