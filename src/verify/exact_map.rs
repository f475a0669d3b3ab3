//! The plant's exact map and its inverse: the values of a perfect Table 2.

use crate::control::{Lookup, TorqueFromAccel};
use crate::map::{AccelTable, Axis, Gear, Vehicle};
use crate::sim::{MotionSettings, Truth, WorldSettings};
use crate::units::RAD_PER_DEG;
use crate::verify::Result;

/// a(v, τ) of the plant, one fine table per gear.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct ExactMap {
    forward: AccelTable,
    reverse: Option<AccelTable>,
    limit_nm: f64,
    breakaway_nm: f64,
}

impl ExactMap {
    /// The exact map of a world: the fitted surface of an identified plant, the equation of a physical one on a fine grid.
    ///
    /// # Errors
    /// Settings that cannot be simulated.
    pub(crate) fn new(world: &WorldSettings) -> Result<Self> {
        let limit_nm = world.drive.torque_limit_nm.min(world.vehicle.torque_limit_nm.unwrap_or(f64::INFINITY));
        Ok(match &world.motion {
            MotionSettings::Identified(identified) => Self {
                forward: identified.forward.table.clone(),
                reverse: identified.reverse.as_ref().map(|d| d.table.clone()),
                limit_nm,
                breakaway_nm: identified.forward.breakaway_nm,
            },
            MotionSettings::Physical(physical) => {
                let truth = Truth::new(physical, &world.vehicle)?;
                let table = |gear| physical_table(&truth, gear, &world.vehicle, limit_nm);
                let breakaway_nm = truth.breakaway_nm(Gear::Forward, world.vehicle.test_angle_deg * RAD_PER_DEG);
                Self { forward: table(Gear::Forward)?, reverse: Some(table(Gear::Reverse)?), limit_nm, breakaway_nm }
            }
        })
    }

    /// a(v, τ) of `gear`.
    pub(crate) fn table(&self, gear: Gear) -> Option<&AccelTable> {
        match gear {
            Gear::Forward => Some(&self.forward),
            Gear::Reverse => self.reverse.as_ref(),
        }
    }

    /// Largest torque of the drive [N·m].
    pub(crate) fn limit_nm(&self) -> f64 {
        self.limit_nm
    }

    /// Torque that sets a resting wheel in motion [N·m], forward gear.
    pub(crate) fn breakaway_nm(&self) -> f64 {
        self.breakaway_nm
    }
}

impl TorqueFromAccel for ExactMap {
    fn torque(&self, gear: Gear, speed_mps: f64, accel_mps2: f64) -> Option<Lookup> {
        let (torque_nm, exact) = torque_for(self.table(gear)?, speed_mps, accel_mps2)?;
        let limited = torque_nm.clamp(-self.limit_nm, self.limit_nm);
        Some(Lookup { torque_nm: limited, outside: !exact || limited != torque_nm })
    }
}

/// Torque [N·m] at which `table`, monotone in torque, gives `accel_mps2` at `speed_mps` (clamped to the table), and whether it does so within
/// its torques. `None` for NaN.
pub(crate) fn torque_for(table: &AccelTable, speed_mps: f64, accel_mps2: f64) -> Option<(f64, bool)> {
    let torques = table.torque_nm().breaks();
    let at = |i: usize| table.accel_from_torque_clamped(speed_mps, torques[i]);
    let last = torques.len() - 1;
    if accel_mps2.is_nan() || at(0)? > accel_mps2 {
        return (!accel_mps2.is_nan()).then_some((torques[0], false));
    }
    if at(last)? < accel_mps2 {
        return Some((torques[last], false));
    }
    let (mut low, mut high) = (0, last);
    while high - low > 1 {
        let middle = low.midpoint(high);
        if at(middle)? <= accel_mps2 {
            low = middle;
        } else {
            high = middle;
        }
    }
    let (a, b) = (at(low)?, at(high)?);
    let fraction = if b > a { (accel_mps2 - a) / (b - a) } else { 0.0 };
    Some((torques[low] + fraction * (torques[high] - torques[low]), true))
}

/// Fastest speed of a physical plant's exact table [m/s]: more than twice the cruise speed.
const TABLE_SPEED_MPS: f64 = 1.5;

fn physical_table(truth: &Truth, gear: Gear, vehicle: &Vehicle, limit_nm: f64) -> Result<AccelTable> {
    let speed = Axis::uniform("speed_mps", 0.0, 0.01, TABLE_SPEED_MPS)?;
    // an even number of steps: 0 N·m, where driving turns into braking, is a break
    let torque = Axis::new("torque_nm", (-44..=44).map(|k| f64::from(k) / 44.0 * limit_nm).collect())?;
    let angle_rad = vehicle.test_angle_deg * RAD_PER_DEG;
    let values =
        torque.breaks().iter().flat_map(|&u| speed.breaks().iter().map(move |&v| truth.gear_accel_mps2(gear, v, u, angle_rad))).collect();
    Ok(AccelTable::new(speed, torque, values)?)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::sim::PhysicalSettings;

    #[test]
    fn the_inverse_of_the_exact_map_gives_the_acceleration_back() {
        let vehicle = Vehicle {
            wheelbase_m: 0.9,
            wheel_radius_m: 0.12,
            test_angle_deg: 90.0,
            torque_limit_nm: Some(44.0),
            torque_full_scale_nm: None,
        };
        let plant = ExactMap::new(&WorldSettings::physical(vehicle, PhysicalSettings::default())).unwrap();
        for gear in Gear::ALL {
            for (v, a) in [(0.0, 0.0), (0.013, 0.4), (0.3, -1.0), (0.6, 1.2)] {
                let found = plant.torque(gear, v, a).unwrap();
                let back = plant.table(gear).unwrap().accel_from_torque(v, found.torque_nm).unwrap();
                assert!((back - a).abs() < 1e-9 && !found.outside, "{gear} {v} {a}: {back}");
            }
            assert!(plant.torque(gear, 0.3, 99.0).unwrap().outside);
            assert!(plant.torque(gear, f64::NAN, 0.0).is_none() && plant.torque(gear, 0.0, f64::NAN).is_none());
        }
    }
}
