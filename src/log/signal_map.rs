//! The signal map: the message path and the unit of each signal. Read from `signals.toml`.

use crate::log::path::{MessagePath, PathStep};
use crate::log::table_columns::TableColumns;
use crate::log::{Error, Result};
use crate::spelling::edits;
use crate::text::name_from_outside;
use crate::units::{Dimension, Unit};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fmt;

/// The signals of the calibration.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum SignalName {
    /// Speed of the front wheel's rim, from its encoder.
    Speed,
    /// Commanded torque.
    Torque,
    /// Torque reported by the drive.
    TorqueFeedback,
    /// Angle of the front wheel, left positive.
    Angle,
    /// Rate of the vehicle's heading, left positive.
    YawRate,
    /// Gear engaged.
    Gear,
    /// Emergency stop.
    Estop,
    /// x of the rear axle's middle, from the navigation.
    PoseX,
    /// y of the same.
    PoseY,
    /// The vehicle's heading from the navigation, counter-clockwise.
    Yaw,
    /// z of the heading's quaternion, instead of `yaw`.
    YawZ,
    /// w of the heading's quaternion.
    YawW,
    /// x of the matched point on the reference path.
    ReferenceX,
    /// y of the same.
    ReferenceY,
    /// Compensation angle in force, left positive.
    Compensation,
    /// Acceleration of the front wheel that a controller asks for, forward positive.
    DesiredAccel,
}

impl SignalName {
    /// The signals of the lateral calibration, in display order. A map or a preset names them; they are never searched for.
    pub const LATERAL: [Self; 8] =
        [Self::PoseX, Self::PoseY, Self::Yaw, Self::YawZ, Self::YawW, Self::ReferenceX, Self::ReferenceY, Self::Compensation];

    /// Every signal of the torque map's calibration, in display order.
    pub const ALL: [Self; 7] = [Self::Speed, Self::Torque, Self::TorqueFeedback, Self::Angle, Self::YawRate, Self::Gear, Self::Estop];

    /// The signals of pivots in operation: those of the calibration, and the desired acceleration, which a map or a preset names.
    pub(crate) const OPERATION: [Self; 8] =
        [Self::Speed, Self::Torque, Self::TorqueFeedback, Self::Angle, Self::YawRate, Self::Gear, Self::Estop, Self::DesiredAccel];

    /// The key in a signal map.
    pub fn key(self) -> &'static str {
        match self {
            Self::Speed => "speed",
            Self::Torque => "torque",
            Self::TorqueFeedback => "torque_feedback",
            Self::Angle => "angle",
            Self::YawRate => "yaw_rate",
            Self::Gear => "gear",
            Self::Estop => "estop",
            Self::PoseX => "pose_x",
            Self::PoseY => "pose_y",
            Self::Yaw => "yaw",
            Self::YawZ => "yaw_z",
            Self::YawW => "yaw_w",
            Self::ReferenceX => "reference_x",
            Self::ReferenceY => "reference_y",
            Self::Compensation => "compensation",
            Self::DesiredAccel => "desired_accel",
        }
    }

    /// Whether a log must have it to be usable.
    pub fn is_required(self) -> bool {
        use SignalName::{Angle, PoseX, PoseY, ReferenceX, ReferenceY, Speed, Torque};
        matches!(self, Speed | Torque | Angle | PoseX | PoseY | ReferenceX | ReferenceY)
    }

    /// Unit if the map names none: SI.
    pub fn default_unit(self) -> &'static str {
        match self {
            Self::Speed => "m/s",
            Self::Torque | Self::TorqueFeedback => "N.m",
            Self::Angle | Self::Yaw | Self::Compensation => "rad",
            Self::YawRate => "rad/s",
            Self::DesiredAccel => "m/s²",
            Self::Gear | Self::Estop | Self::YawZ | Self::YawW => "1",
            Self::PoseX | Self::PoseY | Self::ReferenceX | Self::ReferenceY => "m",
        }
    }

    /// Whether the signal can be in a unit of this dimension.
    pub(crate) fn accepts(self, dimension: Dimension) -> bool {
        match self {
            Self::Speed => matches!(dimension, Dimension::Speed | Dimension::AngularSpeed),
            Self::Torque | Self::TorqueFeedback => matches!(dimension, Dimension::Torque | Dimension::Share),
            Self::Angle | Self::Yaw | Self::Compensation => dimension == Dimension::Angle,
            Self::YawRate => dimension == Dimension::AngularSpeed,
            Self::DesiredAccel => dimension == Dimension::Acceleration,
            Self::Gear | Self::Estop | Self::YawZ | Self::YawW => dimension == Dimension::Number,
            Self::PoseX | Self::PoseY | Self::ReferenceX | Self::ReferenceY => dimension == Dimension::Length,
        }
    }
}

