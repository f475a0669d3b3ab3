//! Errors of a log or a signal map. The caller adds the file name.

use crate::log::extractor_error::PlanError;
use crate::log::schema_error::SchemaError;
use crate::map;
use crate::units::{Dimension, UnknownUnit};

/// Result of this module.
pub(crate) type Result<T> = std::result::Result<T, Error>;

/// Error of a log or a signal map.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
#[allow(missing_docs)] // the message explains the fields
pub enum Error {
    #[error("the log cannot be read: {0}")]
    Io(std::io::Error),
    #[error("the log was changed while it was read: what was read is not what its hash would say; read it again when nothing writes to it")]
    Changed,
    #[error("the signals have more than {allowed} values, 32 bytes each while they are read; split the log, or record at a lower rate")]
    TooManyValues { allowed: u64 },
    #[error(
        "schemas, metadata and first messages of the log take more than {allowed} bytes; a log of a vehicle has less than a megabyte of them"
    )]
    TooMuchDescription { allowed: u64 },
    #[error("this is a folder, not a log; give the folder itself to read the logs in it")]
    Folder,
    #[error("the folder holds no log: no .mcap file, and no table in a .parquet, .csv or .tsv file")]
    NoLogs,
    #[error("no file matches {pattern:?}")]
    NoMatch { pattern: String },
    #[error("{pattern:?} is not a valid file pattern: {reason}")]
    BadPattern { pattern: String, reason: String },
    #[error("metadata.yaml names the file {file:?}, which is not in the folder")]
    MissingBagFile { file: String },
    #[error("the log is empty (0 bytes)")]
    Empty,
    #[error("this is not an MCAP log: {hint}")]
    NotMcap { hint: &'static str },
    #[error("this is a rosbag2 recording in SQLite, not MCAP; convert it with ROS 2, then read {converted}: {command}{without_ros}")]
    Sqlite { converted: String, command: String, without_ros: String },
    #[error("the table has no header: in line {line} there is {found:?}, where the names of the columns are expected")]
    NoHeader { line: u64, found: String },
    #[error("the table is in UTF-16; save it as UTF-8 (in a spreadsheet: CSV UTF-8)")]
    Utf16,
    #[error("line {line} is longer than {allowed} bytes: no table has such lines")]
    LongLine { line: u64, allowed: usize },
    #[error("the table has {found} columns; at most {allowed} are read: leave out those that are no signals")]
    TooManyColumns { found: usize, allowed: usize },
    #[error("the Parquet file cannot be used: {reason}")]
    BrokenParquet { reason: String },
    #[error(
        "no column holds the times: none is called time, t or timestamp; name it as `time` in [columns] of the signal map; the table has {}",
        columns.join(", ")
    )]
    NoTimeColumn { columns: Vec<String> },
    #[error(
        "the times in column {column:?} begin with {found:?}, which is neither a number nor a date of ISO 8601 such as 2024-05-01T10:00:00.5Z; name another column as `time` in [columns] of the signal map"
    )]
    BadTimeColumn { column: String, found: String },
    #[error("time_unit in [columns] is {found:?}; allowed are s, ms, us and ns")]
    TimeUnit { found: String },
    #[error("[columns] names one of `name` and `value`; a table with one value per row needs both, one with a column per signal neither")]
    HalfLong,
    #[error("[columns]: `{key}` names the column {column:?}, which the table does not have; it has {}", columns.join(", "))]
    NoSuchColumn { key: &'static str, column: String, columns: Vec<String> },
    #[error("{signal}: the table has no column {column:?}{}", list(", the nearest is", nearest, "; it has", columns))]
    NoColumn { signal: &'static str, column: String, nearest: Vec<String>, columns: Vec<String> },
    #[error("{signal}: {column:?} means the columns {first} and {second} of the table, which have one name; give each its own")]
    TwoColumns { signal: &'static str, column: String, first: usize, second: usize },
    #[error(
        "{signal}: column {column:?} is in {unit:?} by its header, which is no unit of {signal}; name another column, or give `unit`, and `scale`, which multiplies each value before"
    )]
    ColumnUnit { signal: &'static str, column: String, unit: String },
    #[error("the log holds no message{}", damage.as_ref().map(|text| format!(": {text}")).unwrap_or_default())]
    NoMessages { damage: Option<String> },
    #[error("path {path:?}, column {column}: {expected} is expected here")]
    BadPath { path: String, column: usize, expected: &'static str },
    #[error("the signal map is not valid TOML: {0}")]
    Toml(String),
    #[error("{place} has no key {found:?}; did you mean {nearest:?}? (known: {known})")]
    UnknownKey { found: String, place: String, nearest: &'static str, known: String },
    #[error(transparent)]
    Unit(#[from] UnknownUnit),
    #[error(
        "{signal} cannot be in {unit}, which is a unit of {dimension}. Give a unit of {signal}, and `scale`, which multiplies each value before: a torque in ampere of 2.2 N.m has unit = \"N.m\" and scale = 2.2"
    )]
    WrongDimension { signal: &'static str, unit: &'static str, dimension: Dimension },
    #[error("{signal}: {field} is {value}; it must be a finite number")]
    NotFinite { signal: &'static str, field: &'static str, value: f64 },
    #[error("{signal}: relative_to is {found:?}; a signal can only be relative to \"gear\"")]
    RelativeTo { signal: &'static str, found: String },
    #[error("preset {found:?} is not known; known presets: pivot-cal, verify-log, autoware, joint-state")]
    UnknownPreset { found: String },
    #[error("{signal}: there is no topic {topic:?}{}", list(", the nearest is", nearest, "; the log has", topics))]
    NoTopic { signal: &'static str, topic: String, nearest: Vec<String>, topics: Vec<String> },
    #[error("{signal}: path {path}: {source}")]
    Path { signal: &'static str, path: String, source: PlanError },
    #[error(
        "{signal}: stamp {stamp:?} leads to no time in the messages of {topic}{}; name one of its fields, or \"none\" for the log's own time",
        list("; the nearest is", nearest, "", &[])
    )]
    NoStamp { signal: &'static str, topic: String, stamp: String, nearest: Vec<String> },
    #[error("reference_x is {x} and reference_y {y}: both must be slices of one topic, as /path.poses[:].pose.position.x, or both numbers")]
    HalfPath { x: String, y: String },
    #[error("{signal}: topic {topic}: {source}")]
    Schema { signal: &'static str, topic: String, source: SchemaError },
    #[error(
        "no signal {signal} was found{}; name it in a signal map",
        list("; the nearest candidates are", candidates, "; the log has", topics)
    )]
    MissingSignal { signal: &'static str, candidates: Vec<String>, topics: Vec<String> },
    #[error("{signal}: {path} gives no value: of {messages} message(s), {reason}")]
    NoValues { signal: &'static str, path: String, messages: u64, reason: String },
    #[error("{missing} of the vehicle is not known: give it, or set {missing} in [vehicle] of the signal map")]
    MissingVehicle { missing: &'static str },
    #[error("the log's metadata pivot-cal/vehicle: {field} is {text:?}, not a number")]
    VehicleMetadata { field: &'static str, text: String },
    #[error(transparent)]
    Vehicle(#[from] map::Error),
}

fn list(first: &str, some: &[String], second: &str, others: &[String]) -> String {
    let part = |label: &str, names: &[String]| if names.is_empty() { String::new() } else { format!("{label} {}", names.join(", ")) };
    part(first, some) + &part(second, others)
}
