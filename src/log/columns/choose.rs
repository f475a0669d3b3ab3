//! Which column of a table is which signal: by signal map, by preset, or by name and unit.

use crate::log::columns::head::{Head, HeadUnit, series_of_path, series_of_text};
use crate::log::columns::layout::names;
use crate::log::find::candidates::Candidate;
use crate::log::find::detect;
use crate::log::find::resolve::{Choices, PathChoice};
use crate::log::path::MessagePath;
use crate::log::signal_map::{SignalMap, SignalName, SignalSpec, Stamp};
use crate::log::{Error, Result, Source, reference_path};
use crate::spelling::edits;

/// The choices, and the column of each.
#[derive(Debug, Default)]
pub(crate) struct ColumnChoices {
    pub choices: Choices,
    pub columns: Vec<usize>,
}

/// Chooses a column for each signal.
///
/// # Errors
/// The signal map names a column that the table does not have or has twice, or the unit of a column is not one of the signal's.
pub(crate) fn choose(source: &Source, wanted: &[SignalName], heads: &[Head]) -> Result<ColumnChoices> {
    let mut found = ColumnChoices::default();
    let (map, why) = match source {
        Source::Map(map) => {
            found.choices.named = true;
            (map.clone(), "the signal map names it".to_owned())
        }
        Source::Preset(preset) => (preset.map()?, format!("preset {preset}")),
        Source::Detect => (SignalMap::default(), String::new()),
    };
    reference_path::is_named(&map)?;
    // a column without a known unit is named in errors, but not guessed
    let candidates: Vec<Candidate> = heads.iter().filter_map(Head::candidate).collect();
    for &signal in wanted {
        if let Some(spec) = map.signals.get(&signal) {
            if let Some(column) = column_of(signal, &spec.path, heads)? {
                let spec = with_unit(signal, spec, &heads[column])?;
                if matches!(spec.stamp, Stamp::At(_)) {
                    found.choices.notes.push(format!("{signal}: the stamp in the signal map is not used: a table has one column of times"));
                }
                found.choices.found.push(PathChoice { signal, spec, reason: why.clone(), is_guess: false });
                found.columns.push(column);
                continue;
            }
            let path = &spec.path;
            if found.choices.named && signal.is_required() {
                return Err(no_column(signal, path, heads));
            }
            if found.choices.named {
                found.choices.notes.push(format!("{signal} is left out: the table has no column {path}"));
                continue;
            }
        }
        let best = if found.choices.named { None } else { detect::best(signal, candidates.iter()) };
        let column = best.as_ref().and_then(|(spec, ..)| heads.iter().position(|head| head.name == spec.path.to_string()));
        match (best, column) {
            (Some((spec, reason, unit_named)), Some(column)) => {
                found.choices.found.push(PathChoice { signal, spec, reason, is_guess: !unit_named });
                found.choices.guessed = true;
                found.columns.push(column);
            }
            _ => found.choices.missing.push(signal),
        }
    }
    Ok(found)
}

/// The columns that are nearest to a signal, for an error.
pub(crate) fn nearest(signal: SignalName, heads: &[Head]) -> Vec<String> {
    let candidates: Vec<Candidate> = heads.iter().filter_map(Head::candidate).collect();
    crate::log::find::resolve::nearest(signal, &candidates)
}

/// The column that a path of the signal map means: by its name, its name without the unit, or the series that a message path makes.
///
/// # Errors
/// Two columns have that name.
fn column_of(signal: SignalName, path: &MessagePath, heads: &[Head]) -> Result<Option<usize>> {
    let text = path.to_string();
    let series = series_of_path(path);
    // a message with the field `data` alone may be named by its topic
    let whole = series.strip_suffix("/data").unwrap_or(&series).to_owned();
    let rules: [&dyn Fn(&Head) -> bool; 4] =
        [&|head| head.name == text, &|head| head.bare == text, &|head| series_of_text(&head.bare) == series, &|head| {
            series_of_text(&head.bare).trim_end_matches("/data") == whole
        }];
    for rule in rules {
        let mut found = (0..heads.len()).filter(|k| rule(&heads[*k]));
        match (found.next(), found.next()) {
            (Some(first), Some(second)) => {
                return Err(Error::TwoColumns { signal: signal.key(), column: text.clone(), first: first + 1, second: second + 1 });
            }
            (Some(column), None) => return Ok(Some(column)),
            _ => {}
        }
    }
    Ok(None)
}

/// What the signal map says of a signal, with the unit of the header where the map gives none.
///
/// # Errors
/// The unit of the header is not known or not one of the signal's.
fn with_unit(signal: SignalName, spec: &SignalSpec, head: &Head) -> Result<SignalSpec> {
    let mut spec = SignalSpec { path: MessagePath::column(&head.name), ..spec.clone() };
    let has_unit = !matches!(signal, SignalName::Gear | SignalName::Estop | SignalName::YawZ | SignalName::YawW);
    if spec.is_unit_given || !has_unit {
        return Ok(spec);
    }
    let wrong = |unit: &str| Error::ColumnUnit { signal: signal.key(), column: head.name.clone(), unit: unit.to_owned() };
    match &head.unit {
        HeadUnit::None => {}
        HeadUnit::Known(unit) if signal.accepts(unit.dimension()) => spec.unit = *unit,
        HeadUnit::Known(unit) => return Err(wrong(unit.name())),
        HeadUnit::Unknown(unit) => return Err(wrong(unit)),
    }
    Ok(spec)
}

