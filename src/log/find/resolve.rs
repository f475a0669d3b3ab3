//! Makes plans from a signal map, a preset or no input: which signal is read from which path, and why.

use crate::log::extract::convert::Convert;
use crate::log::extract::extractor::Extractor;
use crate::log::extract::message_pass::{ChannelPlan, WantedValue};
use crate::log::extract::stamp;
use crate::log::extract::stamp::StampPath;
use crate::log::extractor_error::PlanError;
use crate::log::file::container::Container;
use crate::log::find::candidates::{Candidate, Candidates};
use crate::log::find::presets::Preset;
use crate::log::find::{detect, named_stamp, series};
use crate::log::path::{MessagePath, PathStep};
use crate::log::schema::Layout;
use crate::log::signal_map::{SignalMap, SignalName, SignalSpec};
use crate::log::vehicle::{SCENARIO_METADATA, VEHICLE_METADATA};
use crate::log::{Error, Result, Source, reference_path};
use crate::map::Vehicle;
use crate::spelling::edits;
use crate::units::Dimension;
use std::collections::{BTreeMap, BTreeSet};

/// A signal and the path that it is read from.
#[derive(Debug, Clone)]
pub(crate) struct PathChoice {
    pub signal: SignalName,
    pub spec: SignalSpec,
    pub reason: String,
    /// Found by name, and neither name nor type gives the unit.
    pub is_guess: bool,
}

/// Result for a log: the choices, the missing signals, and notes.
#[derive(Debug, Default)]
pub(crate) struct Choices {
    pub found: Vec<PathChoice>,
    /// Signals without a path.
    pub missing: Vec<SignalName>,
    pub notes: Vec<String>,
    /// Whether the user named the paths. If so, a path without a value is an error.
    pub named: bool,
    /// Whether any signal was found by name.
    pub guessed: bool,
}

/// Chooses a path for each signal.
///
/// # Errors
/// The signal map names a topic or a field that the log does not have.
pub(crate) fn choose(source: &Source, wanted: &[SignalName], container: &Container, candidates: &Candidates<'_>) -> Result<Choices> {
    let topics: BTreeSet<&str> = container.inventory.channels.values().map(|channel| channel.topic.as_str()).collect();
    let mut choices = Choices::default();
    let (map, why, preset) = match source {
        Source::Map(map) => {
            choices.named = true;
            (map.clone(), "the signal map names it".to_owned(), None)
        }
        Source::Preset(preset) => (preset.map()?, format!("preset {preset}"), Some(*preset)),
        Source::Detect if container.metadata.contains_key(VEHICLE_METADATA) => {
            (Preset::PivotCal.map()?, "the log was written by pivot-cal".to_owned(), None)
        }
        Source::Detect if container.metadata.contains_key(SCENARIO_METADATA) => {
            (Preset::VerifyLog.map()?, "the log was written by pivot-cal verify".to_owned(), None)
        }
        Source::Detect => (SignalMap::default(), String::new(), None),
    };
    let mut map = map;
    if !choices.named {
        reference_path::instead_of_point(&mut map, &topics)?;
    }
    reference_path::is_named(&map)?;
    for &signal in wanted {
        if let Some(spec) = map.signals.get(&signal) {
            let (is_plain, has_topic) = (series::is_plain(&spec.path), topics.contains(spec.path.topic.as_str()));
            if is_plain && has_topic {
                choices.found.push(PathChoice { signal, spec: spec.clone(), reason: why.clone(), is_guess: false });
                continue;
            }
            let series = if choices.named { series::path(&spec.path, container, candidates) } else { None };
            // a path without a value is still compiled where its error is more specific than "the topic is missing"
            let telling = |leads: bool| leads || has_topic || (signal.is_required() && !is_plain);
            if let Some((path, _)) = series.filter(|(_, leads)| telling(*leads)) {
                let reason = format!("{why} as the series {}", spec.path);
                choices.found.push(PathChoice { signal, spec: SignalSpec { path, ..spec.clone() }, reason, is_guess: false });
                continue;
            }
            if choices.named && signal.is_required() {
                return Err(no_topic(signal, &spec.path.topic, &topics));
            }
            if choices.named {
                choices.notes.push(format!("{signal} is left out: the log has no topic {}", spec.path.topic));
                continue;
            }
        }
        let allowed = |candidate: &&Candidate| preset.is_none_or(|preset| preset.allows(signal, &candidate.schema));
        // signals that a signal map omits are not searched for
        let best = if choices.named { None } else { detect::best(signal, candidates.all().iter().filter(allowed)) };
        if let Some((spec, reason, unit_named)) = best {
            choices.found.push(PathChoice { signal, spec, reason, is_guess: !unit_named });
            choices.guessed = true;
        } else {
            choices.missing.push(signal);
        }
    }
    Ok(choices)
}

/// The nearest candidates for a signal, at most three.
pub(crate) fn nearest(signal: SignalName, candidates: &[Candidate]) -> Vec<String> {
    let ranked = detect::ranked(signal, candidates.iter());
    let mut paths: Vec<String> = ranked.iter().take(3).map(|scored| scored.candidate.path.to_string()).collect();
    if paths.is_empty() {
        let mut named: Vec<(usize, String)> = candidates
            .iter()
            .map(|candidate| {
                let path = candidate.path.to_string();
                let words = path.split(|c: char| !c.is_alphanumeric()).filter(|word| word.len() > 2);
                let closest = words.map(|word| edits(word, signal.key())).min().unwrap_or(usize::MAX);
                (closest, path)
            })
            .filter(|(closest, _)| *closest <= signal.key().len() / 2)
            .collect();
        named.sort();
        paths = named.into_iter().take(3).map(|(_, path)| path).collect();
    }
    paths
}

