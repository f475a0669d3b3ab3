//! Settings of a world, and their variations.

use crate::map::{Table1File, Vehicle};
use crate::sim::drive::DriveSettings;
use crate::sim::error::{Result, within};
use crate::sim::identified::IdentifiedSettings;
use crate::sim::motion::MotionSettings;
use crate::sim::plant::PhysicalSettings;
use crate::sim::sensor_settings::SensorSettings;
use crate::sim::steering::SteeringSettings;

/// All settings of a world, except the seed.
#[derive(Debug, Clone, PartialEq)]
pub struct WorldSettings {
    /// Time step [s], 0.0001 to 0.02. Default 0.001.
    pub step_s: f64,
    /// Geometry. Its torque limit applies to the controller; the drive has its own.
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

/// Default step of the simulation [s].
pub(crate) const DEFAULT_STEP_S: f64 = 1e-3;

impl WorldSettings {
    /// A physical vehicle with typical drive, steering and sensors.
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

    /// The vehicle of a fit: its surface, dead time, lag, noise and run-to-run offset. Torque is limited to the vehicle's torque limit or,
    /// without one, to the largest torque of the surface.
    ///
    /// # Errors
    /// There is no forward map at the vehicle's test angle, or a table is not valid.
    pub fn identified(file: &Table1File) -> Result<Self> {
        let motion = IdentifiedSettings::from_table1(file)?;
        let drive = DriveSettings {
            dead_time_s: file.actuator.dead_time.value_s.max(0.0),
            lag_s: file.actuator.lag.value_s.max(0.0),
            torque_limit_nm: file.vehicle.torque_limit_or_largest_nm([motion.largest_torque_nm()]),
            ..DriveSettings::default()
        }
        .as_found(file.actuator.drive.as_ref());
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

    /// The same world with what a vehicle file gives of it beside its motion: steering, sensors, and of the drive what torque steps hardly
    /// show. The plant keeps the speed noise that the fit found if it is larger.
    #[must_use]
    pub fn with_given(&self, given: &Self) -> Self {
        let mut world =
            Self { drive: self.drive.with_given(&given.drive), steering: given.steering, sensors: given.sensors, ..self.clone() };
        world.sensors.encoder.noise_mps = world.sensors.encoder.noise_mps.max(self.sensors.encoder.noise_mps);
        world.sensors.encoder.step_mps = world.sensors.encoder.step_mps.max(self.sensors.encoder.step_mps);
        world
    }

    /// The same world with its plant, drive and noise varied.
    ///
    /// # Errors
    /// A factor is not above 0 (noise: below 0) or not finite.
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

    /// Step of the encoder's speed readings [m/s]; 0 for none.
    pub(crate) fn speed_step_mps(&self) -> f64 {
        let encoder = &self.sensors.encoder;
        if encoder.counts_per_rev == 0 {
            return encoder.step_mps;
        }
        std::f64::consts::TAU * self.vehicle.wheel_radius_m * encoder.timing.rate_hz / f64::from(encoder.counts_per_rev)
    }

    pub(crate) fn check(&self) -> Result<()> {
        within("step_s", self.step_s, 1e-4..=0.02, "0.0001 to 0.02")?;
        self.vehicle.checked()?;
        Ok(())
    }
}

/// Factors on a world; 1 changes nothing.
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

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::map::{
        AccelMap, Actuator, ActuatorInput, BreakawayTorque, CsvRef, DelayEstimate, DelayStatus, FineSurface, Gear, PlantNoise, Table1File,
    };
    use crate::sim::{World, WorldCommand};
    use std::f64::consts::FRAC_PI_2;

