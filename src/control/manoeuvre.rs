//! Manoeuvres: what every one of them shares. Each is a path of poses ([`PosePath`]) that is driven by torque from a [`TorqueSource`].

pub mod path;
pub mod torque_source;
