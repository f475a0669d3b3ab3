//! Settings of a world, and how they are varied.

use super::drive::DriveSettings;
use super::error::{Result, within};
use super::identified::IdentifiedSettings;
use super::motion::MotionSettings;
use super::physical::PhysicalSettings;
use super::sensors::SensorSettings;
use super::steering::SteeringSettings;
use crate::map::{Table1File, Vehicle};

/// Everything that makes a world, apart from the seed.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// Time step [s], 0.0001 to 0.02. Default 0.001.
    pub step_s: f64,
    /// Geometry. Its torque limit is what the controller may ask; the drive has its own.
    pub vehicle: Vehicle,
    /// The drive.
    pub drive: DriveSettings,
    /// The plant.
    pub motion: MotionSettings,
    /// The steering.
    pub steering: SteeringSettings,
    /// The sensors.
    pub sensors: SensorSettings,
}

/// Step of the simulation unless told otherwise [s].
pub const DEFAULT_STEP_S: f64 = 1e-3;

impl Settings {
    /// A physical vehicle with usual drive, steering and sensors.
    pub fn physical(vehicle: Vehicle, motion: PhysicalSettings) -> Self {
        Self {
            step_s: DEFAULT_STEP_S,
            vehicle,
            drive: DriveSettings::default(),
            motion: MotionSettings::Physical(motion),
            steering: SteeringSettings::default(),
            sensors: SensorSettings::default(),
        }
    }

    /// The vehicle behind a fit: its surface, dead time, lag, noise and run-to-run offset, limited to the vehicle's torque limit or, without
    /// one, to the largest torque of the surface.
    ///
    /// # Errors
    /// No forward map at the vehicle's test angle, or a table that is not sound.
    pub fn identified(file: &Table1File) -> Result<Self> {
        let motion = IdentifiedSettings::from_table1(file)?;
        let drive = DriveSettings {
            dead_time_s: file.actuator.dead_time.value_s.max(0.0),
            lag_s: file.actuator.lag.value_s.max(0.0),
            torque_limit_nm: file.vehicle.torque_limit_nm.unwrap_or_else(|| motion.largest_torque_nm()),
            ..DriveSettings::default()
        };
        drive.check()?;
        Ok(Self {
            step_s: DEFAULT_STEP_S,
            vehicle: file.vehicle,
            drive,
            motion: MotionSettings::Identified(Box::new(motion)),
            steering: SteeringSettings::default(),
            sensors: SensorSettings::identified(&file.noise),
        })
    }

    /// The same world with its plant, drive and noise varied.
    ///
    /// # Errors
    /// A factor that is not above 0 (noise: below 0), or not finite.
    pub fn perturbed(&self, by: &Perturbation) -> Result<Self> {
        by.check()?;
        let mut varied = self.clone();
        match &mut varied.motion {
            MotionSettings::Physical(p) => {
                for inertia in [&mut p.mass_kg, &mut p.yaw_inertia_kgm2, &mut p.wheel_inertia_kgm2] {
                    *inertia *= by.inertia_factor;
                }
                for friction in [&mut p.coulomb_nm, &mut p.static_nm, &mut p.scrub_nm, &mut p.viscous_nm_s_m, &mut p.quadratic_nm_s2_m2] {
                    *friction *= by.friction_factor;
                }
                p.disturbance_nm *= by.noise_factor;
                p.friction_spread *= by.noise_factor;
            }
            MotionSettings::Identified(p) => {
                if by.inertia_factor != 1.0 || by.friction_factor != 1.0 {
                    p.forward = p.forward.perturbed(by.inertia_factor, by.friction_factor);
                    p.reverse = p.reverse.as_ref().map(|d| d.perturbed(by.inertia_factor, by.friction_factor));
                }
                p.disturbance_mps2 *= by.noise_factor;
                p.run_offset_mps2 *= by.noise_factor;
            }
        }
        varied.drive.dead_time_s *= by.dead_time_factor;
        varied.drive.lag_s *= by.lag_factor;
        varied.drive.torque_limit_nm *= by.torque_limit_factor;
        varied.sensors = varied.sensors.with_noise_factor(by.noise_factor);
        Ok(varied)
    }

    pub(super) fn check(&self) -> Result<()> {
        within("step_s", self.step_s, 1e-4..=0.02, "0.0001 to 0.02")?;
        self.vehicle.checked()?;
        Ok(())
    }
}

/// Factors on a world; 1 leaves it as it is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Perturbation {
    /// On all inertia: a full tank, a load.
    pub inertia_factor: f64,
    /// On all friction, the breakaway torque included.
    pub friction_factor: f64,
    /// On the drive's time constant.
    pub lag_factor: f64,
    /// On the drive's dead time.
    pub dead_time_factor: f64,
    /// On every noise: disturbance, run-to-run spread, sensors; 0 for none.
    pub noise_factor: f64,
    /// On the drive's torque limit: a low battery.
    pub torque_limit_factor: f64,
}

impl Default for Perturbation {
    fn default() -> Self {
        Self {
            inertia_factor: 1.0,
            friction_factor: 1.0,
            lag_factor: 1.0,
            dead_time_factor: 1.0,
            noise_factor: 1.0,
            torque_limit_factor: 1.0,
        }
    }
}

impl Perturbation {
    fn check(&self) -> Result<()> {
        within("inertia_factor", self.inertia_factor, 0.01..=100.0, "0.01 to 100")?;
        within("friction_factor", self.friction_factor, 0.01..=100.0, "0.01 to 100")?;
        within("lag_factor", self.lag_factor, 0.01..=100.0, "0.01 to 100")?;
        within("dead_time_factor", self.dead_time_factor, 0.01..=100.0, "0.01 to 100")?;
        within("noise_factor", self.noise_factor, 0.0..=100.0, "0 to 100")?;
        within("torque_limit_factor", self.torque_limit_factor, 0.01..=100.0, "0.01 to 100")
    }
}