fn no_topic(signal: SignalName, topic: &str, topics: &BTreeSet<&str>) -> Error {
    // only the first part of a series name is the topic
    let apart = |known: &str| {
        let front = series::cuts(topic).skip(1).map(|(front, _)| edits(front, known)).filter(|edits| *edits <= known.len() / 4).min();
        front.into_iter().chain([edits(topic, known)]).min().unwrap_or(usize::MAX)
    };
    let nearest = topics.iter().min_by_key(|known| apart(known)).filter(|known| apart(known) <= topic.len() / 2);
    Error::NoTopic {
        signal: signal.key(),
        topic: topic.to_owned(),
        nearest: nearest.map(|known| (*known).to_owned()).into_iter().collect(),
        topics: topics.iter().map(|known| (*known).to_owned()).collect(),
    }
}

/// Checks that a torque in % has a torque that is 100 %.
///
/// # Errors
/// It has none.
pub(crate) fn expect_full_scale(choices: &Choices, vehicle: &Vehicle) -> Result<()> {
    let is_share = |choice: &PathChoice| choice.spec.unit.dimension() == Dimension::Share;
    if vehicle.torque_full_scale_nm.is_none() && choices.found.iter().any(is_share) {
        return Err(Error::MissingVehicle { missing: "torque_full_scale_nm" });
    }
    Ok(())
}

/// The plans to read `choices`, one per channel; choice `i` fills column `i`.
///
/// # Errors
/// A path has no value in any channel of its topic.
pub(crate) fn plans(
    choices: &mut Choices,
    container: &Container,
    samples: &BTreeMap<u16, Vec<u8>>,
    vehicle: &Vehicle,
) -> Result<BTreeMap<u16, ChannelPlan>> {
    let mut plans = BTreeMap::new();
    let mut problems: BTreeMap<usize, Error> = BTreeMap::new();
    let mut served = BTreeSet::new();
    for (id, channel) in &container.inventory.channels {
        let wanted: Vec<(usize, &PathChoice)> =
            choices.found.iter().enumerate().filter(|(_, choice)| choice.spec.path.topic == channel.topic).collect();
        if wanted.is_empty() {
            continue;
        }
        let schema = container.inventory.schema(channel).map(AsRef::as_ref);
        let layout = match Layout::parse(&channel.message_encoding, schema) {
            Ok(layout) => layout,
            Err(source) => {
                for (column, choice) in wanted {
                    let error = || Error::Schema { signal: choice.signal.key(), topic: channel.topic.clone(), source: source.clone() };
                    problems.entry(column).or_insert_with(error);
                }
                continue;
            }
        };
        let good: Vec<(usize, &PathChoice)> = wanted
            .into_iter()
            .filter(|(column, choice)| {
                let path = |source| Error::Path { signal: choice.signal.key(), path: choice.spec.path.to_string(), source };
                let checked = one(&layout, choice)
                    .map_err(path)
                    .and_then(|()| named_stamp::check(&layout, choice.signal, &choice.spec, samples.get(id).map(Vec::as_slice)));
                checked.map_err(|problem| problems.entry(*column).or_insert(problem)).is_ok()
            })
            .collect();
        served.extend(good.iter().map(|(column, _)| *column));
        if let Some(plan) = channel_plan(&layout, &good, samples.get(id).map(Vec::as_slice), vehicle) {
            plans.insert(*id, plan);
        }
    }
    for (column, error) in problems {
        let choice = &choices.found[column];
        if served.contains(&column) {
            choices.notes.push(format!("{} has both usable and unusable messages: {error}", choice.spec.path.topic));
        } else if choices.named || choice.signal.is_required() {
            return Err(error);
        } else {
            choices.notes.push(format!("{} is left out: {error}", choice.signal));
        }
    }
    Ok(plans)
}

/// Whether a choice leads to a value or, for the reference of the lateral calibration, to a list of values.
fn one(layout: &Layout, choice: &PathChoice) -> std::result::Result<(), PlanError> {
    let path = &choice.spec.path;
    if path.is_list() && !matches!(choice.signal, SignalName::ReferenceX | SignalName::ReferenceY) {
        return Err(PlanError::ManyValues);
    }
    Extractor::compile(layout, &[path]).map(|_| ()).map_err(|(_, source)| source)
}

fn channel_plan(layout: &Layout, wanted: &[(usize, &PathChoice)], sample: Option<&[u8]>, vehicle: &Vehicle) -> Option<ChannelPlan> {
    let mut paths: Vec<MessagePath> = Vec::new();
    let slot = |steps: &[PathStep], paths: &mut Vec<MessagePath>| {
        paths.iter().position(|path| path.steps == steps).unwrap_or_else(|| {
            paths.push(MessagePath::inside(steps.to_vec()));
            paths.len() - 1
        })
    };
    let mut values = Vec::new();
    for (column, choice) in wanted {
        let spec = &choice.spec;
        let stamp = stamp::find(layout, &spec.stamp, sample).and_then(|parts| {
            let slots: Vec<usize> = parts.iter().map(|steps| slot(steps, &mut paths)).collect();
            match slots[..] {
                [seconds, nanoseconds] => Some(StampPath::Parts { seconds, nanoseconds }),
                [single] => Some(StampPath::Single(single)),
                _ => None,
            }
        });
        let names = layout.names(&spec.path.steps);
        values.push(WantedValue {
            column: *column,
            slot: slot(&spec.path.steps, &mut paths),
            stamp,
            convert: Convert::new(choice.signal, spec, &names, vehicle),
            list: spec.path.is_list(),
        });
    }
    let references: Vec<&MessagePath> = paths.iter().collect();
    Some(ChannelPlan { plan: Extractor::compile(layout, &references).ok()?, values })
}
