//! The map's data of the vehicle.

use crate::map::{Error, Result, WheelAngle};
use serde::{Deserialize, Serialize};

/// Geometry of a vehicle with one steered, driven front wheel, and the wheel angle of its map.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Vehicle {
    /// Distance from the rear axle to the front wheel's centre [m].
    pub wheelbase_m: f64,
    /// Rolling radius of the front wheel [m], which turns wheel rotation into speed.
    pub wheel_radius_m: f64,
    /// Wheel angle of the test [°], left positive. Default 90.
    #[serde(default = "default_test_angle_deg")]
    pub test_angle_deg: f64,
    /// Largest torque that may be commanded [N·m]; without it the largest commanded in the logs.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub torque_limit_nm: Option<f64>,
    /// Torque that is 100 % of a torque signal [N·m], for signals in % and permille.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub torque_full_scale_nm: Option<f64>,
}

fn default_test_angle_deg() -> f64 {
    90.0
}

impl Vehicle {
    /// The wheel angle of the test.
    pub fn test_angle(&self) -> WheelAngle {
        WheelAngle::from_deg(self.test_angle_deg)
    }

    /// The torque limit [N·m], or without one the largest magnitude of `torques_nm`, which are the torques of a table.
    pub fn torque_limit_or_largest_nm(&self, torques_nm: impl IntoIterator<Item = f64>) -> f64 {
        self.torque_limit_nm.unwrap_or_else(|| torques_nm.into_iter().fold(0.0, |largest, torque| largest.max(torque.abs())))
    }

    /// Checks that every number is finite and possible.
    ///
    /// # Errors
    /// The first field that is not, with the allowed range.
    pub fn checked(self) -> Result<Self> {
        let check = |field, value: f64, allowed, good: bool| {
            if good { Ok(()) } else { Err(Error::BadVehicle { field, value, allowed }) }
        };
        check("wheelbase_m", self.wheelbase_m, "0.05 to 20", (0.05..=20.0).contains(&self.wheelbase_m))?;
        check("wheel_radius_m", self.wheel_radius_m, "0.005 to 2", (0.005..=2.0).contains(&self.wheel_radius_m))?;
        check("test_angle_deg", self.test_angle_deg, "-120 to 120", (-120.0..=120.0).contains(&self.test_angle_deg))?;
        if let Some(limit) = self.torque_limit_nm {
            check("torque_limit_nm", limit, "above 0 to 1e5", limit > 0.0 && limit <= 1e5)?;
        }
        if let Some(full) = self.torque_full_scale_nm {
            check("torque_full_scale_nm", full, "above 0 to 1e5", full > 0.0 && full <= 1e5)?;
        }
        Ok(self)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    const VEHICLE: Vehicle =
        Vehicle { wheelbase_m: 1.2, wheel_radius_m: 0.1, test_angle_deg: 90.0, torque_limit_nm: None, torque_full_scale_nm: None };

    #[test]
    fn without_a_limit_the_largest_torque_of_the_table_is_the_limit() {
        assert_eq!(VEHICLE.torque_limit_or_largest_nm([4.0, -30.0, 20.0]), 30.0);
        assert_eq!(Vehicle { torque_limit_nm: Some(25.0), ..VEHICLE }.torque_limit_or_largest_nm([4.0, -30.0]), 25.0);
    }

    #[test]
    fn a_number_that_no_vehicle_has_is_named() {
        VEHICLE.checked().unwrap();
        let message = |vehicle: Vehicle| vehicle.checked().unwrap_err().to_string();
        assert_eq!(message(Vehicle { wheelbase_m: 0.0, ..VEHICLE }), "wheelbase_m is 0; allowed: 0.05 to 20");
        assert_eq!(message(Vehicle { test_angle_deg: f64::NAN, ..VEHICLE }), "test_angle_deg is NaN; allowed: -120 to 120");
        assert_eq!(message(Vehicle { torque_limit_nm: Some(0.0), ..VEHICLE }), "torque_limit_nm is 0; allowed: above 0 to 1e5");
    }
}
