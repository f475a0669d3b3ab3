//! Units of the user's side: SI = scale · number + offset.

use crate::export::{Error, Result};
use crate::units::{Dimension, Unit};

/// A unit in which a table is exported.
#[derive(Debug, Clone, PartialEq)]
pub struct UserUnit {
    /// Its name, as calibration tools show it.
    pub name: String,
    /// The end of an identifier.
    pub(crate) word: String,
    /// SI value of one unit.
    pub scale: f64,
    /// SI value of 0.
    pub offset: f64,
}

/// Units of a table's speeds and torques; accelerations are always in m/s². Default SI.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct UserUnits {
    /// Unit of the speeds.
    pub speed: Option<UserUnit>,
    /// Unit of the torques.
    pub torque: Option<UserUnit>,
}

/// What a unit needs beside its name; `None` where nothing was given.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct UnitNumbers {
    /// SI value of one unit, of ampere and raw counts.
    pub scale: Option<f64>,
    /// SI value of 0, of raw counts.
    pub offset: Option<f64>,
    /// Torque that is 100 % [N·m].
    pub full_scale_nm: Option<f64>,
}

/// Names that have no unit of their own.
const RAW: &str = "raw";

impl UserUnit {
    /// A unit of speed. Units of a turning wheel need its rolling radius [m]; `raw` needs a scale.
    ///
    /// # Errors
    /// A name that is none of a speed, a scale that is missing or not above 0.
    pub fn of_speed(name: &str, numbers: UnitNumbers, wheel_radius_m: f64) -> Result<Self> {
        if name == RAW {
            return Self::counts("speed", numbers);
        }
        let unit = name.parse::<Unit>().ok().filter(|u| matches!(u.dimension(), Dimension::Speed | Dimension::AngularSpeed));
        let allowed = "m/s, km/h, mm/s, cm/s, rpm, rad/s, rev/s, raw";
        let unit = unit.ok_or_else(|| Error::Unit { what: "speed", found: name.to_owned(), allowed })?;
        let radius = if unit.dimension() == Dimension::AngularSpeed { wheel_radius_m } else { 1.0 };
        Self::new("speed", unit.name(), unit.factor() * radius, 0.0)
    }

    /// A unit of torque. `%` and `permille` need the torque that is 100 %, `A` and `raw` a scale.
    ///
    /// # Errors
    /// A name that is none of a torque, a number that is missing or not above 0.
    pub fn of_torque(name: &str, numbers: UnitNumbers) -> Result<Self> {
        let full =
            |share: f64| numbers.full_scale_nm.map(|full| share * full).ok_or(Error::UnitNumber { what: "torque", needs: "full scale" });
        let scale = || numbers.scale.ok_or(Error::UnitNumber { what: "torque", needs: "scale" });
        match name {
            RAW => Self::counts("torque", numbers),
            "%" => Self::new("torque", "%", full(0.01)?, 0.0),
            "permille" | "‰" => Self::new("torque", "permille", full(0.001)?, 0.0),
            "A" => Self::new("torque", "A", scale()?, 0.0),
            _ => {
                let unit = name.parse::<Unit>().ok().filter(|u| u.dimension() == Dimension::Torque);
                let allowed = "N.m, mN.m, cN.m, kN.m, %, permille, A, raw";
                let unit = unit.ok_or_else(|| Error::Unit { what: "torque", found: name.to_owned(), allowed })?;
                Self::new("torque", unit.name(), unit.factor(), 0.0)
            }
        }
    }

    fn counts(what: &'static str, numbers: UnitNumbers) -> Result<Self> {
        let scale = numbers.scale.ok_or(Error::UnitNumber { what, needs: "scale" })?;
        Self::new(what, RAW, scale, numbers.offset.unwrap_or(0.0))
    }

    fn new(what: &'static str, name: &str, scale: f64, offset: f64) -> Result<Self> {
        if !(scale.is_finite() && scale > 0.0 && offset.is_finite()) {
            return Err(Error::UnitScale { what, scale, offset });
        }
        let word = match name {
            "%" => "pct".to_owned(),
            _ => name.chars().filter(char::is_ascii_alphanumeric).collect::<String>().to_ascii_lowercase(),
        };
        Ok(Self { name: name.to_owned(), word, scale, offset })
    }