impl fmt::Display for SignalName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.key())
    }
}

/// The path of each signal, and the known dimensions of the vehicle.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct SignalMap {
    /// The vehicle data of the map.
    pub vehicle: VehicleOverrides,
    /// The columns of a table that are no signals: time, and of a table in long form name and value.
    pub(crate) columns: TableColumns,
    /// The signals.
    pub(crate) signals: BTreeMap<SignalName, SignalSpec>,
}

/// Vehicle data from outside the log; each field overrides that of a lower source.
#[derive(Debug, Clone, Copy, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct VehicleOverrides {
    /// Wheelbase [m].
    pub wheelbase_m: Option<f64>,
    /// Rolling radius of the front wheel [m].
    pub wheel_radius_m: Option<f64>,
    /// Wheel angle of the test [°], left positive.
    pub test_angle_deg: Option<f64>,
    /// Largest torque that may be commanded [N·m].
    pub torque_limit_nm: Option<f64>,
    /// Torque that is 100 % of a torque signal [N·m].
    pub torque_full_scale_nm: Option<f64>,
}

/// Path of a signal and conversion of its values: SI = unit(scale · raw + offset).
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct SignalSpec {
    /// The message path.
    pub path: MessagePath,
    /// Unit of the value; SI by default.
    pub unit: Unit,
    /// Whether the unit was given; otherwise the header of a table's column may give another.
    pub is_unit_given: bool,
    /// Multiplies the raw value. Default 1.
    pub scale: f64,
    /// Added after scaling, in `unit`. Default 0.
    pub offset: f64,
    /// Where the time of a value is. By default the message's stamp.
    pub stamp: Stamp,
    /// Positive means in the gear's direction: negated in reverse.
    pub relative_to_gear: bool,
    /// A magnitude: its sign comes from other signals.
    pub unsigned: bool,
    /// Meaning of a gear's values; by name and the usual numbers if empty.
    pub codes: Vec<(Code, f64)>,
}

/// Where the time of a value is.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) enum Stamp {
    /// In the usual field of the message (`header.stamp`, `stamp` or `header.timestamp`) if it has one; otherwise the time of the log.
    #[default]
    Usual,
    /// The time of the log, whatever the message holds: `stamp = "none"`.
    None,
    /// In this field of the message.
    At(Vec<PathStep>),
}

/// A value that means a gear.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(untagged)]
pub(crate) enum Code {
    /// A number.
    Number(f64),
    /// A string, or the name of a number in the schema.
    Text(String),
}

impl SignalSpec {
    /// A signal at `path` in `unit`, with defaults for the other fields.
    pub(crate) fn new(path: MessagePath, unit: Unit) -> Self {
        let (scale, offset, stamp) = (1.0, 0.0, Stamp::Usual);
        Self { path, unit, is_unit_given: false, scale, offset, stamp, relative_to_gear: false, unsigned: false, codes: Vec::new() }
    }
}

/// One line of the `[signals]` table.
#[derive(Debug, Deserialize)]
struct SignalEntry {
    path: String,
    unit: Option<String>,
    scale: Option<f64>,
    offset: Option<f64>,
    stamp: Option<String>,
    relative_to: Option<String>,
    #[serde(default)]
    unsigned: bool,
    neutral: Option<OneOrMany>,
    forward: Option<OneOrMany>,
    reverse: Option<OneOrMany>,
}

