//! Manoeuvres: their common parts, and the generators of parking and the U-turn. Each is a path of poses ([`PosePath`]) that is
//! driven by torque from a [`TorqueSource`]. Planning allocates and uses the standard library. It runs once, before the drive.

pub(crate) mod body;
mod error;
pub(crate) mod geometry;
pub(crate) mod look_ahead;
pub(crate) mod parking;
pub(crate) mod path;
pub(crate) mod reference;
pub(crate) mod route;
pub(crate) mod torque_source;
pub mod u_turn;

pub use body::BodyShape;
pub(crate) use error::{Error, Result};
pub use geometry::{PlanePoint, Polygon};
pub(crate) use path::{PathPose, PosePath};
