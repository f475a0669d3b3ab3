//! The vehicle of a log, from the command line, the signal map, or the log's own metadata, in this order.

use crate::log::signal_map::VehicleOverrides;
use crate::log::{Error, Result};
use crate::map::Vehicle;
use std::collections::BTreeMap;

/// Name of the metadata record that `record` writes.
pub(crate) const VEHICLE_METADATA: &str = "pivot-cal/vehicle";
/// Name of the metadata record that `verify --log` writes.
pub(crate) const SCENARIO_METADATA: &str = "pivot-cal/scenario";

impl VehicleOverrides {
    /// These values, and those of `other` where they are missing.
    #[must_use]
    pub fn or(self, other: Self) -> Self {
        Self {
            wheelbase_m: self.wheelbase_m.or(other.wheelbase_m),
            wheel_radius_m: self.wheel_radius_m.or(other.wheel_radius_m),
            test_angle_deg: self.test_angle_deg.or(other.test_angle_deg),
            torque_limit_nm: self.torque_limit_nm.or(other.torque_limit_nm),
            torque_full_scale_nm: self.torque_full_scale_nm.or(other.torque_full_scale_nm),
        }
    }

    /// Whether no value is given.
    pub fn is_empty(self) -> bool {
        self == Self::default()
    }

    /// The vehicle. The default angle is 90°.
    ///
    /// # Errors
    /// A dimension is missing, with the ways to give it, or impossible.
    pub fn vehicle(self) -> Result<Vehicle> {
        let given = |value: Option<f64>, missing| value.ok_or(Error::MissingVehicle { missing });
        let vehicle = Vehicle {
            wheelbase_m: given(self.wheelbase_m, "wheelbase_m")?,
            wheel_radius_m: given(self.wheel_radius_m, "wheel_radius_m")?,
            test_angle_deg: self.test_angle_deg.unwrap_or(90.0),
            torque_limit_nm: self.torque_limit_nm,
            torque_full_scale_nm: self.torque_full_scale_nm,
        };
        Ok(vehicle.checked()?)
    }

    /// The vehicle in the metadata of a log.
    pub(crate) fn from_metadata(metadata: &BTreeMap<String, BTreeMap<String, String>>) -> Result<Self> {
        let Some(fields) = metadata.get(VEHICLE_METADATA) else {
            return Ok(Self::default());
        };
        let number = |field: &'static str| match fields.get(field) {
            None => Ok(None),
            Some(text) => text.trim().parse().map(Some).map_err(|_| Error::VehicleMetadata { field, text: text.clone() }),
        };
        Ok(Self {
            wheelbase_m: number("wheelbase_m")?,
            wheel_radius_m: number("wheel_radius_m")?,
            test_angle_deg: number("test_angle_deg")?,
            torque_limit_nm: number("torque_limit_nm")?,
            torque_full_scale_nm: number("torque_full_scale_nm")?,
        })
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn the_upper_source_wins_and_the_angle_has_a_default() {
        let upper = VehicleOverrides { wheelbase_m: Some(1.0), ..VehicleOverrides::default() };
        let lower = VehicleOverrides { wheelbase_m: Some(2.0), wheel_radius_m: Some(0.1), ..VehicleOverrides::default() };
        let vehicle = upper.or(lower).vehicle().unwrap();
        assert_eq!((vehicle.wheelbase_m, vehicle.wheel_radius_m, vehicle.test_angle_deg), (1.0, 0.1, 90.0));
        let error = upper.vehicle().unwrap_err().to_string();
        assert!(error.contains("wheel_radius_m") && error.contains("[vehicle]"), "{error}");
    }
}