#[derive(Debug, Deserialize)]
#[serde(untagged)]
enum OneOrMany {
    One(Code),
    Many(Vec<Code>),
}

const VEHICLE_KEYS: [&str; 5] = ["wheelbase_m", "wheel_radius_m", "test_angle_deg", "torque_limit_nm", "torque_full_scale_nm"];
const ENTRY_KEYS: [&str; 10] = ["path", "unit", "scale", "offset", "stamp", "relative_to", "unsigned", "neutral", "forward", "reverse"];

impl SignalMap {
    /// Reads a signal map from the text of a `signals.toml`.
    ///
    /// # Errors
    /// The TOML cannot be read, a key is not known (the nearest known key is given), or a path or unit is wrong.
    ///
    /// ```
    /// pivot_cal::log::SignalMap::from_toml("[signals]\nspeed = { path = '/wheel.v', unit = 'km/h' }")?;
    /// assert!(pivot_cal::log::SignalMap::from_toml("[signals]\nsped = { path = '/wheel.v' }").is_err());
    /// # Ok::<(), pivot_cal::log::Error>(())
    /// ```
    pub fn from_toml(text: &str) -> Result<Self> {
        let table: toml::Table = text.parse().map_err(|error: toml::de::Error| Error::Toml(error.to_string()))?;
        let mut map = Self::default();
        for (key, value) in table {
            match key.as_str() {
                "vehicle" => {
                    known_keys(&value, "[vehicle]", &VEHICLE_KEYS)?;
                    map.vehicle = value.try_into().map_err(|error| Error::Toml(format!("[vehicle]: {error}")))?;
                }
                "columns" => {
                    known_keys(&value, "[columns]", &TableColumns::KEYS)?;
                    map.columns = value.try_into().map_err(|error| Error::Toml(format!("[columns]: {error}")))?;
                    map.columns.time_scale()?;
                }
                "signals" => {
                    let names: Vec<SignalName> = SignalName::OPERATION.into_iter().chain(SignalName::LATERAL).collect();
                    let keys: Vec<&'static str> = names.iter().map(|name| name.key()).collect();
                    known_keys(&value, "[signals]", &keys)?;
                    let toml::Value::Table(signals) = value else {
                        return Err(Error::Toml("[signals] must be a table".into()));
                    };
                    for (key, value) in signals {
                        if let Some(&name) = names.iter().find(|name| name.key() == key) {
                            known_keys(&value, &key, &ENTRY_KEYS)?;
                            let entry: SignalEntry = value.try_into().map_err(|error| Error::Toml(format!("{key}: {error}")))?;
                            map.signals.insert(name, entry.into_spec(name)?);
                        }
                    }
                }
                _ => return Err(unknown_key(&key, "the signal map", &["vehicle", "columns", "signals"])),
            }
        }
        Ok(map)
    }
}

impl SignalEntry {
    fn into_spec(self, name: SignalName) -> Result<SignalSpec> {
        let unit: Unit = self.unit.as_deref().unwrap_or(name.default_unit()).parse()?;
        if !name.accepts(unit.dimension()) {
            return Err(Error::WrongDimension { signal: name.key(), unit: unit.name(), dimension: unit.dimension() });
        }
        let finite = |field: &'static str, value: Option<f64>, default: f64| match value.unwrap_or(default) {
            value if value.is_finite() => Ok(value),
            value => Err(Error::NotFinite { signal: name.key(), field, value }),
        };
        let relative_to_gear = match self.relative_to.as_deref() {
            None => false,
            Some("gear") => true,
            Some(other) => return Err(Error::RelativeTo { signal: name.key(), found: other.to_owned() }),
        };
        let mut codes = Vec::new();
        for (listed, value) in [(self.neutral, 0.0), (self.forward, 1.0), (self.reverse, -1.0)] {
            match listed {
                Some(OneOrMany::One(code)) => codes.push((code, value)),
                Some(OneOrMany::Many(many)) => codes.extend(many.into_iter().map(|code| (code, value))),
                None => {}
            }
        }
        Ok(SignalSpec {
            path: path_or_column(&self.path)?,
            unit,
            is_unit_given: self.unit.is_some(),
            scale: finite("scale", self.scale, 1.0)?,
            offset: finite("offset", self.offset, 0.0)?,
            stamp: match self.stamp.as_deref().map(str::trim) {
                None => Stamp::Usual,
                Some("none") => Stamp::None,
                Some(path) => Stamp::At(stamp_steps(path)?),
            },
            relative_to_gear,
            unsigned: self.unsigned,
            codes,
        })
    }
}

