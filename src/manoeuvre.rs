//! Manoeuvres in closed loop: the task ([`Manoeuvre`]), the torque source ([`ManoeuvreTorque`]) and the metrics.
//!
//! The plant is a physical vehicle, because the plant of a Table 1 covers one wheel angle only. A manoeuvre is data plus a driver. A new
//! one needs a [`ManoeuvreKind`] and its run; metrics, gate, draws and the closed loop are those of the pivots. The caller adds the
//! verdicts on manoeuvres to the verdict on the map.

mod bench;
mod compensation_run;
mod drive;
mod endings;
mod error;
mod judge;
mod lateral_metrics;
mod lateral_run;
mod legs_driver;
mod manoeuvre_log;
pub(crate) mod picture;
mod planned_run;
mod planned_task;
mod polyline_run;
mod run;
mod scenario;
mod settings;
mod torque;
mod traces;

pub use drive::ManoeuvreMoment;
pub(crate) use drive::Mounting;
pub(crate) use error::Result;
pub(crate) use judge::judge_manoeuvres;
pub(crate) use lateral_run::{CalibrationDrive, LoggedReference, lateral_log};
pub use polyline_run::{DEMO_POINTS, demo_points};
pub use run::replay_manoeuvre;
pub use scenario::{Manoeuvre, ManoeuvreKind};
pub use settings::ManoeuvreSettings;
pub(crate) use traces::{ErrorTrace, ManoeuvreTrace, ManoeuvreTraces, TracePiece};
