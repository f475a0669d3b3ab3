//! Finds signals by name, type and unit if no signal map names them.
//!
//! Each value of the log gets a score for each signal from the words in its topic and path. The name of the field itself counts most, then
//! the message around it, then the topic. The best score wins if it is high enough; the reason is reported.

use crate::log::extract::convert::gear_of;
use crate::log::find::candidates::Candidate;
use crate::log::path::MessagePath;
use crate::log::schema::LeafKind;
use crate::log::signal_map::{SignalName, SignalSpec};
use crate::units::{Dimension, Unit};

/// Lowest score at which a value is accepted as a signal.
const ENOUGH: i32 = 6;

/// A candidate with its score for one signal.
#[derive(Debug, Clone)]
pub(crate) struct Scored<'c> {
    pub candidate: &'c Candidate,
    pub score: i32,
    pub unit: Unit,
    /// Whether the name or the type gives the unit.
    pub unit_named: bool,
    pub reason: String,
}

/// Candidates for `signal`, the best first; impossible ones are left out.
pub(crate) fn ranked<'c>(signal: SignalName, candidates: impl Iterator<Item = &'c Candidate>) -> Vec<Scored<'c>> {
    let mut scored: Vec<Scored<'c>> = candidates.filter_map(|candidate| score(signal, candidate)).collect();
    // equal scores: the shorter path first, then by name, so that the choice never depends on the order of channels
    let key = |s: &Scored<'_>| (-s.score, s.candidate.path.to_string().len(), s.candidate.path.to_string());
    scored.sort_by_key(key);
    scored
}

/// The best candidate for `signal`, if it is good enough, with the reason and whether its unit is given.
pub(crate) fn best<'c>(signal: SignalName, candidates: impl Iterator<Item = &'c Candidate>) -> Option<(SignalSpec, String, bool)> {
    let ranked = ranked(signal, candidates);
    let first = ranked.first().filter(|best| best.score >= ENOUGH)?;
    let mut reason = format!("found by name: {}", first.reason);
    if let Some(second) = ranked.get(1).filter(|second| second.score == first.score) {
        reason = format!("{reason}; {} fits as well", second.candidate.path);
    }
    Some((SignalSpec::new(first.candidate.path.clone(), first.unit), reason, first.unit_named))
}

/// Words of a name: `wheelSpeed_rpm` gives wheel, speed, rpm.
fn words(text: &str) -> Vec<String> {
    let mut words = vec![String::new()];
    let mut lower_before = false;
    for character in text.chars() {
        if character.is_alphanumeric() {
            if character.is_uppercase() && lower_before {
                words.push(String::new());
            }
            words.last_mut().into_iter().for_each(|word| word.extend(character.to_lowercase()));
        } else {
            words.push(String::new());
        }
        lower_before = character.is_lowercase();
    }
    words.retain(|word| !word.is_empty());
    words
}

/// Words of a candidate, grouped by their distance from the value.
struct Words {
    field: Vec<String>,
    around: Vec<String>,
    topic: Vec<String>,
}

impl Words {
    fn new(candidate: &Candidate) -> Self {
        if let Some(column) = &candidate.column {
            let schema = words(candidate.schema.rsplit('/').next().unwrap_or_default());
            return Self::of_parts(words(&column.field), schema, &column.around);
        }
        let path = candidate.path.to_string();
        let topic = MessagePath::new(candidate.topic.clone(), Vec::new()).to_string();
        let inside = path.strip_prefix(&topic).unwrap_or(&path);
        let (around, field) = inside.rsplit_once('.').unwrap_or(("", inside));
        let mut around = words(around);
        around.extend(words(candidate.schema.rsplit(['/', '.']).next().unwrap_or_default()));
        Self::of_parts(words(field), around, &candidate.topic)
    }

    fn of_parts(mut field: Vec<String>, around: Vec<String>, topic: &str) -> Self {
        if matches!(field.first().map(String::as_str), Some("data" | "value")) {
            // such a field name has no meaning: the topic's last part is the name
            field.extend(words(topic.rsplit(['/', '.']).next().unwrap_or_default()));
        }
        Self { field, around, topic: words(topic) }
    }

    /// Score of the nearest of `any`: 4 in the field's own name, 2 around it, 2 in the topic, 0 nowhere.
    fn near(&self, any: &[&str]) -> i32 {
        let has = |words: &[String]| words.iter().any(|word| any.contains(&word.as_str()));
        if has(&self.field) {
            4
        } else if has(&self.around) || has(&self.topic) {
            2
        } else {
            0
        }
    }
}

/// The unit at the end of a value's name, or the unit prescribed by its type.
fn unit(words: &Words, candidate: &Candidate, signal: SignalName) -> Option<(Unit, bool)> {
    if let Some(unit) = candidate.column.as_ref().and_then(|column| column.unit) {
        return Some((unit, true));
    }
    let named = words.field.iter().rev().chain(words.around.iter().rev()).find_map(|word| {
        let name = match word.as_str() {
            "nm" => "N.m",
            "mnm" => "mN.m",
            "mps" => "m/s",
            "mmps" => "mm/s",
            "kmh" | "kph" => "km/h",
            "rpm" => "rpm",
            "radps" | "rads" => "rad/s",
            "dps" | "degps" => "deg/s",
            "mrad" => "mrad",
            "rad" => "rad",
            "deg" | "degrees" => "deg",
            "cdeg" => "cdeg",
            _ => return None,
        };
        name.parse::<Unit>().ok()
    });
    if let Some(unit) = named {
        return Some((unit, true));
    }
    let joint_velocity = signal == SignalName::Speed && candidate.schema.ends_with("JointState");
    let name = if joint_velocity { "rad/s" } else { signal.default_unit() };
    name.parse().ok().map(|unit| (unit, false))
}

