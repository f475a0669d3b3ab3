//! Every single value in the messages of a log, as a path that a signal map could name.

use crate::log::extract::extractor::Extractor;
use crate::log::extract::extractor::json_literals::quoted_literals;
use crate::log::extract::extractor::taken::Taken;
use crate::log::file::container::Container;
use crate::log::path::{MessagePath, PathStep, quoted};
use crate::log::schema::{LONGEST_PATH, Layout, Leaf, LeafKind, Names};
use crate::log::value::Raw;
use crate::units::Unit;
use std::cell::OnceCell;
use std::collections::BTreeMap;

/// Largest number of elements of an array that are listed singly.
const MAX_ELEMENTS: usize = 16;
/// Largest number of values listed for one topic.
const MAX_PER_TOPIC: usize = 500;

/// A value in the messages of a topic.
#[derive(Debug, Clone)]
pub(crate) struct Candidate {
    pub topic: String,
    /// Name of the schema, empty without one.
    pub schema: String,
    pub path: MessagePath,
    pub kind: LeafKind,
    /// Numbers that the schema names.
    pub names: Names,
    /// The value in the first message.
    pub sample: Option<f64>,
    /// The parts of the name, if it is a column of a table.
    pub column: Option<ColumnName>,
}

/// The name of a table's column in parts, without its unit.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct ColumnName {
    /// The last part, after a slash or a dot.
    pub field: String,
    /// What stands before it; empty for a name of one part.
    pub around: String,
    /// The unit in the header.
    pub unit: Option<Unit>,
}

/// The candidates of a log, listed on first use. A complete signal map never needs them.
pub(crate) struct Candidates<'c> {
    container: &'c Container,
    /// A payload of each channel.
    pub samples: &'c BTreeMap<u16, Vec<u8>>,
    list: OnceCell<Vec<Candidate>>,
}

impl<'c> Candidates<'c> {
    /// `samples` holds a payload of each channel.
    pub(crate) fn new(container: &'c Container, samples: &'c BTreeMap<u16, Vec<u8>>) -> Self {
        Self { container, samples, list: OnceCell::new() }
    }

    /// The values of every topic.
    pub(crate) fn all(&self) -> &[Candidate] {
        self.list.get_or_init(|| list(self.container, self.samples))
    }
}

fn list(container: &Container, samples: &BTreeMap<u16, Vec<u8>>) -> Vec<Candidate> {
    let mut found = Vec::new();
    for (id, channel) in &container.inventory.channels {
        let schema = container.inventory.schema(channel);
        let Ok(layout) = Layout::parse(&channel.message_encoding, schema.map(AsRef::as_ref)) else { continue };
        let sample = samples.get(id).map(Vec::as_slice);
        let leaves = if matches!(layout, Layout::Json) { json_leaves(sample) } else { layout.leaves() };
        let paths = expand(&layout, &channel.topic, leaves, sample);
        let values = values(&layout, paths.iter().map(|(path, _)| path), sample);
        for ((path, leaf), sample) in paths.into_iter().zip(values) {
            found.push(Candidate {
                topic: channel.topic.clone(),
                schema: schema.map(|schema| schema.name.clone()).unwrap_or_default(),
                path,
                kind: leaf.kind,
                names: leaf.names,
                sample,
                column: None,
            });
        }
    }
    found
}

/// The leaves as paths. Array elements are named by the parallel array of names if the sample holds it, otherwise by number.
fn expand(layout: &Layout, topic: &str, leaves: Vec<Leaf>, sample: Option<&[u8]>) -> Vec<(MessagePath, Leaf)> {
    let topic = MessagePath::new(topic.to_owned(), Vec::new()).to_string();
    let mut named: BTreeMap<String, Vec<String>> = BTreeMap::new(); // elements' names by the array that holds them
    let mut paths = Vec::new();
    for leaf in leaves {
        let whole = format!("{topic}{}", leaf.path);
        let texts: Vec<String> = match &leaf.list {
            None => vec![whole],
            Some(list) => match (&list.names, sample) {
                (Some(names), Some(payload)) => {
                    let beside = leaf.path.rsplit_once('.').map_or("", |(before, _)| before);
                    let array = format!("{topic}{beside}.{names}");
                    let elements = named.entry(array).or_insert_with_key(|array| element_names(layout, array, payload));
                    elements.iter().map(|name| format!("{whole}{{{names}=={}}}", quoted(name))).collect()
                }
                _ => (0..list.length.unwrap_or(1).min(MAX_ELEMENTS)).map(|index| format!("{whole}[{index}]")).collect(),
            },
        };
        paths.extend(texts.iter().filter_map(|text| Some((text.parse().ok()?, leaf.clone()))));
        if paths.len() >= MAX_PER_TOPIC {
            paths.truncate(MAX_PER_TOPIC);
            break;
        }
    }
    paths
}

