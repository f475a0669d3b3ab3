//! Manoeuvres in closed loop: what is driven ([`Manoeuvre`]), by which torque ([`ManoeuvreTorque`]), and what is measured of it.
//!
//! The plant is a physical vehicle, since the one that a Table 1 identifies knows one wheel angle only. A manoeuvre is data plus a driver: adding one
//! is a [`Kind`] with its run; metrics, gate, draws and logs are those of the pivots.

mod bench;
mod compensation;
mod drive;
mod judge;
mod lateral_run;
mod log;
pub mod picture;
mod planned;
mod polyline;
mod scenario;
mod torque;
mod traces;

pub use compensation::CompensationScenario;
pub use drive::{Moment as ManoeuvreMoment, Mounting, Start, drive};
pub(crate) use judge::judge;
pub use judge::{bundled_vehicle, replay as replay_manoeuvre};
pub use lateral_run::{LateralRun, LoggedReference, lateral_log, lateral_run};
pub use log::log_of as log_of_manoeuvre;
pub use planned::{Planned, PlannedTask, parking_scene, u_turn_scene};
pub use polyline::{DEMO_POINTS, LegResult, polyline_settings};
pub use scenario::{Kind, Manoeuvre};
pub use torque::{ExactTorque, ManoeuvreTorque};
pub use traces::{ErrorTrace, ManoeuvreTrace, ManoeuvreTraces, Piece, manoeuvre_traces};
