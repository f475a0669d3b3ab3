//! The header of a table: names and units of its columns.

use crate::log::find::candidates::{Candidate, ColumnName};
use crate::log::path::{MessagePath, PathStep, Test};
use crate::log::schema::LeafKind;
use crate::text::name_from_outside;
use crate::units::Unit;

/// The unit in a header.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum HeadUnit {
    None,
    Known(Unit),
    /// Not one of ours, such as `A`.
    Unknown(String),
}

/// One column of a table in wide form, or one signal of a table in long form.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Head {
    /// The name as the file has it.
    pub name: String,
    /// The name without its unit.
    pub bare: String,
    pub unit: HeadUnit,
    /// What the values look like; integers where none was seen.
    pub kind: LeafKind,
    /// The first value that was seen.
    pub sample: Option<f64>,
}

impl Head {
    /// A column with this text in its header, and a unit that stands elsewhere, if there is one.
    pub(crate) fn new(text: &str, unit: Option<&str>) -> Self {
        let name = name_from_outside(text.trim()).into_owned();
        let (bare, inside) = in_brackets(&name).map_or((name.as_str(), None), |(bare, unit)| (bare, Some(unit)));
        let given = unit.map(str::trim).filter(|unit| !unit.is_empty());
        let unit = match inside.or(given).map(|text| (text, text.parse::<Unit>())) {
            None => HeadUnit::None,
            Some((_, Ok(unit))) => HeadUnit::Known(unit),
            Some((text, Err(_))) => HeadUnit::Unknown(name_from_outside(text).into_owned()),
        };
        Self { bare: bare.to_owned(), name, unit, kind: LeafKind::Integer, sample: None }
    }

    /// The column as something that may be a signal; `None` if nobody knows its unit.
    pub(crate) fn candidate(&self) -> Option<Candidate> {
        let unit = match &self.unit {
            HeadUnit::None => None,
            HeadUnit::Known(unit) => Some(*unit),
            HeadUnit::Unknown(_) => return None,
        };
        let (around, field) = self.bare.rsplit_once(['/', '.', '\\', ':']).unwrap_or(("", &self.bare));
        // the joints of ROS have their fixed units, whoever wrote them into a table
        let schema = if self.bare.contains("joint_state") { "sensor_msgs/JointState" } else { "" };
        Some(Candidate {
            topic: self.bare.clone(),
            schema: schema.to_owned(),
            path: MessagePath::column(&self.name),
            kind: self.kind,
            names: Vec::new().into(),
            sample: self.sample,
            column: Some(ColumnName { field: field.to_owned(), around: around.to_owned(), unit }),
        })
    }
}

/// `speed [km/h]` and `speed (km/h)` as name and unit. A number in brackets is an index.
fn in_brackets(name: &str) -> Option<(&str, &str)> {
    let (open, inside) = match name.chars().last()? {
        ']' => ('[', &name[..name.len() - 1]),
        ')' => ('(', &name[..name.len() - 1]),
        _ => return None,
    };
    let (bare, unit) = inside.rsplit_once(open)?;
    let is_index = unit.trim().parse::<i64>().is_ok() && !bare.ends_with(' ');
    (!bare.trim().is_empty() && !is_index).then_some((bare.trim_end(), unit.trim()))
}

/// The name of a series as PlotJuggler writes it, from a message path or a column's name, so that both can be compared: parts between
/// slashes, and the element that a filter selects before the array's own name.
pub(crate) fn series_of_path(path: &MessagePath) -> String {
    let mut parts: Vec<String> = vec![path.topic.clone()];
    for step in &path.steps {
        match step {
            PathStep::Field(name) => parts.push(name.clone()),
            PathStep::Index(index) => parts.push(index.to_string()),
            PathStep::Slice(..) => parts.push("[:]".to_owned()),
            PathStep::Filter(Test { with: crate::log::path::Literal::Text(element), .. }) => {
                let array = parts.pop().unwrap_or_default();
                parts.extend([element.clone(), array]);
            }
            PathStep::Filter(test) => parts.push(format!("{{{test}}}")),
        }
    }
    series_of_text(&parts.join("/"))
}

/// The same of a column's name.
pub(crate) fn series_of_text(name: &str) -> String {
    let plain: String = name.chars().map(|c| if matches!(c, '.' | '[' | ']' | '/') { '/' } else { c }).collect();
    let parts: Vec<&str> = plain.split('/').filter(|part| !part.is_empty()).collect();
    parts.join("/")
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn the_unit_stands_in_brackets_and_an_index_is_none() {
        let unit = |text: &str| {
            let head = Head::new(text, None);
            let unit = match head.unit {
                HeadUnit::None => "none".to_owned(),
                HeadUnit::Known(unit) => unit.name().to_owned(),
                HeadUnit::Unknown(text) => format!("unknown {text}"),
            };
            (head.bare, unit)
        };
        let expected = [
            ("wheel_speed [rad/s]", "wheel_speed", "rad/s"),
            ("speed(km/h)", "speed", "km/h"),
            ("current [A]", "current", "unknown A"),
            ("gyro[2]", "gyro[2]", "none"),
            ("/wheel/speed/data", "/wheel/speed/data", "none"),
            ("[s]", "[s]", "none"),
        ];
        for (text, bare, named) in expected {
            assert_eq!(unit(text), (bare.to_owned(), named.to_owned()), "{text}");
        }
        assert_eq!(Head::new("torque", Some(" Nm ")).unit, HeadUnit::Known("N.m".parse().unwrap()));
    }

    #[test]
    fn a_message_path_and_the_series_that_is_written_of_it_have_one_name() {
        let pairs = [
            (r#"/joint_states.velocity{name=="front_drive_joint"}"#, "/joint_states/front_drive_joint/velocity"),
            ("/imu.gyro[2]", "/imu/gyro[2]"),
            ("/imu.gyro[2]", "/imu/gyro.2"),
            ("/drive/torque_command.data", "/drive/torque_command/data"),
        ];
        for (path, series) in pairs {
            assert_eq!(series_of_path(&path.parse().unwrap()), series_of_text(series), "{path}");
        }
    }
}
