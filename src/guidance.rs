//! Manoeuvres: their common parts, and the generators of parking and the U-turn. Each is a path of poses ([`PosePath`]) that is
//! driven by torque from a [`TorqueSource`]. Planning allocates and uses the standard library. It runs once, before the drive.

pub mod body;
mod error;
pub mod geometry;
pub mod look_ahead;
pub mod parking;
pub mod path;
pub mod reference;
pub mod route;
pub mod torque_source;
pub mod u_turn;

pub use body::BodyShape;
pub use error::{Error, Result};
pub use geometry::{PlanePoint, Polygon};
pub use path::{PathPose, PosePath};
pub use torque_source::TorqueSource;
