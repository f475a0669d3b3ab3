//! Converts raw values to SI, gears to −1, 0, +1, and flags to 0 and 1.

use crate::log::signal_map::{Code, SignalName, SignalSpec};
use crate::log::value::Raw;
use crate::map::Vehicle;
use crate::units::Dimension;

/// Conversion of the values of one signal, for one channel.
#[derive(Debug, Clone)]
pub(crate) enum Convert {
    /// SI = factor · (scale · raw + offset).
    Linear { factor: f64, scale: f64, offset: f64 },
    /// Numbers and names that mean a gear; all others mean neutral.
    Gear { numbers: Vec<(f64, f64)>, texts: Vec<(String, f64)> },
    /// 0 for zero, 1 for any other value.
    Flag,
}

impl Convert {
    /// `names`: numbers that the schema names at this place. The vehicle's wheel radius converts wheel rotation to speed, its full scale a share to torque.
    pub(crate) fn new(name: SignalName, spec: &SignalSpec, names: &[(String, i64)], vehicle: &Vehicle) -> Self {
        match name {
            SignalName::Estop => Self::Flag,
            SignalName::Gear => Self::gear(spec, names),
            _ => {
                let per_unit = match (name, spec.unit.dimension()) {
                    (SignalName::Speed, Dimension::AngularSpeed) => vehicle.wheel_radius_m,
                    // a share without a full scale was refused before
                    (SignalName::Torque | SignalName::TorqueFeedback, Dimension::Share) => vehicle.torque_full_scale_nm.unwrap_or(f64::NAN),
                    _ => 1.0,
                };
                let factor = spec.unit.factor() * per_unit;
                Self::Linear { factor, scale: spec.scale, offset: spec.offset }
            }
        }
    }

    fn gear(spec: &SignalSpec, names: &[(String, i64)]) -> Self {
        let mut numbers = Vec::new();
        let mut texts = Vec::new();
        for (code, gear) in &spec.codes {
            match code {
                Code::Number(number) => numbers.push((*number, *gear)),
                Code::Text(text) => {
                    let named = names.iter().filter(|(name, _)| name.eq_ignore_ascii_case(text));
                    numbers.extend(named.map(|(_, number)| (*number as f64, *gear)));
                    texts.push((text.clone(), *gear));
                }
            }
        }
        if spec.codes.is_empty() {
            numbers.extend(names.iter().filter_map(|(name, number)| Some((*number as f64, gear_of(name)?))));
            if numbers.iter().all(|(_, gear)| *gear == 0.0) {
                numbers = vec![(0.0, 0.0), (1.0, 1.0), (2.0, -1.0), (-1.0, -1.0)];
            }
        }
        Self::Gear { numbers, texts }
    }

    /// The value in SI; `None` if the message holds no usable value. May be NaN or infinite.
    pub(crate) fn apply(&self, raw: &Raw<'_>) -> Option<f64> {
        let number = match raw {
            Raw::Missing => return None,
            Raw::Number(value) => *value,
            Raw::Integer(value) => *value as f64,
            Raw::Text(text) => return self.apply_text(text.trim()),
        };
        Some(match self {
            Self::Linear { factor, scale, offset } => factor * (scale * number + offset),
            Self::Gear { numbers, .. } => numbers.iter().find(|(code, _)| *code == number).map_or(0.0, |(_, gear)| *gear),
            Self::Flag => f64::from(u8::from(number != 0.0)),
        })
    }

