//! Why a map cannot be judged. A map that is judged and fails is a verdict, not an error.

use crate::map::{FolderError, Gear};
use crate::text::shown;
use std::path::PathBuf;

/// Result of this module.
pub(crate) type Result<T> = std::result::Result<T, Error>;

/// Why a map cannot be judged.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
#[allow(missing_docs)] // the message explains the fields
pub enum Error {
    #[error("{}: {source}", shown(path))]
    Read { path: PathBuf, source: std::io::Error },
    #[error("{}: {source}", shown(path))]
    File { path: PathBuf, source: crate::map::Error },
    #[error(
        "{} is not the file that {} describes (SHA-256 {found:.12}… instead of {expected:.12}…): it was edited, or belongs to another map; \
         invert Table 1 again",
        shown(path),
        shown(by)
    )]
    Hash { path: PathBuf, by: PathBuf, found: String, expected: String },
    #[error(
        "{} and {} are of different generations ({generations}): one of them was left by another run; run `pivot-cal invert` again, or continue with --force",
        shown(path),
        shown(by)
    )]
    Generation { path: PathBuf, by: PathBuf, generations: String },
    #[error("there is no {gear} map at {angle_deg}° in {table}; it has {found}")]
    NoMap { gear: Gear, angle_deg: f64, table: &'static str, found: String },
    #[error("there is no scenario {found:?}; the nearest is {nearest}")]
    NoScenario { found: String, nearest: String },
    #[error("there is no check {found:?} to accept; the checks of this table1.json are {known}")]
    NoCheck { found: String, known: String },
    #[error(
        "{log}: the signal desired_accel is missing{reason}: the acceleration of the front wheel that the controller asked for [m/s², forward \
         positive]. Name it in a signal map, `[signals]` with `desired_accel = {{ path = \"/topic.field\" }}`, and give it with --signals; a log \
         of `verify --log` needs no map"
    )]
    NoDesiredAccel { log: String, reason: String },
    #[error(
        "{log}: desired_accel has no sign (`unsigned`); a desired acceleration is positive forward, or with relative_to = \"gear\" in the gear's direction"
    )]
    UnsignedAccel { log: String },
    #[error(
        "{log}: no {needed_s} s in which the wheel moved at the test angle with a gear set and a desired acceleration no older than {age_s} s; \
         {driven_s:.1} s were driven, desired_accel has {values} value(s)"
    )]
    NoPivots { log: String, needed_s: f64, age_s: f64, driven_s: f64, values: usize },
    #[error("the gate cannot be read: {0}")]
    Gate(#[from] toml::de::Error),
    #[error("the gate's limit on {metric:?} has to have one of at_most and at_least, and a number there")]
    GateLimit { metric: String },
    #[error("the controller file: {0}")]
    Controller(#[from] crate::controller::Error),
    #[error(transparent)]
    Map(#[from] crate::map::Error),
    #[error("the plant cannot be simulated: {0}")]
    Sim(#[from] crate::sim::Error),
    #[error("the controller cannot be set up: {0}")]
    Control(#[from] crate::control::Error),
    #[error("the controller {command:?}: {fault}; allowed: a program and its arguments, and at least 1 ms for an answer")]
    ControllerCommand { command: String, fault: &'static str },
    #[error("{path} is no controller: {fault}")]
    ControllerLibrary { path: String, fault: String },
    #[error("{command} cannot be started: {source}; give a program and its arguments to --controller, as \"python3 my_controller.py\"")]
    ControllerStart { command: String, source: std::io::Error },
    #[error("the log of a run cannot be written: {0}")]
    Record(#[from] crate::record::Error),
    #[error("the verdict cannot be written as JSON: {0}")]
    Json(#[from] serde_json::Error),
}

impl From<FolderError> for Error {
    fn from(error: FolderError) -> Self {
        match error {
            FolderError::Read { path, source } => Self::Read { path, source },
            FolderError::File { path, source } => Self::File { path, source },
        }
    }
}