fn no_column(signal: SignalName, path: &MessagePath, heads: &[Head]) -> Error {
    let text = path.to_string();
    let near = heads.iter().min_by_key(|head| edits(&text, &head.bare)).filter(|head| edits(&text, &head.bare) <= text.len() / 2);
    Error::NoColumn {
        signal: signal.key(),
        column: text,
        nearest: near.map(|head| format!("{:?}", head.name)).into_iter().collect(),
        columns: names(heads),
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn heads(names: &[&str]) -> Vec<Head> {
        names.iter().map(|name| Head::new(name, None)).collect()
    }

    /// The columns and units that a signal map, or nothing, chooses.
    fn chosen(source: &Source, names: &[&str]) -> Vec<String> {
        let found = choose(source, &SignalName::ALL, &heads(names)).unwrap();
        let shown = |choice: &PathChoice| format!("{} = {} [{}]", choice.signal, choice.spec.path, choice.spec.unit.name());
        let columns: Vec<&str> = found.columns.iter().map(|column| names[*column]).collect();
        let chosen: Vec<String> = found.choices.found.iter().map(shown).collect();
        assert!(columns.iter().zip(&found.choices.found).all(|(name, choice)| *name == choice.spec.path.to_string()));
        chosen
    }

    fn map(text: &str) -> Source {
        Source::Map(SignalMap::from_toml(&format!("[signals]\n{text}")).unwrap())
    }

    #[test]
    fn columns_are_found_by_name_and_unit() {
        let flat = ["t_ms", "Drive.TorqueCommand_Nm", "wheel_speed [rad/s]", "steering angle (deg)", "yaw_rate", "gear", "EStop"];
        let expected = [
            "speed = wheel_speed [rad/s] [rad/s]",
            "torque = Drive.TorqueCommand_Nm [N.m]",
            "angle = steering angle (deg) [deg]",
            "yaw_rate = yaw_rate [rad/s]",
            "gear = gear [1]",
            "estop = EStop [1]",
        ];
        assert_eq!(chosen(&Source::Detect, &flat), expected);
        let series = [
            "__time",
            "/drive/torque_command/data",
            "/joint_states/front_drive_joint/velocity",
            "/eps/joint_states/front_steer_joint/position",
            "/imu/twist/twist/angular/z",
        ];
        let expected = [
            "speed = /joint_states/front_drive_joint/velocity [rad/s]",
            "torque = /drive/torque_command/data [N.m]",
            "angle = /eps/joint_states/front_steer_joint/position [rad]",
            "yaw_rate = /imu/twist/twist/angular/z [rad/s]",
        ];
        assert_eq!(chosen(&Source::Detect, &series), expected);
        assert_eq!(chosen(&Source::Preset(crate::log::Preset::PivotCal), &series), expected);
    }

    #[test]
    fn a_signal_map_names_a_column_and_its_unit_wins() {
        let names = ["t", "v [km/h]", "torque.x [A]", "/a/b"];
        assert_eq!(chosen(&map("speed = { path = 'v' }"), &names), ["speed = v [km/h] [km/h]"]);
        assert_eq!(chosen(&map("speed = { path = 'v [km/h]', unit = 'm/s' }"), &names), ["speed = v [km/h] [m/s]"]);
        assert_eq!(chosen(&map("torque = { path = 'torque.x [A]', unit = 'N.m', scale = 2 }"), &names), ["torque = torque.x [A] [N.m]"]);
        assert_eq!(chosen(&map("angle = { path = '/a.b' }"), &names), ["angle = /a/b [rad]"]);
        assert_eq!(chosen(&map("angle = { path = '/a.b.data' }"), &names), ["angle = /a/b [rad]"]);
    }

    #[test]
    fn a_wrong_name_unit_or_a_name_that_occurs_twice_is_an_error_with_its_remedy() {
        let names = ["t", "v [km/h]", "current [A]", "x", "x"];
        let error = |text: &str| choose(&map(text), &SignalName::ALL, &heads(&names)).unwrap_err().to_string();
        let text = error("speed = { path = 'w' }");
        assert!(text.contains("no column \"w\"") && text.contains("\"v [km/h]\""), "{text}");
        let text = error("torque = { path = 'current' }");
        assert!(text.contains("is in \"A\"") && text.contains("scale"), "{text}");
        let text = error("torque = { path = 'v' }");
        assert!(text.contains("is in \"km/h\""), "{text}");
        let text = error("speed = { path = 'x' }");
        assert!(text.contains("columns 4 and 5"), "{text}");
    }
}
