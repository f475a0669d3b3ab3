//! Reads MCAP logs of any writer, and tables of signals, as signals in SI units.
//!
//! In: a log (ROS 2, ROS 1, protobuf or JSON; chunked or not, compressed or not, damaged or not; or CSV or Parquet) and a [`Source`] with the
//! paths of the signals. Out: a [`Recording`] with the signals, their origin, and a report of the lost data. No content of a log can make this module
//! panic, abort or use more memory than a few chunks.
//!
//! ```no_run
//! use pivot_cal::log::{Source, VehicleOverrides, read};
//! let recording = read("drive.mcap".as_ref(), &Source::Detect, &VehicleOverrides::default(), &|_| {})?;
//! println!("{} speeds, {} messages read", recording.signals.speed.len(), recording.loss.messages_read);
//! # Ok::<(), pivot_cal::log::Error>(())
//! ```

pub(crate) mod columns;
mod error;
pub(crate) mod extract;
mod extractor_error;
pub(crate) mod file;
pub(crate) mod find;
pub(crate) mod find_logs;
pub(crate) mod limits;
mod loss;
pub(crate) mod message_kind;
pub(crate) mod path;
mod rate;
pub(crate) mod read;
mod recording;
mod reference_path;
mod rosbag2;
mod schema;
mod schema_error;
mod signal_map;
pub(crate) mod split_bag;
pub(crate) mod survey;
mod table_columns;
pub(crate) mod timing;
mod value;
mod value_range;
mod vehicle;

pub use error::Error;
pub(crate) use error::Result;
pub use find::presets::Preset;
pub(crate) use find_logs::find_logs;
pub(crate) use limits::MOST_VALUES;
pub use loss::{Damage, Loss, Why};
pub(crate) use message_kind::MessageKind;
pub use rate::Rate;
pub(crate) use rate::rate;
pub(crate) use read::read_lateral;
pub use read::{read, read_bytes};
pub use recording::{Origin, Recording, Signal, Signals};
pub(crate) use reference_path::ReferencePath;
pub use signal_map::{SignalMap, SignalName, VehicleOverrides};
pub(crate) use split_bag::read_split;
pub use survey::{Depth, FoundSignal, LogSurvey, Missing, Topic, survey};
pub use value_range::ValueRange;
pub(crate) use vehicle::SCENARIO_METADATA;

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