    /// A fit with a = (τ − 8)/13 forward and no reverse table.
    fn fit() -> Table1File {
        let delay = |value_s| DelayEstimate { value_s, std_err_s: None, status: DelayStatus::Given };
        let (speed_mps, torque_nm) = (vec![0.0, 1.0], vec![-40.0, 40.0]);
        let accel_mps2: Vec<Vec<f64>> = torque_nm.iter().map(|u| vec![(u - 8.0) / 13.0; 2]).collect();
        let csv = CsvRef { file: "table1.csv".into(), sha256: String::new() };
        let map = AccelMap {
            gear: Gear::Forward,
            wheel_angle_deg: 90.0,
            csv,
            speed_mps: speed_mps.clone(),
            torque_nm: torque_nm.clone(),
            accel_mps2: accel_mps2.clone(),
            std_err_mps2: Vec::new(),
            count: Vec::new(),
            confidence: Vec::new(),
            status: Vec::new(),
            measured_torque_nm: Vec::new(),
            breakaway: BreakawayTorque { torque_nm: 8.0, std_err_nm: None, at_rest_up_to_nm: None, moved_from_nm: None },
            surface: FineSurface { speed_mps, torque_nm, accel_mps2 },
        };
        Table1File {
            format: crate::map::TABLE1_FORMAT.into(),
            format_version: crate::map::FORMAT_VERSION,
            tool_version: String::new(),
            generation: String::new(),
            units: crate::map::Units::default(),
            vehicle: Vehicle {
                wheelbase_m: 0.9,
                wheel_radius_m: 0.12,
                test_angle_deg: 90.0,
                torque_limit_nm: None,
                torque_full_scale_nm: None,
            },
            torque_limit_driven: true,
            logs: Vec::new(),
            settings: serde_json::Value::Null,
            actuator: Actuator {
                dead_time: delay(0.05),
                lag: delay(0.05),
                input: ActuatorInput::COMMAND,
                drive: None,
                changes: Vec::new(),
                per_log: Vec::new(),
            },
            witnesses: Vec::new(),
            noise: PlantNoise {
                disturbance_mps2: 0.0,
                disturbance_time_s: 0.2,
                run_offset_mps2: 0.0,
                speed_noise_mps: 0.004,
                speed_step_mps: 0.0,
            },
            maps: vec![map],
            families: Vec::new(),
            checks: Vec::new(),
            report: crate::map::Stage1Report::default(),
        }
    }

    fn speed_after_one_second(settings: &WorldSettings, gear: Gear) -> f64 {
        let mut world = World::new(&WorldSettings { sensors: SensorSettings::ideal(), ..settings.clone() }, 1).unwrap();
        world.place_wheel(FRAC_PI_2);
        for _ in 0..1000 {
            world.step(&WorldCommand { torque_nm: gear.sign() * 21.0, wheel_angle_rad: FRAC_PI_2, gear: Some(gear) });
        }
        world.state().speed_mps
    }

    #[test]
    fn the_identified_plant_moves_like_the_fit_after_its_dead_time_and_lag() {
        let settings = WorldSettings::identified(&fit()).unwrap();
        assert_eq!((settings.drive.torque_limit_nm, settings.sensors.encoder.noise_mps), (40.0, 0.004));
        // u = 21·(1 − exp(−t/T)) passes 8 N·m at t_b; after that v = ∫ (u − 8)/13 dt, with t from the end of the dead time
        let (lag, end) = (0.05, 0.95_f64);
        let t_b = -lag * (1.0_f64 - 8.0 / 21.0).ln();
        let rest = |t: f64| 21.0 * lag * (-t / lag).exp();
        let expected = (13.0 * (end - t_b) + rest(end) - rest(t_b)) / 13.0;
        let found = speed_after_one_second(&settings, Gear::Forward);
        // it starts at the first step after t_b: at most 1 ms of almost no torque
        assert!((found - expected).abs() < 1e-4, "{found} for {expected}");
    }

    #[test]
    fn without_a_reverse_table_reverse_mirrors_forward() {
        let settings = WorldSettings::identified(&fit()).unwrap();
        assert_eq!(speed_after_one_second(&settings, Gear::Reverse), -speed_after_one_second(&settings, Gear::Forward));
    }

    #[test]
    fn perturbations_change_the_named_quantities() {
        let settings = WorldSettings::identified(&fit()).unwrap();
        let by = Perturbation { inertia_factor: 2.0, friction_factor: 0.5, torque_limit_factor: 0.8, ..Perturbation::default() };
        let varied = settings.perturbed(&by).unwrap();
        assert_eq!(varied.drive.torque_limit_nm, 32.0);
        let found = speed_after_one_second(&varied, Gear::Forward);
        // (21 − 4)/26 for about 0.9 s
        assert!((0.5..0.6).contains(&found), "{found}");
        assert!(settings.perturbed(&Perturbation { lag_factor: 0.0, ..Perturbation::default() }).is_err());
    }

    #[test]
    fn a_fit_without_a_forward_map_is_refused() {
        let mut file = fit();
        file.maps[0].gear = Gear::Reverse;
        assert!(WorldSettings::identified(&file).unwrap_err().to_string().contains("forward gear at 90°"));
    }
}
