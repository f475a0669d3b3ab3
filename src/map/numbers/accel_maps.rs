//! Table 1 over the wheel angle: the maps of a file with their common part, for look-ups at any angle.
//!
//! Between two measured angles both tables are looked up at the same torque. Each result is carried to the angle in between by inertia and
//! friction ([`AngleFamily`]), and the two are weighted by how near they are. At a measured angle the result is its table's.

use crate::map::angle_lookup::{Between, between};
use crate::map::{AccelTable, AngleFamily, Gear, SAME_ANGLE_DEG, Side};
use crate::units::RAD_PER_DEG;

/// An acceleration at a wheel angle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AccelAtAngle {
    /// Acceleration [m/s²], gear frame.
    pub accel_mps2: f64,
    /// Standard error [m/s²]: at a measured angle its table's; between two, that of both as if fully correlated, and the family's error,
    /// largest half way.
    pub std_err_mps2: f64,
    /// Whether the angle lies beyond all measured ones of its side, so that the nearest one was used.
    pub beyond_angles: bool,
}

/// Table 1 at every wheel angle.
#[derive(Debug, Clone)]
pub struct AccelMaps {
    maps: Vec<AngleSurface>,
    families: Vec<AngleFamily>,
}

/// Table 1 of one gear at one wheel angle.
#[derive(Debug, Clone)]
pub(crate) struct AngleSurface {
    /// Gear.
    pub gear: Gear,
    /// Wheel angle [°], left positive.
    pub wheel_angle_deg: f64,
    /// Acceleration [m/s²], on the fine grid.
    pub surface: AccelTable,
    /// Its standard error [m/s²], on the grid of the table.
    pub std_err: AccelTable,
}

impl AccelMaps {
    /// From the surface of every gear and angle, and the families of each gear and side.
    pub(crate) fn from_surfaces(maps: Vec<AngleSurface>, families: Vec<AngleFamily>) -> Self {
        Self { maps, families }
    }

    /// Acceleration under a torque at a wheel angle [°]; `None` outside the measured angles of its side and outside a table, and without a
    /// map of the gear.
    pub fn accel(&self, gear: Gear, speed_mps: f64, torque_nm: f64, wheel_angle_deg: f64) -> Option<AccelAtAngle> {
        let (place, side) = self.place(gear, wheel_angle_deg)?;
        let found = self.at(&place, side, gear, (speed_mps, torque_nm, wheel_angle_deg), AccelTable::accel_from_torque)?;
        (!found.beyond_angles).then_some(found)
    }

    /// The same with speed, torque and angle clamped to the measured range; `None` for NaN, and without a map of the gear at this side.
    pub fn accel_clamped(&self, gear: Gear, speed_mps: f64, torque_nm: f64, wheel_angle_deg: f64) -> Option<AccelAtAngle> {
        let (place, side) = self.place(gear, wheel_angle_deg)?;
        self.at(&place, side, gear, (speed_mps, torque_nm, wheel_angle_deg), AccelTable::accel_from_torque_clamped)
    }

    /// The position of an angle among those of its gear and side.
    fn place(&self, gear: Gear, angle_deg: f64) -> Option<(Between, Side)> {
        let side = if angle_deg < 0.0 { Side::Right } else { Side::Left };
        let own = self.maps.iter().enumerate().filter(|(_, m)| m.gear == gear && side.holds(m.wheel_angle_deg));
        Some((between(own.map(|(k, m)| (k, m.wheel_angle_deg)), angle_deg, SAME_ANGLE_DEG)?, side))
    }

    fn at(
        &self,
        place: &Between,
        side: Side,
        gear: Gear,
        (speed_mps, torque_nm, angle_deg): (f64, f64, f64),
        read: impl Fn(&AccelTable, f64, f64) -> Option<f64>,
    ) -> Option<AccelAtAngle> {
        let family = self.families.iter().find(|f| f.gear == gear && f.side == side);
        // at the edge, within the tolerance or beyond, the nearest table is used as it is
        let alone = place.below == place.above;
        let here = (angle_deg * RAD_PER_DEG).sin();
        let carried = |k: usize| -> Option<(f64, f64)> {
            let map = &self.maps[k];
            let accel = read(&map.surface, speed_mps, torque_nm)?;
            let error = map.std_err.accel_from_torque_clamped(speed_mps, torque_nm)?;
            match family.filter(|_| !alone) {
                Some(family) => {
                    let (terms, there) = (family.terms(), (map.wheel_angle_deg * RAD_PER_DEG).sin());
                    let scale = terms.inertia(there) / terms.inertia(here);
                    Some((terms.accel_elsewhere_mps2(speed_mps, accel, there, here), error * scale))
                }
                None => Some((accel, error)),
            }
        };
        let (low, high) = (carried(place.below)?, carried(place.above)?);
        let mix = |low: f64, high: f64| (1.0 - place.share) * low + place.share * high;
        let departure = family.map_or(0.0, |f| 2.0 * (place.share * (1.0 - place.share)).sqrt() * f.departure_nm / f.terms().inertia(here));
        Some(AccelAtAngle {
            accel_mps2: mix(low.0, high.0),
            std_err_mps2: mix(low.1, high.1).hypot(departure),
            beyond_angles: place.outside,
        })
    }
}
