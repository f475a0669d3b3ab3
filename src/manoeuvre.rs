//! Manoeuvres in closed loop: what is driven ([`Manoeuvre`]), by which torque, and what is measured of it.
//!
//! The plant is a physical vehicle, since the one that a Table 1 identifies knows one wheel angle only. A manoeuvre is data plus a driver: adding one
//! is a [`ManoeuvreKind`] with its run; metrics, gate, draws and the closed loop are those of the pivots. The verdicts on manoeuvres
//! are added to that on the map by whoever asks for both.

mod bench;
mod compensation_run;
mod drive;
mod error;
mod judge;
mod lateral_metrics;
mod lateral_run;
mod legs_driver;
mod manoeuvre_log;
pub mod picture;
mod planned_run;
mod planned_task;
mod polyline_run;
mod run;
mod scenario;
mod settings;
mod torque;
mod traces;

pub use compensation_run::CompensationScenario;
pub use drive::{ManoeuvreMoment, Mounting};
pub use error::{Error, Result};
pub use judge::{JudgedManoeuvres, judge_manoeuvres};
pub use lateral_run::{CalibrationDrive, LoggedReference, lateral_log};
pub use planned_task::{Planned, PlannedTask};
pub use polyline_run::DEMO_POINTS;
pub use run::replay_manoeuvre;
pub use scenario::{Manoeuvre, ManoeuvreKind};
pub use settings::ManoeuvreSettings;
pub use traces::{ErrorTrace, ManoeuvreTrace, ManoeuvreTraces, TracePiece};
