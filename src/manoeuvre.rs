//! Manoeuvres in closed loop: the task ([`Manoeuvre`]), the torque source ([`ManoeuvreTorque`]) and the metrics.
//!
//! The plant is a physical vehicle, because the plant of a Table 1 covers one wheel angle only. A manoeuvre is data plus a driver. A new
//! one needs a [`ManoeuvreKind`] and its run; metrics, gate, draws and the closed loop are those of the pivots. The caller adds the
//! verdicts on manoeuvres to the verdict on the map.

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
