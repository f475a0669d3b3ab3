//! What is in a log: topics, time span, and where the signals are. Answers from the summary when that is enough.

use crate::log::extract::message_pass;
use crate::log::file::container::Container;
use crate::log::file::input::LogInput;
use crate::log::file::open::open;
use crate::log::file::record::{CHUNK_HEADER, ChunkHeader};
use crate::log::find::candidates::Candidates;
use crate::log::find::resolve;
use crate::log::loss::Loss;
use crate::log::rate::{Rate, rate};
use crate::log::read::loss;
use crate::log::signal_map::SignalName;
use crate::log::{Error, Result, Source};
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// What is in a log.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LogSurvey {
    /// File name without its folder.
    pub file: String,
    /// Size [bytes].
    pub bytes: u64,
    /// Program that wrote the log, as it says itself.
    pub library: String,
    /// Profile of the log, such as `ros2`.
    pub profile: String,
    /// Whether the summary was sound and used.
    pub indexed: bool,
    /// Number of chunks.
    pub chunks: usize,
    /// Compressions met.
    pub compression: Vec<String>,
    /// Log time of the first message [ns since 1970]; `None` when nothing tells.
    pub start_ns: Option<u64>,
    /// Log time of the last message [ns since 1970].
    pub end_ns: Option<u64>,
    /// Number of messages, counted or as the log says.
    pub messages: Option<u64>,
    /// Attachments, which are passed over.
    pub attachments: u64,
    /// Names of the metadata records.
    pub metadata: Vec<String>,
    /// The topics, by name.
    pub topics: Vec<Topic>,
    /// The signals found.
    pub signals: Vec<FoundSignal>,
    /// The signals not found.
    pub missing: Vec<Missing>,
    /// Whether every message was walked: then `loss`, the counts and the true rates are measured.
    pub checked: bool,
    /// What was read and lost, when checked.
    pub loss: Option<Loss>,
    /// Remarks.
    pub notes: Vec<String>,
}

/// One channel of a log.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Topic {
    /// Name of the topic.
    pub topic: String,
    /// Name of the schema, if there is one.
    pub schema: Option<String>,
    /// Encoding of the schema.
    pub schema_encoding: Option<String>,
    /// Encoding of the messages.
    pub encoding: String,
    /// Number of messages; `None` when nothing tells.
    pub messages: Option<u64>,
    /// Messages per second over the span of the log.
    pub rate_hz: Option<f64>,
}

/// A signal that was found.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FoundSignal {
    /// Which signal.
    pub signal: SignalName,
    /// Where.
    pub path: String,
    /// In which unit.
    pub unit: String,
    /// Why there.
    pub reason: String,
    /// Number of values, when checked.
    pub values: Option<usize>,
    /// Rates, when checked.
    pub rate: Option<Rate>,
}

/// A signal that was not found.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Missing {
    /// Which signal.
    pub signal: SignalName,
    /// Whether a log without it cannot be used.
    pub required: bool,
    /// Paths that come nearest.
    pub candidates: Vec<String>,
}

/// How much of the log is read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Depth {
    /// As little as answers what is in it.
    Summary,
    /// Every message: counts, losses and true rates are measured.
    Everything,
}

/// Says what is in the log at `path`. `progress` is told the bytes read, from several threads.
///
/// # Errors
/// A file that is no log or, when everything is read, holds no message.
pub fn survey(path: &Path, source: &Source, depth: Depth, progress: &(dyn Fn(u64) + Sync)) -> Result<LogSurvey> {
    let file = path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
    survey_input(LogInput::open(path)?, file, source, depth, progress)
}

/// Says what is in a log in memory; otherwise as [`survey`].
///
/// # Errors
/// As [`survey`].
pub fn survey_bytes(bytes: Vec<u8>, name: &str, source: &Source, depth: Depth) -> Result<LogSurvey> {
    survey_input(LogInput::Memory(bytes), name.to_owned(), source, depth, &|_| {})
}