/// A message path, or a text that is none because it is the name of a table's column, such as `wheel speed.x [rad/s]`.
///
/// # Errors
/// It begins like a topic and is no path, or it is empty.
fn path_or_column(text: &str) -> Result<MessagePath> {
    let name = text.trim();
    match text.parse() {
        Err(Error::BadPath { .. }) if !name.is_empty() && !name.starts_with(['/', '"', '\'', '.', '[', '{']) => {
            Ok(MessagePath::column(&name_from_outside(name)))
        }
        parsed => parsed,
    }
}

/// The path of a stamp: `header.stamp`, or a complete path with its topic.
fn stamp_steps(text: &str) -> Result<Vec<PathStep>> {
    let whole = if text.starts_with('/') { text.to_owned() } else { format!("message.{}", text.trim_start_matches('.')) };
    whole.parse().map(|path: MessagePath| path.steps)
}

fn known_keys(value: &toml::Value, place: &str, known: &[&'static str]) -> Result<()> {
    let keys = value.as_table().into_iter().flat_map(toml::Table::keys);
    keys.filter(|key| !known.contains(&key.as_str())).map(|key| Err(unknown_key(key, place, known))).next().unwrap_or(Ok(()))
}

fn unknown_key(found: &str, place: &str, known: &[&'static str]) -> Error {
    let nearest = known.iter().min_by_key(|key| edits(found, key)).copied().unwrap_or_default();
    Error::UnknownKey { found: found.to_owned(), place: place.to_owned(), nearest, known: known.join(", ") }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn every_option_is_read() {
        let map = SignalMap::from_toml(
            r#"
            [vehicle]
            wheelbase_m = 0.92
            [signals]
            speed = { path = '/t.v{name=="w"}', unit = "rpm", scale = 2, offset = -1.5, stamp = "header.stamp", relative_to = "gear", unsigned = true }
            gear = { path = "/g.data", neutral = "N", forward = ["D", 2], reverse = 20, stamp = "none" }
            "#,
        )
        .unwrap();
        assert_eq!(map.vehicle.wheelbase_m, Some(0.92));
        let speed = &map.signals[&SignalName::Speed];
        assert_eq!((speed.scale, speed.offset, speed.relative_to_gear, speed.unsigned), (2.0, -1.5, true, true));
        assert!(matches!(&speed.stamp, Stamp::At(steps) if steps.len() == 2));
        let gear = &map.signals[&SignalName::Gear];
        assert_eq!((gear.codes.len(), &gear.stamp), (4, &Stamp::None));
        assert_eq!(gear.codes[3], (Code::Number(20.0), -1.0));
    }

    #[test]
    fn a_typo_names_the_nearest_key() {
        let wrong = |text: &str| SignalMap::from_toml(text).unwrap_err().to_string();
        assert!(wrong("[signals]\ntorqe = { path = '/a.b' }").contains("\"torque\""));
        assert!(wrong("[signal]\n").contains("\"signals\""));
        assert!(wrong("[signals]\nspeed = { path = '/a.b', units = 'm/s' }").contains("\"unit\""));
        assert!(wrong("[vehicle]\nwheelbase = 1").contains("\"wheelbase_m\""));
    }

    #[test]
    fn a_unit_of_another_dimension_is_refused() {
        let error = SignalMap::from_toml("[signals]\ntorque = { path = '/a.b', unit = 'rpm' }").unwrap_err();
        assert!(matches!(error, Error::WrongDimension { signal: "torque", .. }), "{error}");
    }
}
