//! A vehicle's TOML file: geometry, drive, plant, steering, sensors.

use crate::map::{Vehicle, toml_text};
use crate::sim::drive::DriveSettings;
use crate::sim::error::{Error, Result};
use crate::sim::motion::MotionSettings;
use crate::sim::plant::PhysicalSettings;
use crate::sim::sensor_settings::SensorSettings;
use crate::sim::settings::{DEFAULT_STEP_S, WorldSettings};
use crate::sim::steering::SteeringSettings;
use crate::sim::truth::Truth;
use crate::sim::world::World;
use serde::{Deserialize, Serialize, de::DeserializeOwned};

/// A physical vehicle from its file. Missing sections have their defaults, except `[vehicle]`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct VehicleFile {
    /// Time step of the simulation [s]. Default 0.001.
    #[serde(default = "default_step_s")]
    pub step_s: f64,
    /// Geometry, test angle and torque limit.
    pub vehicle: Vehicle,
    /// The drive.
    #[serde(default)]
    pub drive: DriveSettings,
    /// The plant.
    #[serde(default)]
    pub motion: PhysicalSettings,
    /// The steering.
    #[serde(default)]
    pub steering: SteeringSettings,
    /// The sensors.
    #[serde(default)]
    pub sensors: SensorSettings,
}

fn default_step_s() -> f64 {
    DEFAULT_STEP_S
}

impl VehicleFile {
    /// Reads the TOML text and checks every number.
    ///
    /// # Errors
    /// The text is not TOML, a key is unknown (the nearest known key is given), or a value has another type or is out of its range.
    pub fn from_toml(text: &str) -> Result<Self> {
        let file: Self = from_toml(text)?;
        World::new(&file.settings(), 0)?;
        Ok(file)
    }

    /// The built-in scrubber.
    ///
    /// # Errors
    /// None in practice: the file is part of the program.
    pub fn bundled() -> Result<Self> {
        Self::from_toml(include_str!("../../data/vehicles/scrubber.toml"))
    }

    /// Settings of a world with this vehicle.
    pub fn settings(&self) -> WorldSettings {
        WorldSettings {
            step_s: self.step_s,
            vehicle: self.vehicle,
            drive: self.drive,
            motion: MotionSettings::Physical(self.motion),
            steering: self.steering,
            sensors: self.sensors,
        }
    }

    /// The exact map of this vehicle.
    ///
    /// # Errors
    /// A setting is out of its range.
    pub fn truth(&self) -> Result<Truth> {
        Truth::new(&self.motion, &self.vehicle)
    }
}

/// Reads TOML. An error gives the line, the found and the allowed values, and for a misspelt name the nearest one.
///
/// # Errors
/// The text is not valid TOML of this form.
pub(crate) fn from_toml<T: DeserializeOwned>(text: &str) -> Result<T> {
    toml_text(text).map_err(|fault| Error::Toml { line: fault.line, message: fault.message, nearest: fault.nearest })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    const SHORT: &str = "[vehicle]\nwheelbase_m = 0.9\nwheel_radius_m = 0.12\n";

    #[test]
    fn a_short_file_has_the_defaults() {
        let file = VehicleFile::from_toml(SHORT).unwrap();
        assert_eq!(file.motion, PhysicalSettings::default());
        assert_eq!(file.vehicle.test_angle_deg, 90.0);
        assert_eq!(file.settings().step_s, 1e-3);
    }

    #[test]
    fn a_misspelt_key_is_reported_with_its_line_and_the_nearest_key() {
        let error = VehicleFile::from_toml(&format!("{SHORT}[drive]\nlag_s = 0.05\ndeadtime_s = 0.05\n")).unwrap_err().to_string();
        assert!(error.starts_with("line 6: unknown field `deadtime_s`") && error.ends_with("did you mean `dead_time_s`?"), "{error}");
        let error = VehicleFile::from_toml(&format!("{SHORT}[sensors.gyroo]\n")).unwrap_err().to_string();
        assert!(error.ends_with("did you mean `gyro`?"), "{error}");
    }

    #[test]
    fn a_value_of_another_type_or_out_of_range_is_reported() {
        let error = VehicleFile::from_toml(&format!("{SHORT}[drive]\nlag_s = \"fast\"\n")).unwrap_err().to_string();
        assert!(error.starts_with("line 5: invalid type: string \"fast\", expected f64"), "{error}");
        let error = VehicleFile::from_toml(&format!("{SHORT}[drive]\nlag_s = -1\n")).unwrap_err().to_string();
        assert_eq!(error, "drive.lag_s is -1; allowed: 0 to 2");
    }
}
