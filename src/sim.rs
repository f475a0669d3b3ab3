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

pub(crate) use crate::map::Gear;
pub(crate) use error::Error;
pub(crate) use fault::Fault;
pub use identified::{GearSurface, IdentifiedSettings};
pub use motion::MotionSettings;
pub use plant::PhysicalSettings;
pub(crate) use pose::WheelAngleTerms;
pub(crate) use random::{Random, Stream};
pub(crate) use replay::{RecordedRun, Replay, replay};
pub(crate) use sensor_timing::{Channel, SensorReading, Timing};
pub(crate) use settings::Perturbation;
pub use settings::WorldSettings;
pub use truth::Truth;
pub use vehicle_file::VehicleFile;
pub(crate) use vehicle_file::from_toml;
pub(crate) use world::{Measurement, TrueState};
pub use world::{World, WorldCommand};
