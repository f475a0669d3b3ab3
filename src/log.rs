//! Reads MCAP logs of any writer as signals in SI units.
//!
//! In: a log (ROS 2, ROS 1, protobuf or JSON; chunked or not, compressed or not, damaged or not) and a [`Source`] with the paths of the
//! signals. Out: a [`Recording`] with the signals, their origin, and a report of the lost data. No content of a log can make this module
//! panic, abort or use more memory than a few chunks.
//!
//! ```no_run
//! use pivot_cal::log::{Source, VehicleOverrides, read};
//! let recording = read("drive.mcap".as_ref(), &Source::Detect, &VehicleOverrides::default(), &|_| {})?;
//! println!("{} speeds, {} messages read", recording.signals.speed.len(), recording.loss.messages_read);
//! # Ok::<(), pivot_cal::log::Error>(())
//! ```

mod error;
pub(crate) mod extract;
mod extractor_error;
pub(crate) mod file;
pub(crate) mod find;
mod find_logs;
mod loss;
mod message_kind;
mod path;
mod rate;
mod read;
mod recording;
mod reference_path;
mod schema;
mod schema_error;
mod signal_map;
mod split_bag;
mod survey;
pub(crate) mod timing;
mod value;
mod vehicle;

pub use error::{Error, Result};
pub use extract::fields::{FieldError, FieldReader};
pub use extractor_error::PlanError;
pub use find::presets::Preset;
pub use find_logs::find_logs;
pub use loss::{Damage, Loss, Why};
pub use message_kind::MessageKind;
pub use path::{Compare, Literal, MessagePath, PathStep, Test};
pub use rate::{Rate, rate};
pub use read::{read, read_bytes, read_lateral, read_lateral_bytes, read_signals};
pub use recording::{Origin, Recording, Signal, Signals};
pub use reference_path::ReferencePath;
pub use schema_error::SchemaError;
pub use signal_map::{Code, SignalMap, SignalName, SignalSpec, Stamp, VehicleOverrides};
pub use split_bag::read_split;
pub use survey::{Depth, FoundSignal, LogSurvey, Missing, Topic, survey, survey_bytes};
pub use vehicle::VEHICLE_METADATA;

/// Where the signals of a log are.
#[derive(Debug, Clone, PartialEq)]
pub enum Source {
    /// A signal map gives the paths; signals that it omits are not searched for.
    Map(SignalMap),
    /// A preset gives the paths; signals that it omits are searched for.
    Preset(Preset),
    /// Searched for by type, name and unit.
    Detect,
}
