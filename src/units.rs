//! Units of measure: names that a signal map may use, and their factor to SI.
//!
//! SI = factor · (scale · raw + offset): a value is converted once, at input. Inside the library all values are in SI with radians.

use std::f64::consts::PI;
use std::fmt;
use std::str::FromStr;

pub(crate) use crate::control::RAD_PER_DEG;

/// Radians per second in one revolution per minute.
pub(crate) const RAD_S_PER_RPM: f64 = 2.0 * PI / 60.0;
/// Nanoseconds in one second.
pub(crate) const NS_PER_S: f64 = 1e9;

/// Dimension of a unit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Dimension {
    /// Metres per second.
    Speed,
    /// Metres per second squared.
    Acceleration,
    /// Radians per second of a wheel or of the vehicle's heading.
    AngularSpeed,
    /// Radians.
    Angle,
    /// Newton metres.
    Torque,
    /// Seconds.
    Time,
    /// Metres.
    Length,
    /// A share of a full scale.
    Share,
    /// A number without dimension: a gear, a flag, a ratio.
    Number,
}

impl fmt::Display for Dimension {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Speed => "speed",
            Self::Acceleration => "acceleration",
            Self::AngularSpeed => "angular speed",
            Self::Angle => "angle",
            Self::Torque => "torque",
            Self::Time => "time",
            Self::Length => "length",
            Self::Share => "share",
            Self::Number => "number",
        })
    }
}

/// A unit of measure that a signal map may name.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Unit {
    name: &'static str,
    dimension: Dimension,
    factor: f64,
}

/// All known units, the SI unit of a dimension first; names in one row have the same meaning.
const UNITS: &[(&[&str], Dimension, f64)] = &[
    (&["m/s", "mps", "m/sec"], Dimension::Speed, 1.0),
    (&["km/h", "kmh", "kph"], Dimension::Speed, 1.0 / 3.6),
    (&["mm/s", "mmps"], Dimension::Speed, 1e-3),
    (&["cm/s"], Dimension::Speed, 1e-2),
    (&["m/s²", "m/s^2", "m/s2", "mps2"], Dimension::Acceleration, 1.0),
    (&["rad/s", "radps"], Dimension::AngularSpeed, 1.0),
    (&["deg/s", "dps", "°/s"], Dimension::AngularSpeed, RAD_PER_DEG),
    (&["mrad/s"], Dimension::AngularSpeed, 1e-3),
    (&["rpm", "1/min", "rev/min"], Dimension::AngularSpeed, RAD_S_PER_RPM),
    (&["rev/s", "rps"], Dimension::AngularSpeed, 2.0 * PI),
    (&["rad"], Dimension::Angle, 1.0),
    (&["mrad"], Dimension::Angle, 1e-3),
    (&["deg", "°", "degree", "degrees"], Dimension::Angle, RAD_PER_DEG),
    (&["cdeg", "0.01deg"], Dimension::Angle, RAD_PER_DEG / 100.0),
    (&["N.m", "Nm", "N·m", "N*m", "N m"], Dimension::Torque, 1.0),
    (&["mN.m", "mNm"], Dimension::Torque, 1e-3),
    (&["cN.m", "cNm"], Dimension::Torque, 1e-2),
    (&["kN.m", "kNm"], Dimension::Torque, 1e3),
    (&["s", "sec", "second", "seconds"], Dimension::Time, 1.0),
    (&["ms", "msec", "millisecond", "milliseconds"], Dimension::Time, 1e-3),
    (&["us", "µs", "μs", "usec", "microsecond", "microseconds"], Dimension::Time, 1e-6),
    (&["ns", "nsec", "nanosecond", "nanoseconds"], Dimension::Time, 1e-9),
    (&["m"], Dimension::Length, 1.0),
    (&["mm"], Dimension::Length, 1e-3),
    (&["1", "", "%1", "number", "enum", "bool"], Dimension::Number, 1.0),
    (&["%"], Dimension::Share, 1e-2),
    (&["permille", "‰"], Dimension::Share, 1e-3),
];

/// An unknown unit name.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error(
    "unit {found:?} is not known; known units: {}; for any other, give one of these and `scale`, which multiplies the number in the message",
    known()
)]
pub struct UnknownUnit {
    /// The name that was found.
    pub found: String,
}

fn known() -> String {
    UNITS.iter().map(|(names, ..)| names[0]).collect::<Vec<_>>().join(", ")
}

impl Unit {
    /// The unit's usual name, such as `rad/s`.
    pub(crate) fn name(self) -> &'static str {
        self.name
    }

    /// Dimension of the unit.
    pub(crate) fn dimension(self) -> Dimension {
        self.dimension
    }

    /// SI value of one unit: `km/h` gives 1/3.6 (m/s), `deg` π/180 (rad).
    pub(crate) fn factor(self) -> f64 {
        self.factor
    }
}

impl FromStr for Unit {
    type Err = UnknownUnit;

    fn from_str(text: &str) -> Result<Self, UnknownUnit> {
        let wanted = text.trim();
        UNITS
            .iter()
            .find(|(names, ..)| names.contains(&wanted))
            .or_else(|| UNITS.iter().find(|(names, ..)| names.iter().any(|n| n.eq_ignore_ascii_case(wanted))))
            .map(|&(names, dimension, factor)| Self { name: names[0], dimension, factor })
            .ok_or_else(|| UnknownUnit { found: text.to_owned() })
    }
}

impl fmt::Display for Unit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn units_convert_to_si() {
        let si = |text: &str, raw: f64| text.parse::<Unit>().unwrap().factor() * raw;
        assert!((si("km/h", 3.6) - 1.0).abs() < 1e-15);
        assert!((si("rpm", 60.0) - 2.0 * PI).abs() < 1e-12);
        assert!((si("deg", 180.0) - PI).abs() < 1e-12);
        assert!((si("Nm", 2.0) - 2.0).abs() < 1e-15);
    }

    #[test]
    fn the_error_of_an_unknown_unit_lists_the_known_ones() {
        let error = "furlong".parse::<Unit>().unwrap_err();
        assert!(error.to_string().contains("furlong") && error.to_string().contains("km/h"));
    }
}
