//! Every single value that the messages of a log hold, as a path that a signal map could name.

use super::container::Container;
use super::path::MessagePath;
use super::plan::{Plan, Raw, Taken};
use super::schema::{Layout, Leaf, LeafKind};
use std::collections::BTreeMap;

/// Elements of an array that are listed one by one.
const MAX_ELEMENTS: usize = 16;
/// Values listed of one topic.
const MAX_PER_TOPIC: usize = 500;

/// A value that messages of a topic hold.
#[derive(Debug, Clone)]
pub(super) struct Candidate {
    pub topic: String,
    /// Name of the schema, empty without one.
    pub schema: String,
    pub path: MessagePath,
    pub kind: LeafKind,
    /// Numbers that the schema names.
    pub names: Vec<(String, i64)>,
    /// What the first message holds.
    pub sample: Option<f64>,
}

/// Lists the values of every topic. `samples` holds a payload of each channel.
pub(super) fn list(container: &Container, samples: &BTreeMap<u16, Vec<u8>>) -> Vec<Candidate> {
    let mut found = Vec::new();
    for (id, channel) in &container.inventory.channels {
        let schema = container.inventory.schema(channel);
        let Ok(layout) = Layout::parse(&channel.message_encoding, schema.map(AsRef::as_ref)) else { continue };
        let sample = samples.get(id).map(Vec::as_slice);
        let leaves = if matches!(layout, Layout::Json) { json_leaves(sample) } else { layout.leaves() };
        let mut paths = Vec::new();
        for leaf in leaves {
            expand(&layout, &channel.topic, &leaf, sample, &mut paths);
            paths.truncate(MAX_PER_TOPIC);
        }
        for (path, leaf) in paths {
            let sample = sample.and_then(|payload| number(&layout, &path, payload));
            found.push(Candidate {
                topic: channel.topic.clone(),
                schema: schema.map(|schema| schema.name.clone()).unwrap_or_default(),
                path,
                kind: leaf.kind,
                names: leaf.names,
                sample,
            });
        }
    }
    found
}

/// A topic as a path spells it.
pub(super) fn quoted(topic: &str) -> String {
    if topic.contains(['.', '[', '{', '"', '\'']) { format!("{topic:?}") } else { topic.to_owned() }
}

fn expand(layout: &Layout, topic: &str, leaf: &Leaf, sample: Option<&[u8]>, into: &mut Vec<(MessagePath, Leaf)>) {
    let whole = format!("{}{}", quoted(topic), leaf.path);
    let mut push = |text: String| {
        if let Ok(path) = text.parse() {
            into.push((path, leaf.clone()));
        }
    };
    match &leaf.list {
        None => push(whole),
        Some(list) => {
            if let (Some(names), Some(payload)) = (&list.names, sample) {
                let beside = leaf.path.rsplit_once('.').map_or("", |(before, _)| before);
                for index in 0..MAX_ELEMENTS {
                    let text = format!("{}{beside}.{names}[{index}]", quoted(topic));
                    let Some(name) = text.parse().ok().and_then(|path| element_name(layout, &path, payload)) else { break };
                    push(format!("{whole}{{{names}=={name:?}}}"));
                }
            } else {
                for index in 0..list.length.unwrap_or(1).min(MAX_ELEMENTS) {
                    push(format!("{whole}[{index}]"));
                }
            }
        }
    }
}

fn element_name(layout: &Layout, path: &MessagePath, payload: &[u8]) -> Option<String> {
    let mut taken = Taken::default();
    Plan::compile(layout, &[path]).ok()?.decode(payload, &mut taken)?;
    match taken.get(0) {
        Raw::Text(name) => Some(name.clone().into_owned()),
        _ => None,
    }
}

fn number(layout: &Layout, path: &MessagePath, payload: &[u8]) -> Option<f64> {
    let mut taken = Taken::default();
    Plan::compile(layout, &[path]).ok()?.decode(payload, &mut taken)?;
    match taken.get(0) {
        Raw::Number(value) => Some(*value),
        Raw::Integer(value) => Some(*value as f64),
        Raw::Text(_) | Raw::Missing => None,
    }
}

/// Leaves of a JSON message, told by one of its messages.
fn json_leaves(sample: Option<&[u8]>) -> Vec<Leaf> {
    let mut found = Vec::new();
    if let Some(value) = sample.and_then(|payload| serde_json::from_slice(payload).ok()) {
        descend(&value, String::new(), &mut found);
    }
    found
}

fn descend(value: &serde_json::Value, path: String, found: &mut Vec<Leaf>) {
    use serde_json::Value;
    if found.len() >= MAX_PER_TOPIC {
        return;
    }
    let kind = match value {
        Value::Object(fields) => {
            for (name, value) in fields {
                let plain = !name.is_empty() && name.chars().all(|c| c.is_alphanumeric() || matches!(c, '_' | '-' | '/'));
                let name = if plain { name.clone() } else { format!("{name:?}") };
                descend(value, format!("{path}.{name}"), found);
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
        Value::String(_) => LeafKind::Text,
    };
    found.push(Leaf { path, kind, names: Vec::new(), list: None });
}