fn score(signal: SignalName, candidate: &Candidate) -> Option<Scored<'_>> {
    let words = Words::new(candidate);
    let near = |any: &[&str]| words.near(any);
    if near(&["stamp", "header", "seq", "covariance", "current", "temperature", "timestamp"]) > 0 {
        return None;
    }
    let is_number = matches!(candidate.kind, LeafKind::Float | LeafKind::Integer);
    let (unit, named) = unit(&words, candidate, signal)?;
    let dimension = unit.dimension();
    let commanded = near(&["command", "cmd", "commanded", "setpoint", "target", "desired", "request", "requested", "ref"]);
    let measured = near(&["feedback", "fb", "actual", "measured", "report", "state", "estimate", "estimated"]);
    // joints that are not measured hold NaN; in other places one NaN has little meaning
    let mut score = if candidate.sample.is_some_and(|value| !value.is_finite()) { -3 } else { 0 };
    match signal {
        SignalName::Torque | SignalName::TorqueFeedback => {
            if !is_number || (named && dimension != Dimension::Torque) {
                return None;
            }
            let torque = near(&["torque", "effort", "trq", "tq"]).max(if named { 3 } else { 0 });
            if torque == 0 {
                return None;
            }
            let (wanted, other) = if signal == SignalName::Torque { (commanded, measured) } else { (measured, commanded) };
            // in a joint state the effort is measured
            let joint = i32::from(candidate.schema.ends_with("JointState"));
            let joint = if signal == SignalName::Torque { -4 * joint } else { joint };
            score += torque + wanted - other + joint - 4 * near(&["steer", "steering", "eps", "brake", "limit", "max", "min"]).min(1);
            score += near(&["drive", "traction", "motor", "wheel", "front"]).min(1);
        }
        SignalName::Speed => {
            let dimension_fits = matches!(dimension, Dimension::Speed | Dimension::AngularSpeed);
            if !is_number || (named && !dimension_fits) || near(&["yaw", "gyro", "angular", "imu", "heading", "lateral", "accel"]) > 0 {
                return None;
            }
            let speed = near(&["speed", "velocity", "vel", "rpm", "omega"]).max(if named { 3 } else { 0 });
            if speed == 0 {
                return None;
            }
            score += speed + near(&["wheel", "motor", "traction", "encoder"]) + near(&["drive", "front", "driven"]).min(2);
            score -= commanded + 4 * near(&["steer", "steering", "eps", "limit", "max", "min", "rear", "longitudinal"]).min(1);
        }
        SignalName::Angle => {
            if !is_number || (named && dimension != Dimension::Angle) || near(&["rate", "velocity", "speed", "effort", "imu", "yaw"]) == 4 {
                return None;
            }
            let steer = near(&["steer", "steering", "steered", "eps", "tire"]);
            let angle = near(&["angle", "position", "pos", "deg", "rad", "cdeg"]);
            if angle == 0 || (steer == 0 && near(&["wheel"]) == 0) {
                return None;
            }
            score += steer + angle - commanded + near(&["front", "eps"]).min(1);
        }
        SignalName::YawRate => {
            if !is_number || (named && dimension != Dimension::AngularSpeed) {
                return None;
            }
            let path = candidate.path.to_string();
            let axis_z = words.field.last().is_some_and(|word| word == "z") || path.ends_with("[2]");
            let heading = near(&["yaw", "heading"]) > 0 && near(&["rate", "speed", "velocity", "dps"]) > 0;
            let gyro = axis_z && near(&["gyro", "angular", "gyroscope"]) > 0;
            if (!heading && !gyro) || near(&["wheel", "steer", "steering", "accel", "acceleration", "linear", "odom"]) > 0 {
                return None;
            }
            score += 6 + near(&["imu", "gyro"]) - commanded;
        }
        SignalName::Gear => {
            let gear = near(&["gear", "shifter", "prnd"]);
            if gear == 0 || candidate.kind == LeafKind::Float {
                return None;
            }
            let named = i32::from(candidate.names.iter().any(|(name, _)| gear_of(name) == Some(-1.0)));
            score += 4 + gear + 2 * named - commanded - 4 * i32::from(near(&["ratio", "box", "temperature"]) > 0);
        }
        SignalName::Estop => {
            let joined = words.field.join("") + " " + &words.topic.join("");
            let emergency = near(&["estop", "emergency"]) > 0 || joined.contains("estop") || joined.contains("emergencystop");
            if !emergency || matches!(candidate.kind, LeafKind::Float) {
                return None;
            }
            score += 6 + near(&["estop", "emergency"]) + 2 * i32::from(candidate.kind == LeafKind::Bool);
        }
        // poses and references must be named and are not guessed: a log holds many of them, in many frames
        _ => return None,
    }
    let origin = if named { "its name says so" } else { "usual" };
    let schema = if candidate.schema.is_empty() { String::new() } else { format!(" of {}", candidate.schema) };
    let reason = if matches!(signal, SignalName::Gear | SignalName::Estop) {
        format!("{}{schema}", candidate.path)
    } else {
        format!("{}{schema}, unit {} ({origin})", candidate.path, unit.name())
    };
    let standard = ["JointState", "Twist", "TwistStamped", "Imu"].iter().any(|name| candidate.schema.ends_with(name));
    // of the standard types, only those of ROS have fixed units
    let unit_named = named || (standard && candidate.schema.contains('/'));
    Some(Scored { candidate, score, unit, unit_named, reason })
}