/// The strings at the start of `array`.
fn element_names(layout: &Layout, array: &str, payload: &[u8]) -> Vec<String> {
    let paths: Vec<MessagePath> = (0..MAX_ELEMENTS).filter_map(|index| format!("{array}[{index}]").parse().ok()).collect();
    let text = |raw: &Raw<'_>| match raw {
        Raw::Text(name) if name.len() <= LONGEST_PATH => Some(name.clone().into_owned()),
        _ => None,
    };
    taken(layout, &paths.iter().collect::<Vec<_>>(), payload, text).unwrap_or_default().into_iter().map_while(|name| name).collect()
}

/// The numbers of a message at `paths`.
fn values<'p>(layout: &Layout, paths: impl Iterator<Item = &'p MessagePath>, sample: Option<&[u8]>) -> Vec<Option<f64>> {
    let paths: Vec<&MessagePath> = paths.collect();
    let number = |raw: &Raw<'_>| match raw {
        Raw::Number(value) => Some(*value),
        Raw::Integer(value) => Some(*value as f64),
        Raw::Text(_) | Raw::Missing => None,
    };
    sample.and_then(|payload| taken(layout, &paths, payload, number)).unwrap_or_else(|| vec![None; paths.len()])
}

/// The result of `take` for the values at `paths`; `None` if the payload does not fit the schema.
fn taken<T>(layout: &Layout, paths: &[&MessagePath], payload: &[u8], take: impl Fn(&Raw<'_>) -> T) -> Option<Vec<T>> {
    let mut taken = Taken::default();
    Extractor::compile(layout, paths).ok()?.decode(payload, &mut taken)?;
    Some((0..paths.len()).map(|slot| take(taken.get(slot))).collect())
}

/// Leaves of a JSON channel, found in one of its messages.
pub(crate) fn json_leaves(sample: Option<&[u8]>) -> Vec<Leaf> {
    let mut found = Vec::new();
    let parsed = |payload: &[u8]| serde_json::from_slice(payload).ok();
    let value = sample.and_then(|payload| parsed(payload).or_else(|| parsed(&quoted_literals(payload)?)));
    if let Some(value) = value {
        descend(&value, String::new(), &mut found);
    }
    found
}

fn descend(value: &serde_json::Value, path: String, found: &mut Vec<Leaf>) {
    use serde_json::Value;
    if found.len() >= MAX_PER_TOPIC || path.len() > LONGEST_PATH {
        return;
    }
    let kind = match value {
        Value::Object(fields) => {
            for (name, value) in fields {
                descend(value, format!("{path}{}", PathStep::Field(name.chars().take(LONGEST_PATH + 1).collect())), found);
            }
            return;
        }
        Value::Array(values) => {
            for (index, value) in values.iter().take(MAX_ELEMENTS).enumerate() {
                descend(value, format!("{path}[{index}]"), found);
            }
            return;
        }
        Value::Null => return,
        Value::Bool(_) => LeafKind::Bool,
        Value::Number(number) if number.is_f64() => LeafKind::Float,
        Value::Number(_) => LeafKind::Integer,
        // NaN and infinity take the place of a number
        Value::String(text) if text.parse().is_ok_and(|number: f64| !number.is_finite()) => LeafKind::Float,
        Value::String(_) => LeafKind::Text,
    };
    found.push(Leaf { path, kind, names: Names::default(), list: None });
}
