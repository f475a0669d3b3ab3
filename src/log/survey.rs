//! The content of a log: topics, time span, and paths of the signals. Uses only the summary if that is enough.

use crate::log::columns::OpenTable;
use crate::log::columns::choose::ColumnChoices;
use crate::log::columns::head::Head;
use crate::log::columns::table::TableFormat;
use crate::log::extract::column::Column;
use crate::log::extract::message_pass;
use crate::log::file::container::Container;
use crate::log::file::input::LogInput;
use crate::log::file::open::open;
use crate::log::file::record::{CHUNK_HEADER, ChunkHeader};
use crate::log::find::candidates::Candidates;
use crate::log::find::resolve;
use crate::log::find::resolve::Choices;
use crate::log::loss::Loss;
use crate::log::rate::{Rate, rate};
use crate::log::read::loss;
use crate::log::rosbag2::expect_no_database;
use crate::log::signal_map::SignalName;
use crate::log::timing::log_clock::ClockStep;
use crate::log::timing::message_times::SignalTimes;
use crate::log::timing::true_times;
use crate::log::value_range::ValueRange;
use crate::log::{Error, MessageKind, Result, Signal, Source};
use crate::map::Vehicle;
use crate::text::shown;
use crate::units::NS_PER_S;
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::sync::Arc;

/// The content of a log.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LogSurvey {
    /// File name without its folder.
    pub file: String,
    /// Size [bytes].
    pub bytes: u64,
    /// Format and form, if the log is a table and not MCAP.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub table: Option<String>,
    /// Program that wrote the log, according to the log.
    pub library: String,
    /// Profile of the log, such as `ros2`.
    pub profile: String,
    /// Whether the summary was valid and used.
    pub indexed: bool,
    /// Number of chunks.
    pub chunks: usize,
    /// Compressions used.
    pub compression: Vec<String>,
    /// Log time of the first message [ns since 1970]; `None` if not known.
    pub start_ns: Option<u64>,
    /// Log time of the last message [ns since 1970].
    pub end_ns: Option<u64>,
    /// Number of messages, counted or from the log's own count.
    pub messages: Option<u64>,
    /// Number of attachments; they are skipped.
    pub attachments: u64,
    /// Names of the metadata records.
    pub metadata: Vec<String>,
    /// The topics, by name.
    pub topics: Vec<Topic>,
    /// The signals found.
    pub signals: Vec<FoundSignal>,
    /// The signals not found.
    pub missing: Vec<Missing>,
    /// Whether every message was read. If so, `loss`, the counts and the true rates are measured.
    pub checked: bool,
    /// The read and the lost data, if checked.
    pub loss: Option<Loss>,
    /// Notes.
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
    /// Number of messages; `None` if not known.
    pub messages: Option<u64>,
    /// Messages per second over the span of the log.
    pub rate_hz: Option<f64>,
}

/// A signal that was found.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FoundSignal {
    /// The signal.
    pub signal: SignalName,
    /// Its path.
    pub path: String,
    /// Its unit.
    pub unit: String,
    /// The reason for the path.
    pub reason: String,
    /// Number of values, if checked.
    pub values: Option<usize>,
    /// Between which values it lies, if checked.
    pub range: Option<ValueRange>,
    /// Rates, if checked.
    pub rate: Option<Rate>,
    /// What its messages mean, if checked.
    pub messages: Option<MessageKind>,
}

/// A signal that was not found.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Missing {
    /// The signal.
    pub signal: SignalName,
    /// Whether a log must have it to be usable.
    pub required: bool,
    /// The nearest paths.
    pub candidates: Vec<String>,
}

/// The extent of reading.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Depth {
    /// As little as needed to list the content.
    Summary,
    /// Every message: counts, losses and true rates are measured.
    Everything,
}

/// Reports the content of the log at `path`. `progress` receives the number of bytes read, from several threads.
///
/// # Errors
/// The file is not a log or, if all messages are read, holds no message.
pub fn survey(path: &Path, source: &Source, depth: Depth, progress: &(dyn Fn(u64) + Sync)) -> Result<LogSurvey> {
    survey_input(LogInput::open(path)?, path, source, depth, progress)
}

/// Reports the content of a log in memory; otherwise like [`survey`].
///
/// # Errors
/// As [`survey`].
pub fn survey_bytes(bytes: Vec<u8>, name: &str, source: &Source, depth: Depth) -> Result<LogSurvey> {
    survey_input(LogInput::Memory(bytes), Path::new(name), source, depth, &|_| {})
}

