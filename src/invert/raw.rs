//! Table 2 in raw units: breaks at whole counts, torques at whole counts. What a controller stores in 16 bits is then the table itself, so
//! the round trip and the verdict count the rounding.

use crate::invert::breaks::accel_range_mps2;
use crate::invert::inverse::Inverse;
use crate::invert::{Error, Result};
use crate::map::{Gear, RawUnit, RawUnits};

/// Which raw units a table is to have.
#[derive(Debug, Clone, Copy, PartialEq, Default, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawSettings {
    /// Whether an axis without a given unit gets the finest decimal one that 16 bits hold. Default no: any number.
    #[serde(default)]
    pub int16: bool,
    /// Given units. Default none.
    #[serde(default, flatten)]
    pub units: RawUnits,
}

impl RawSettings {
    /// Whether the table has any number.
    pub fn is_none(&self) -> bool {
        *self == Self::default()
    }

    /// The units for tables up to a speed [m/s], an acceleration [m/s²] and a torque [N·m].
    ///
    /// # Errors
    /// A scale that is not above 0, an offset that is no number.
    pub(crate) fn units(&self, [fastest_mps, most_mps2, most_nm]: [f64; 3]) -> Result<RawUnits> {
        let given = [("speed", self.units.speed_mps), ("acceleration", self.units.accel_mps2), ("torque", self.units.torque_nm)];
        if let Some((axis, unit)) = given.into_iter().find_map(|(axis, unit)| Some((axis, unit.filter(|u| !u.is_valid())?))) {
            return Err(Error::RawUnit { axis, scale: unit.scale, offset: unit.offset });
        }
        let of = |unit: Option<RawUnit>, largest| unit.or_else(|| self.int16.then(|| RawUnit::finest(largest)));
        Ok(RawUnits {
            speed_mps: of(self.units.speed_mps, fastest_mps),
            accel_mps2: of(self.units.accel_mps2, most_mps2),
            torque_nm: of(self.units.torque_nm, most_nm),
        })
    }
}

/// Largest acceleration of a surface in either direction, over its speeds and torques [m/s²].
pub(crate) fn largest_accel_mps2(inverse: &Inverse, speeds: &[f64], tested_nm: [f64; 2]) -> f64 {
    // default breaks are rounded outward
    accel_range_mps2(inverse, speeds, tested_nm).into_iter().map(f64::abs).fold(0.0, f64::max) + 0.1
}

/// Breaks at the nearest whole counts, each once.
///
/// # Errors
/// A break that 16 bits do not hold; a unit so coarse that breaks fall together.
pub(crate) fn snapped(axis: &'static str, gear: Gear, breaks: &[f64], unit: Option<RawUnit>) -> Result<Vec<f64>> {
    let Some(unit) = unit else { return Ok(breaks.to_vec()) };
    let mut counts = breaks.iter().map(|b| count(axis, gear, *b, unit)).collect::<Result<Vec<i16>>>()?;
    counts.dedup();
    if counts.len() < breaks.len() {
        return Err(Error::RawTooCoarse { axis, gear, scale: unit.scale, breaks: breaks.len(), counts: counts.len() });
    }
    Ok(counts.into_iter().map(|raw| unit.value(raw)).collect())
}

/// A torque at the nearest whole count within ±`limit_nm`.
///
/// # Errors
/// A torque that 16 bits do not hold.
pub(crate) fn snapped_torque(gear: Gear, torque_nm: f64, limit_nm: f64, unit: RawUnit) -> Result<f64> {
    let raw = count("torque", gear, torque_nm, unit)?;
    let value = unit.value(raw);
    // to the nearest count may be to one beyond the limit
    let inward = if value > limit_nm {
        raw.checked_sub(1)
    } else if value < -limit_nm {
        raw.checked_add(1)
    } else {
        None
    };
    Ok(inward.map_or(value, |raw| unit.value(raw)))
}

fn count(axis: &'static str, gear: Gear, value: f64, unit: RawUnit) -> Result<i16> {
    let [low, high] = unit.range();
    unit.raw(value).ok_or(Error::RawRange { axis, gear, value, scale: unit.scale, offset: unit.offset, low, high })
}