    /// The number of this unit for a value in SI, with 12 significant digits; raw counts are whole if the value is one.
    pub(crate) fn number(&self, si: f64) -> f64 {
        tidy((si - self.offset) / self.scale)
    }
}

/// A number with 12 significant digits: a factor of a unit must not leave a tail of digits.
fn tidy(value: f64) -> f64 {
    format!("{value:.11e}").parse().unwrap_or(value)
}

impl UserUnits {
    /// A speed [m/s] in the user's unit.
    pub(crate) fn speed(&self, speed_mps: f64) -> f64 {
        self.speed.as_ref().map_or(speed_mps, |unit| unit.number(speed_mps))
    }

    /// A torque [N·m] in the user's unit.
    pub(crate) fn torque(&self, torque_nm: f64) -> f64 {
        self.torque.as_ref().map_or(torque_nm, |unit| unit.number(torque_nm))
    }

    /// Name of the speed's unit.
    pub(crate) fn speed_name(&self) -> &str {
        self.speed.as_ref().map_or("m/s", |unit| &unit.name)
    }

    /// Name of the torque's unit.
    pub(crate) fn torque_name(&self) -> &str {
        self.torque.as_ref().map_or("Nm", |unit| &unit.name)
    }

    /// Whether both are SI.
    pub(crate) fn are_si(&self) -> bool {
        self.speed.is_none() && self.torque.is_none()
    }

    /// The units as a line of a header; none for SI.
    pub(crate) fn line(&self) -> Option<String> {
        let of = |what: &str, si: &str, unit: &Option<UserUnit>| {
            unit.as_ref().map(|u| format!("{what} in {}, {si} = {} x number + {}", u.name.replace('/', " per "), u.scale, u.offset))
        };
        let units: Vec<String> = of("speed", "m per s", &self.speed).into_iter().chain(of("torque", "N.m", &self.torque)).collect();
        (!units.is_empty()).then(|| format!("Units of the tables: {}.", units.join(", ")))
    }

    /// Generated code with the identifiers and comments of these units instead of those of SI.
    pub(crate) fn in_code(&self, text: &str) -> String {
        let mut text = text.to_owned();
        if let Some(unit) = &self.speed {
            text = text.replace("speed_mps", &format!("speed_{}", unit.word)).replace("speed [m/s]", &format!("speed [{}]", unit.name));
        }
        if let Some(unit) = &self.torque {
            text = text.replace("torque_nm", &format!("torque_{}", unit.word));
            for si in ["Torque [N.m]", "Torque [N·m]"] {
                text = text.replace(si, &format!("Torque [{}]", unit.name));
            }
        }
        text
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn each_unit_gives_the_number_that_a_person_expects() {
        let numbers = |scale, offset, full_scale_nm| UnitNumbers { scale, offset, full_scale_nm };
        let speed = |name: &str, n| UserUnit::of_speed(name, n, 0.12).unwrap().number(0.3);
        let torque = |name: &str, n| UserUnit::of_torque(name, n).unwrap().number(11.0);
        let none = UnitNumbers::default();
        assert_eq!((speed("km/h", none), speed("mm/s", none), speed("raw", numbers(Some(0.01), Some(-1.0), None))), (1.08, 300.0, 130.0));
        assert!((speed("rpm", none) - 0.3 / 0.12 * 60.0 / std::f64::consts::TAU).abs() < 1e-9);
        let full = numbers(None, None, Some(44.0));
        assert_eq!((torque("%", full), torque("permille", full), torque("A", numbers(Some(2.2), None, None))), (25.0, 250.0, 5.0));
        assert_eq!(torque("raw", numbers(Some(0.5), Some(1.0), None)), 20.0);
    }

    #[test]
    fn what_a_unit_lacks_is_said() {
        let said = |unit: Result<UserUnit>| unit.unwrap_err().to_string();
        assert!(said(UserUnit::of_speed("mph", UnitNumbers::default(), 0.1)).contains("allowed: m/s, km/h"));
        assert!(said(UserUnit::of_torque("%", UnitNumbers::default())).contains("full scale"));
        assert!(said(UserUnit::of_torque("A", UnitNumbers { scale: Some(0.0), ..UnitNumbers::default() })).contains("above 0"));
        assert!(said(UserUnit::of_torque("km/h", UnitNumbers::default())).contains("allowed: N.m"));
    }
}