fn survey_input(input: LogInput, path: &Path, source: &Source, depth: Depth, progress: &(dyn Fn(u64) + Sync)) -> Result<LogSurvey> {
    let file = path.file_name().map(shown).unwrap_or_default();
    expect_no_database(path, &input)?;
    if let Some(format) = TableFormat::of(path, &input)? {
        return survey_table(format, &Arc::new(input), file, source, depth, progress);
    }
    let mut container = open(input)?;
    let mut samples = message_pass::explore(&mut container);
    let mut gathered = None;
    if depth == Depth::Everything && !container.is_listed() {
        // channels that are described only in an unlisted chunk: one walk finds them
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
        let plans = resolve::plans(&mut choices, &container, &samples, &any_vehicle()).unwrap_or_else(|error| {
            notes.push(error.to_string());
            BTreeMap::new()
        });
        gathered = Some(message_pass::all(&container, &plans, choices.found.len(), progress));
    }
    let columns = gathered.as_mut().map(|gathered| std::mem::take(&mut gathered.columns)).unwrap_or_default();
    let steps = gathered.as_ref().map_or(&[][..], |gathered| &gathered.clock_steps);
    let (found, not_finite) = found_signals(&choices, &columns, steps, &mut notes);
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
    let span_s = start_ns.zip(end_ns).map(|(start, end)| end.saturating_sub(start) as f64 / NS_PER_S);
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
        table: None,
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

/// The chosen signals with their rates, if `columns` were read, and the numbers of values that are not finite.
fn found_signals(
    choices: &Choices,
    columns: &[Column],
    steps: &[ClockStep],
    notes: &mut Vec<String>,
) -> (Vec<FoundSignal>, BTreeMap<String, u64>) {
    let times: Vec<SignalTimes> =
        choices.found.iter().zip(columns).map(|(choice, column)| SignalTimes { signal: choice.signal, times: &column.times }).collect();
    let (true_times, clock_notes) = true_times(&times, steps);
    notes.extend(clock_notes);
    let not_finite: BTreeMap<String, u64> = choices
        .found
        .iter()
        .zip(columns)
        .filter(|(_, column)| column.not_finite > 0)
        .map(|(choice, column)| (choice.signal.key().to_owned(), column.not_finite))
        .collect();
    let mut read = columns.iter().zip(true_times).map(|(column, times)| {
        let mut signal = Signal { value: column.value.clone(), time_ns: times.time_ns, ..Signal::default() };
        signal.sort();
        signal
    });
    let mut found = Vec::new();
    for choice in &choices.found {
        let signal = read.next();
        found.push(FoundSignal {
            signal: choice.signal,
            path: choice.spec.path.to_string(),
            unit: choice.spec.unit.name().to_owned(),
            reason: choice.reason.clone(),
            values: signal.as_ref().map(Signal::len),
            range: signal.as_ref().and_then(|signal| ValueRange::of(&signal.value)),
            rate: signal.as_ref().and_then(rate),
            messages: signal.as_ref().map(kind),
        });
    }
    (found, not_finite)
}

/// The content of a table: its columns as topics.
fn survey_table(
    format: TableFormat,
    input: &Arc<LogInput>,
    file: String,
    source: &Source,
    depth: Depth,
    progress: &(dyn Fn(u64) + Sync),
) -> Result<LogSurvey> {
    let open = OpenTable::open(format, input, source)?;
    let mut notes = open.notes.clone();
    let chosen = open.choose(source, &SignalName::ALL).unwrap_or_else(|error| {
        notes.push(error.to_string());
        ColumnChoices::default()
    });
    let mut gathered = match depth {
        Depth::Everything => Some(open.gather(&chosen, &any_vehicle(), progress)?),
        Depth::Summary => None,
    };
    let columns = gathered.as_mut().map(|gathered| std::mem::take(&mut gathered.columns)).unwrap_or_default();
    let steps = gathered.as_ref().map_or(&[][..], |gathered| &gathered.clock_steps);
    let (found, not_finite) = found_signals(&chosen.choices, &columns, steps, &mut notes);
    notes.extend(gathered.iter().flat_map(|gathered| gathered.notes.clone()));
    notes.extend(chosen.choices.notes.iter().cloned());
    let missing = |signal: &SignalName| Missing { signal: *signal, required: signal.is_required(), candidates: open.nearest(*signal) };
    let span_ns = gathered.as_ref().and_then(|gathered| gathered.span_ns);
    let span_s = span_ns.map(|(first, last)| last.saturating_sub(first) as f64 / NS_PER_S);
    let topic = |(k, head): (usize, &Head)| {
        let messages = gathered.as_ref().filter(|_| chosen.columns.contains(&k)).map(|gathered| gathered.counts[k]);
        Topic {
            topic: head.name.clone(),
            schema: None,
            schema_encoding: None,
            encoding: "column".to_owned(),
            messages,
            rate_hz: messages.zip(span_s).filter(|(_, span)| *span > 0.0).map(|(messages, span)| messages as f64 / span),
        }
    };
    Ok(LogSurvey {
        file,
        bytes: input.length(),
        table: Some(open.text()),
        library: String::new(),
        profile: String::new(),
        indexed: false,
        chunks: 0,
        compression: Vec::new(),
        start_ns: span_ns.and_then(|(first, _)| u64::try_from(first).ok()),
        end_ns: span_ns.and_then(|(_, last)| u64::try_from(last).ok()),
        messages: gathered.as_ref().map(|gathered| gathered.loss.messages_read).or(open.table.count()),
        attachments: 0,
        metadata: Vec::new(),
        topics: open.heads.iter().enumerate().map(topic).collect(),
        signals: found,
        missing: chosen.choices.missing.iter().map(missing).collect(),
        checked: gathered.is_some(),
        loss: gathered.map(|gathered| Loss { not_finite, ..gathered.loss }),
        notes,
    })
}

/// Rates do not depend on the vehicle.
fn any_vehicle() -> Vehicle {
    Vehicle { wheelbase_m: 1.0, wheel_radius_m: 1.0, test_angle_deg: 90.0, torque_limit_nm: None, torque_full_scale_nm: Some(1.0) }
}

/// What the messages of a signal mean.
fn kind(signal: &Signal) -> MessageKind {
    let time_s: Vec<f64> = signal.time_ns.iter().map(|t| t.saturating_sub(signal.time_ns[0]) as f64 / NS_PER_S).collect();
    MessageKind::of(&time_s, &signal.value)
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