fn survey_input(input: LogInput, file: String, source: &Source, depth: Depth, progress: &(dyn Fn(u64) + Sync)) -> Result<LogSurvey> {
    let mut container = open(input)?;
    let mut samples = message_pass::explore(&mut container);
    let mut gathered = None;
    if depth == Depth::Everything && !container.is_listed() {
        // channels that only an unlisted chunk describes: walk once to learn them
        let mut walked = message_pass::all(&container, &BTreeMap::new(), 0, &|_| {});
        container.learn(std::mem::take(&mut walked.learned));
        for (id, payload) in std::mem::take(&mut walked.samples) {
            samples.entry(id).or_insert(payload);
        }
    }
    let mut notes = Vec::new();
    let candidates = Candidates::new(&container, &samples);
    let mut choices = match resolve::choose(source, &SignalName::ALL, &container, &candidates) {
        Ok(choices) => choices,
        Err(error) => {
            notes.push(error.to_string());
            resolve::Choices::default()
        }
    };
    if depth == Depth::Everything {
        // the rates do not depend on the wheel radius
        let plans = resolve::plans(&mut choices, &container, &samples, 1.0).unwrap_or_else(|error| {
            notes.push(error.to_string());
            BTreeMap::new()
        });
        gathered = Some(message_pass::all(&container, &plans, choices.found.len(), progress));
    }
    let mut found = Vec::new();
    let mut not_finite = BTreeMap::new();
    let mut columns = gathered.as_mut().map(|gathered| std::mem::take(&mut gathered.columns));
    for (column, choice) in choices.found.iter().enumerate() {
        let column = columns.as_mut().map(|columns| std::mem::take(&mut columns[column]));
        not_finite.extend(column.as_ref().filter(|column| column.not_finite > 0).map(|c| (choice.signal.key().to_owned(), c.not_finite)));
        let signal = column.map(|column| column.into_signal(false, false));
        found.push(FoundSignal {
            signal: choice.signal,
            path: choice.spec.path.to_string(),
            unit: choice.spec.unit.name().to_owned(),
            reason: choice.reason.clone(),
            values: signal.as_ref().map(crate::log::Signal::len),
            rate: signal.as_ref().and_then(rate),
        });
    }
    let missing =
        |signal: SignalName| Missing { signal, required: signal.is_required(), candidates: resolve::nearest(signal, candidates.all()) };
    notes.append(&mut choices.notes);
    let loss = gathered.as_ref().map(|gathered| Loss { not_finite, ..loss(&container, gathered) });
    if gathered.as_ref().is_some_and(|gathered| gathered.tallies.is_empty()) {
        return Err(Error::NoMessages { damage: loss.as_ref().and_then(Loss::summary) });
    }
    let counts: Option<BTreeMap<u16, u64>> = match (&gathered, &container.statistics) {
        (Some(gathered), _) => Some(gathered.tallies.iter().map(|(id, tally)| (*id, tally.messages)).collect()),
        (None, Some(statistics)) => Some(statistics.channel_message_counts.clone()),
        (None, None) => None,
    };
    let (start_ns, end_ns) = match (&gathered, &container.statistics) {
        (Some(gathered), _) => {
            (gathered.tallies.values().map(|tally| tally.first_ns).min(), gathered.tallies.values().map(|tally| tally.last_ns).max())
        }
        (None, Some(statistics)) => (Some(statistics.message_start_time), Some(statistics.message_end_time)),
        (None, None) => (None, None),
    };
    let span_s = start_ns.zip(end_ns).map(|(start, end)| end.saturating_sub(start) as f64 / crate::units::NS_PER_S);
    let mut topics: Vec<Topic> = container
        .inventory
        .channels
        .iter()
        .map(|(id, channel)| {
            let schema = container.inventory.schema(channel);
            let messages = counts.as_ref().map(|counts| counts.get(id).copied().unwrap_or(0));
            Topic {
                topic: channel.topic.clone(),
                schema: schema.map(|schema| schema.name.clone()),
                schema_encoding: schema.map(|schema| schema.encoding.clone()),
                encoding: channel.message_encoding.clone(),
                messages,
                rate_hz: messages.zip(span_s).filter(|(_, span)| *span > 0.0).map(|(messages, span)| messages as f64 / span),
            }
        })
        .collect();
    topics.sort_by(|a, b| a.topic.cmp(&b.topic));
    Ok(LogSurvey {
        file,
        bytes: container.input.length(),
        library: container.library.clone(),
        profile: container.profile.clone(),
        indexed: container.indexed,
        chunks: container.blocks.iter().filter(|block| block.kind != crate::log::file::structure::BlockKind::Loose).count(),
        compression: compressions(&container),
        start_ns,
        end_ns,
        messages: counts.map(|counts| counts.values().sum()),
        attachments: container.attachments,
        metadata: container.metadata.keys().cloned().collect(),
        topics,
        signals: found,
        missing: choices.missing.into_iter().map(missing).collect(),
        checked: gathered.is_some(),
        loss,
        notes,
    })
}

/// The compressions of the chunks, from a few of them.
fn compressions(container: &Container) -> Vec<String> {
    let mut found = BTreeSet::new();
    let mut head = Vec::new();
    for block in container.blocks.iter().filter(|block| block.kind != crate::log::file::structure::BlockKind::Loose).take(64) {
        let length = CHUNK_HEADER.min(block.length as usize);
        if container.input.read_into(block.offset, length, &mut head).is_ok() {
            found.extend(ChunkHeader::parse(&head).map(|header| header.compression.name().to_owned()));
        }
    }
    found.into_iter().collect()
}
