//! The simulator: one vehicle on its floor with a fixed time step, deterministic for a seed.
//!
//! In: [`WorldSettings`] (from a vehicle's TOML file, [`VehicleFile`], or from a fit, [`WorldSettings::identified`]) and a
//! [`WorldCommand`] per step. Out: the true state, [`TrueState`], and the sensor readings, [`Measurement`]. The parts are separate types:
//! drive, traction, motion (physical or identified), steering, body, sensors; [`World`] combines them. [`Truth`] is the physical plant's
//! exact map.
//!
//! All random numbers come from one seed through one stream per source ([`Stream`]), so that results do not depend on anything else.

mod drive;
mod error;
mod fault;
mod identified;
mod load;
mod motion;
mod physical;
mod plant;
mod pose;
mod random;
mod replay;
mod second_order;
mod sensor_settings;
mod sensor_timing;
mod sensors;
mod settings;
mod steering;
mod surface;
mod traction;
mod truth;
mod vehicle_file;
mod world;

pub use crate::map::Gear;
pub use drive::{Drive, DriveSettings, TorqueStep};
pub use error::{Error, Result};
pub use fault::Fault;
pub use identified::{GearSurface, IdentifiedMotion, IdentifiedSettings};
pub use load::Load;
pub use motion::{Motion, MotionSettings};
pub use physical::PhysicalMotion;
pub use plant::PhysicalSettings;
pub use pose::{Body, SpeedStep, WheelAngleTerms};
pub use random::{Random, RandomDisturbance, Stream};
pub use replay::{RecordedRun, Replay, replay};
pub use sensor_settings::{EncoderSettings, GyroSettings, PoseSettings, SensorSettings, SteeringAngleSettings, TorqueFeedbackSettings};
pub use sensor_timing::{Channel, KEPT, SensorReading, Timing};
pub use sensors::Sensors;
pub use settings::{DEFAULT_STEP_S, Perturbation, WorldSettings};
pub use steering::{AngleStep, Steering, SteeringSettings};
pub use traction::Traction;
pub use truth::Truth;
pub use vehicle_file::{VehicleFile, from_toml};
pub use world::{Measurement, TrueState, World, WorldCommand};