    fn apply_text(&self, text: &str) -> Option<f64> {
        match self {
            Self::Linear { .. } => text.parse().ok().and_then(|number| self.apply(&Raw::Number(number))),
            Self::Gear { numbers, texts } => {
                let listed = texts.iter().find(|(code, _)| code.eq_ignore_ascii_case(text)).map(|(_, gear)| *gear);
                let by_number = || {
                    let number: f64 = text.parse().ok()?;
                    numbers.iter().find(|(code, _)| *code == number).map(|(_, gear)| *gear)
                };
                let by_name = || texts.is_empty().then(|| gear_of(text)).flatten();
                Some(listed.or_else(by_number).or_else(by_name).unwrap_or(0.0))
            }
            Self::Flag => {
                let set = ["true", "on", "yes", "active", "pressed", "stop"].iter().any(|word| text.eq_ignore_ascii_case(word));
                Some(f64::from(u8::from(set || text.parse().is_ok_and(|number: f64| number != 0.0))))
            }
        }
    }
}

/// The gear that a name means: `D`, `GEAR_REVERSE`, `neutral` …
pub(crate) fn gear_of(name: &str) -> Option<f64> {
    name.split(|c: char| !c.is_alphanumeric()).rev().find_map(|word| match word.to_ascii_lowercase().as_str() {
        "n" | "neutral" | "p" | "park" | "none" | "off" => Some(0.0),
        "d" | "drive" | "f" | "forward" | "fwd" => Some(1.0),
        "r" | "reverse" | "rev" | "backward" => Some(-1.0),
        _ => None,
    })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use std::borrow::Cow;

    fn spec(unit: &str) -> SignalSpec {
        SignalSpec::new("/a.b".parse().unwrap(), unit.parse().unwrap())
    }

    fn vehicle(wheel_radius_m: f64) -> Vehicle {
        Vehicle { wheelbase_m: 0.9, wheel_radius_m, test_angle_deg: 90.0, torque_limit_nm: None, torque_full_scale_nm: Some(44.0) }
    }

    #[test]
    fn a_share_becomes_torque_through_the_full_scale() {
        for (unit, number) in [("%", 25.0), ("permille", 250.0)] {
            let convert = Convert::new(SignalName::Torque, &spec(unit), &[], &vehicle(0.12));
            assert!((convert.apply(&Raw::Number(number)).unwrap() - 11.0).abs() < 1e-12, "{unit}");
        }
    }

    #[test]
    fn rotation_becomes_speed_through_the_wheel_radius() {
        let convert = Convert::new(SignalName::Speed, &spec("rpm"), &[], &vehicle(0.12));
        let value = convert.apply(&Raw::Integer(60)).unwrap();
        assert!((value - 2.0 * std::f64::consts::PI * 0.12).abs() < 1e-12);
    }

    #[test]
    fn scale_and_offset_come_before_the_unit() {
        let spec = SignalSpec { scale: 0.1, offset: -5.0, ..spec("km/h") };
        let value = Convert::new(SignalName::Speed, &spec, &[], &vehicle(0.12)).apply(&Raw::Text(Cow::Borrowed(" 86 "))).unwrap();
        assert!((value - 1.0).abs() < 1e-12);
    }

    #[test]
    fn gears_are_known_by_number_by_text_and_by_the_schemas_names() {
        let names =
            [("GEAR_NEUTRAL".to_owned(), 1), ("GEAR_DRIVE".to_owned(), 2), ("GEAR_REVERSE".to_owned(), 20), ("PARK".to_owned(), 22)];
        let by_schema = Convert::new(SignalName::Gear, &spec("1"), &names, &vehicle(0.1));
        assert_eq!([1, 2, 20, 22, 7].map(|n| by_schema.apply(&Raw::Integer(n)).unwrap()), [0.0, 1.0, -1.0, 0.0, 0.0]);
        assert_eq!(by_schema.apply(&Raw::Text(Cow::Borrowed("R"))), Some(-1.0));
        let codes = vec![(Code::Text("gear_drive".into()), -1.0), (Code::Number(1.0), 1.0)];
        let convert = Convert::new(SignalName::Gear, &SignalSpec { codes, ..spec("1") }, &names, &vehicle(0.1));
        assert_eq!([1, 2, 20].map(|n| convert.apply(&Raw::Integer(n)).unwrap()), [1.0, -1.0, 0.0]);
    }
}
