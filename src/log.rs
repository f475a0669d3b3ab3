//! MCAP logs of any writer into signals in SI.
//!
//! In: a log (ROS 2, ROS 1, protobuf or JSON; chunked or not, compressed or not, damaged or not) and a [`Source`] that says where the
//! signals are. Out: a [`Recording`], the signals with their origin, and an account of what was lost. Nothing that a log holds makes
//! this room panic, abort or take more memory than a few chunks.
//!
//! ```no_run
//! use pivot_cal::log::{Source, VehicleOverrides, read};
//! let recording = read("drive.mcap".as_ref(), &Source::Detect, &VehicleOverrides::default(), &|_| {})?;
//! println!("{} speeds, {} messages read", recording.signals.speed.len(), recording.loss.messages_read);
//! # Ok::<(), pivot_cal::log::Error>(())
//! ```

mod block;
mod bytes;
mod candidates;
mod channel_set;
mod column;
mod container;
mod convert;
mod detect;
mod error;
mod fields;
mod gather;
mod infer;
mod input;
mod inputs;
mod join;
mod loss;
mod lz4;
mod path;
mod plan;
mod polyline;
mod presets;
mod rate;
mod read;
mod record;
mod recording;
mod resolve;
mod scan;
mod schema;
mod series;
mod signal_map;
mod stamp;
mod summary;
mod survey;
mod vehicle;

pub use error::{Error, Result};
pub use fields::{FieldError, FieldReader};
pub use inputs::find_logs;
pub use join::read_split;
pub use loss::{Damage, Loss, Why};
pub use path::{Compare, Literal, MessagePath, Step, Test};
pub use plan::PlanError;
pub use polyline::ReferencePath;
pub use presets::Preset;
pub use rate::{Rate, rate};
pub use read::{read, read_bytes, read_lateral, read_lateral_bytes, read_signals};
pub use recording::{Origin, Recording, Signal, Signals};
pub use schema::SchemaError;
pub use signal_map::{Code, SignalMap, SignalName, SignalSpec, VehicleOverrides};
pub use survey::{Depth, Found, Missing, Survey, Topic, survey, survey_bytes};
pub use vehicle::VEHICLE_METADATA;

/// Where the signals of a log are.
#[derive(Debug, Clone, PartialEq)]
pub enum Source {
    /// As a signal map says; signals that it leaves out are not looked for.
    Map(SignalMap),
    /// As a preset says; signals that it leaves out are looked for.
    Preset(Preset),
    /// Looked for by type, name and unit.
    Detect,
}
