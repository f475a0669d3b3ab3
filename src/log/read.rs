//! Reads one log: structure, choice of signals, one pass over the messages, and the report of the lost data.

use crate::log::columns;
use crate::log::columns::TablePass;
use crate::log::columns::table::TableFormat;
use crate::log::extract::column::Column;
use crate::log::extract::message_pass;
use crate::log::extract::message_pass::Gathered;
use crate::log::file::container::Container;
use crate::log::file::input::LogInput;
use crate::log::file::open::open;
use crate::log::file::structure::BlockKind;
use crate::log::find::candidates::Candidates;
use crate::log::find::resolve;
use crate::log::find::resolve::{Choices, PathChoice};
use crate::log::limits::MOST_VALUES;
use crate::log::loss::{Damage, Loss, Why};
use crate::log::recording::{Origin, Recording, Signal, Signals};
use crate::log::reference_path::{Lists, polylines};
use crate::log::rosbag2::expect_no_database;
use crate::log::signal_map::{SignalName, SignalSpec, VehicleOverrides};
use crate::log::timing::log_clock::ClockStep;
use crate::log::timing::message_times::MessageTimes;
use crate::log::{Error, Result, Source};
use crate::map::{LogRef, Vehicle};
use crate::text::shown;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Largest number of passes over a log: one, and another if it found channels that were not known before.
const MAX_PASSES: usize = 3;

/// Reads one log. `progress` receives, from several threads, the number of bytes read since the last call; the sum is about the size of
/// the file.
///
/// # Errors
/// The file is not a log or holds no message, a required signal is missing or has no values, or the vehicle is not known.
/// Damage is not an error as long as usable data remain: see [`Recording::loss`].
pub fn read(path: &Path, source: &Source, overrides: &VehicleOverrides, progress: &(dyn Fn(u64) + Sync)) -> Result<Recording> {
    Ok(part(path, true, &SignalName::ALL, source, overrides, progress)?.finish())
}

/// Like [`read`], but for the signals of the lateral calibration ([`SignalName::LATERAL`]): they are in [`Signals::lateral`], the others
/// are empty.
///
/// # Errors
/// As [`read`].
pub(crate) fn read_lateral(
    path: &Path,
    source: &Source,
    overrides: &VehicleOverrides,
    progress: &(dyn Fn(u64) + Sync),
) -> Result<Recording> {
    let name = path.file_name().map(shown).unwrap_or_default();
    Ok(read_input(LogInput::open(path)?, (name, path.to_owned(), true), &SignalName::LATERAL, source, overrides, progress)?.finish())
}

/// Like `read_lateral`, from memory, under the name `name`.
///
/// # Errors
/// As [`read`].
pub fn read_lateral_bytes(bytes: Vec<u8>, name: &str, source: &Source, overrides: &VehicleOverrides) -> Result<Recording> {
    let named = (name.to_owned(), PathBuf::from(name), true);
    Ok(read_input(LogInput::Memory(bytes), named, &SignalName::LATERAL, source, overrides, &|_| {})?.finish())
}

/// Like [`read`], but without the hash of the file. On a large log the hash takes longer than all other work.
///
/// # Errors
/// As [`read`].
pub fn read_signals(path: &Path, source: &Source, overrides: &VehicleOverrides, progress: &(dyn Fn(u64) + Sync)) -> Result<Recording> {
    Ok(part(path, false, &SignalName::ALL, source, overrides, progress)?.finish())
}

/// Reads a log from memory, under the name `name`; otherwise like [`read`].
///
/// # Errors
/// As [`read`].
pub fn read_bytes(bytes: Vec<u8>, name: &str, source: &Source, overrides: &VehicleOverrides) -> Result<Recording> {
    Ok(read_input(LogInput::Memory(bytes), (name.to_owned(), PathBuf::from(name), true), &SignalName::ALL, source, overrides, &|_| {})?
        .finish())
}

/// One file of a recording, before the corrections that need the values of all files.
pub(crate) struct RecordingPart {
    pub recording: Recording,
    /// Whether any signal was found by name.
    pub guessed: bool,
    /// Signals whose unit is in no name.
    pub unnamed: Vec<SignalName>,
    /// Number of files.
    pub files: usize,
    /// The times of the values of each signal, in the order of the log.
    pub times: BTreeMap<SignalName, Vec<MessageTimes>>,
    /// The first and the latest time of the log, and where it goes back.
    pub span_ns: Option<(i64, i64)>,
    pub clock_steps: Vec<ClockStep>,
}

/// Reads the signals `wanted` of one file, with its hash if `hashed`.
pub(crate) fn part(
    path: &Path,
    hashed: bool,
    wanted: &[SignalName],
    source: &Source,
    overrides: &VehicleOverrides,
    progress: &(dyn Fn(u64) + Sync),
) -> Result<RecordingPart> {
    let name = path.file_name().map(shown).unwrap_or_default();
    read_input(LogInput::open(path)?, (name, path.to_owned(), hashed), wanted, source, overrides, progress)
}

fn read_input(
    input: LogInput,
    (file, path, hashed): (String, PathBuf, bool),
    wanted: &[SignalName],
    source: &Source,
    overrides: &VehicleOverrides,
    progress: &(dyn Fn(u64) + Sync),
) -> Result<RecordingPart> {
    expect_no_database(&path, &input)?;
    if let Some(format) = TableFormat::of(&path, &input)? {
        return read_table(format, &Arc::new(input), (file, path, hashed), wanted, source, overrides, progress);
    }
    let mut container = open(input)?;
    let input = container.input.clone();
    // the hash reads every byte again: it runs in parallel with the decoding, and each is half of the progress
    let half = |bytes: u64| progress(if hashed { bytes.div_ceil(2) } else { bytes });
    let ranges: Vec<(u64, u64)> = container.blocks.iter().map(|block| (block.offset, block.length)).collect();
    let (hash, read) = rayon::join(
        || if hashed { input.sha256(&ranges, &half).map(Some) } else { Ok(None) },
        || pass(&mut container, wanted, source, overrides, &half),
    );
    if hashed {
        input.expect_unchanged()?; // before the errors that a change causes
    }
    let hash = hash?;
    let ReadPass { choices, gathered, vehicle } = read?;
    let sha256 = match hash {
        Some((sha256, sums)) if are_of(&gathered.read_crc, &sums) => sha256,
        Some(_) => return Err(Error::Changed),
        None => String::new(),
    };
    let loss = loss(&container, &gathered);
    let of_choice = |choice: &PathChoice, not_finite: u64| {
        let of_topic = |id: &&u16| container.inventory.channels.get(id).is_some_and(|channel| channel.topic == choice.spec.path.topic);
        let messages = gathered.tallies.iter().filter(|(id, _)| of_topic(id)).map(|(_, tally)| tally.messages).sum();
        let broken: u64 = gathered.broken.iter().filter(|(id, _)| of_topic(id)).map(|(_, count)| *count).sum();
        let refused = gathered.refused.iter().find(|(id, _)| of_topic(id)).map(|(_, reason)| format!(": {reason}")).unwrap_or_default();
        let reason = match (not_finite, broken) {
            (0, 0) => "none holds this field".to_owned(),
            (nan, 0) => format!("{nan} hold NaN or infinity"),
            (nan, broken) => format!("{broken} do not fit their schema{refused}, {nan} hold NaN or infinity"),
        };
        (messages, reason)
    };
    let source = LogRef { sha256, file, bytes: input.length(), loss: None };
    let (span_ns, clock_steps) = (gathered.span_ns, gathered.clock_steps);
    let read = ReadColumns { choices, columns: gathered.columns, vehicle: vehicle.vehicle()?, loss, span_ns, clock_steps };
    read.into_part(source, path, of_choice)
}

/// Reads the signals of a table.
fn read_table(
    format: TableFormat,
    input: &Arc<LogInput>,
    (file, path, hashed): (String, PathBuf, bool),
    wanted: &[SignalName],
    source: &Source,
    overrides: &VehicleOverrides,
    progress: &(dyn Fn(u64) + Sync),
) -> Result<RecordingPart> {
    let half = |bytes: u64| progress(if hashed { bytes.div_ceil(2) } else { bytes });
    let whole = [(0, input.length())];
    let (hash, read) = rayon::join(
        || if hashed { input.sha256(&whole, &half).map(Some) } else { Ok(None) },
        || columns::read(format, input, wanted, source, overrides, &half),
    );
    if hashed {
        input.expect_unchanged()?; // before the errors that a change causes
    }
    let hash = hash?;
    let TablePass { chosen, gathered, vehicle, notes } = read?;
    let sha256 = match hash {
        Some((sha256, sums)) if are_of(&[gathered.crc], &sums) => sha256,
        Some(_) => return Err(Error::Changed),
        None => String::new(),
    };
    let mut choices = chosen.choices;
    choices.notes.splice(0..0, notes.into_iter().chain(gathered.notes));
    let (rows, misread) = (gathered.loss.messages_read, gathered.loss.broken_messages.clone());
    let of_choice = |choice: &PathChoice, not_finite: u64| {
        let reason = match (not_finite, misread.get(&choice.spec.path.to_string())) {
            (0, None) => "all of its cells are empty".to_owned(),
            (infinite, None) => format!("{infinite} hold infinity"),
            (infinite, Some(misread)) => format!("{misread} are no number, {infinite} hold infinity"),
        };
        (rows, reason)
    };
    let source = LogRef { sha256, file, bytes: input.length(), loss: None };
    let (span_ns, clock_steps) = (gathered.span_ns, gathered.clock_steps);
    ReadColumns { choices, columns: gathered.columns, vehicle, loss: gathered.loss, span_ns, clock_steps }
        .into_part(source, path, of_choice)
}

/// The values of the chosen signals, wherever they come from.
struct ReadColumns {
    choices: Choices,
    columns: Vec<Column>,
    vehicle: Vehicle,
    loss: Loss,
    span_ns: Option<(i64, i64)>,
    clock_steps: Vec<ClockStep>,
}

impl ReadColumns {
    /// The values as a recording; `of_choice` gives the number of messages of a signal without a value, and the reason, from the number of
    /// those that are not finite.
    ///
    /// # Errors
    /// A required signal has no value.
    fn into_part(self, source: LogRef, path: PathBuf, of_choice: impl Fn(&PathChoice, u64) -> (u64, String)) -> Result<RecordingPart> {
        let Self { choices, columns, vehicle, mut loss, span_ns, clock_steps } = self;
        let mut notes = choices.notes;
        let unnamed: Vec<SignalName> = choices.found.iter().filter(|choice| choice.is_guess).map(|choice| choice.signal).collect();
        let mut signals = Signals::default();
        let mut origins = Vec::new();
        let mut reference: Vec<Lists> = Vec::new();
        let mut times = BTreeMap::new();
        let mut kept = Vec::new();
        for (number, (mut column, choice)) in columns.into_iter().zip(choices.found).enumerate() {
            let (signal, not_finite) = (choice.signal, column.not_finite);
            if not_finite > 0 {
                loss.not_finite.insert(signal.key().to_owned(), not_finite);
            }
            if column.is_empty() {
                let (messages, reason) = of_choice(&choice, not_finite);
                let path = choice.spec.path.to_string();
                if signal.is_required() {
                    return Err(Error::NoValues { signal: signal.key(), path, messages, reason });
                }
                notes.push(format!("{signal} is left out: {path} gives no value: of {messages} message(s), {reason}"));
                continue;
            }
            origins.push(Origin {
                signal,
                path: choice.spec.path.to_string(),
                unit: choice.spec.unit.name().to_owned(),
                reason: choice.reason,
                values: column.len(),
            });
            if choice.spec.path.is_list() {
                reference.push(std::mem::take(&mut column.lists));
                continue;
            }
            let SignalSpec { relative_to_gear, unsigned, .. } = choice.spec;
            signals.set(signal, Signal { value: column.value, relative_to_gear, unsigned, ..Signal::default() });
            kept.push((signal, number));
            times.insert(signal, column.times);
        }
        if let [x, y] = &reference[..] {
            signals.reference_paths = polylines(x, y);
        }
        // the steps count the values of the signals in the order of their names, as `times` has them
        kept.sort_unstable();
        let of_kept = |step: ClockStep| ClockStep { values: kept.iter().map(|(_, column)| step.values[*column]).collect(), ..step };
        let clock_steps = clock_steps.into_iter().map(of_kept).collect();
        let recording = Recording { source, path, vehicle, signals, origins, loss, notes, clock_notes: Vec::new() };
        Ok(RecordingPart { recording, guessed: choices.guessed, unnamed, files: 1, times, span_ns, clock_steps })
    }
}

/// Whether the blocks that were used are those that were hashed, by the checksums of both.
fn are_of(used: &[Option<u32>], hashed: &[u32]) -> bool {
    used.iter().zip(hashed).all(|(used, hashed)| used.is_none_or(|used| used == *hashed))
}

/// Result of a pass over the messages.
pub(crate) struct ReadPass {
    pub choices: Choices,
    pub gathered: Gathered,
    pub vehicle: VehicleOverrides,
}

fn pass(
    container: &mut Container,
    wanted: &[SignalName],
    source: &Source,
    overrides: &VehicleOverrides,
    progress: &(dyn Fn(u64) + Sync),
) -> Result<ReadPass> {
    let mut samples = message_pass::explore(container);
    container.expect_bounded()?;
    let from_map = match source {
        Source::Map(map) => map.vehicle,
        Source::Preset(_) | Source::Detect => VehicleOverrides::default(),
    };
    let from_log = if from_map.is_empty() { VehicleOverrides::from_metadata(&container.metadata)? } else { VehicleOverrides::default() };
    let vehicle = overrides.or(from_map).or(from_log);
    for number in 1.. {
        let candidates = Candidates::new(container, &samples);
        let chosen = resolve::choose(source, wanted, container, &candidates).and_then(|mut choices| {
            required(&choices, container, &candidates)?;
            let vehicle = vehicle.vehicle()?;
            resolve::expect_full_scale(&choices, &vehicle)?;
            let plans = resolve::plans(&mut choices, container, &samples, &vehicle)?;
            Ok((choices, plans))
        });
        // unlisted chunks may hold more channels: a missing channel is an error only when all chunks have been read
        let (choices, plans, error) = match chosen {
            Ok((choices, plans)) => (choices, plans, None),
            Err(error) if container.is_listed() => return Err(error),
            Err(error) => (Choices::default(), BTreeMap::new(), Some(error)),
        };
        let mut gathered = message_pass::all(container, &plans, choices.found.len(), progress);
        if gathered.values > MOST_VALUES {
            return Err(Error::TooManyValues { allowed: MOST_VALUES });
        }
        if gathered.tallies.is_empty() {
            let damage = loss(container, &gathered).summary();
            return Err(Error::NoMessages { damage });
        }
        let new = container.learn(std::mem::take(&mut gathered.learned));
        container.expect_bounded()?;
        if !new || number == MAX_PASSES {
            return error.map_or(Ok(ReadPass { choices, gathered, vehicle }), Err);
        }
        for (id, payload) in std::mem::take(&mut gathered.samples) {
            samples.entry(id).or_insert(payload);
        }
    }
    unreachable!("the loop returns in its last pass")
}

/// Whether every required signal has a path.
fn required(choices: &Choices, container: &Container, candidates: &Candidates<'_>) -> Result<()> {
    match choices.missing.iter().find(|signal| signal.is_required()) {
        Some(signal) => {
            let topics = container.inventory.channels.values().map(|channel| channel.topic.clone()).collect();
            Err(Error::MissingSignal { signal: signal.key(), candidates: resolve::nearest(*signal, candidates.all()), topics })
        }
        None => Ok(()),
    }
}

/// The report of the read and the lost data.
pub(crate) fn loss(container: &Container, gathered: &Gathered) -> Loss {
    let topic = |id: &u16| container.inventory.channels.get(id).map_or_else(|| format!("channel {id}"), |channel| channel.topic.clone());
    let mut places: Vec<Damage> = container.damage.iter().chain(&gathered.damage).cloned().collect();
    if places.is_empty() {
        places.extend(data_damage(container));
    }
    let mut read = 0;
    for (id, tally) in &gathered.tallies {
        if container.inventory.channels.contains_key(id) {
            read += tally.messages;
        } else {
            let (offset, bytes) = gathered.undescribed.get(id).copied().unwrap_or_default();
            let mut damage = Damage::new(offset, bytes, Why::NoChannel { channel: *id });
            damage.messages = Some(tally.messages);
            damage.channels.insert(*id, tally.messages);
            places.push(damage);
        }
    }
    places.sort_by_key(|damage| damage.offset);
    for damage in &mut places {
        let mut topics: Vec<String> = damage.channels.keys().map(topic).collect();
        topics.sort();
        topics.dedup();
        damage.topics = topics;
    }
    // the log's own count is the best source; the indexes of lost chunks are the next
    let counted = container.statistics.as_ref().map(|statistics| statistics.message_count.saturating_sub(read));
    let indexed = places.iter().map(|damage| damage.messages).sum::<Option<u64>>();
    let messages_lost = if places.is_empty() { Some(counted.unwrap_or(0)) } else { counted.or(indexed) };
    Loss {
        messages_read: read,
        messages_lost,
        bytes_lost: places.iter().map(|damage| damage.bytes).sum(),
        places,
        broken_messages: gathered.broken.iter().map(|(id, count)| (topic(id), *count)).collect(),
        not_finite: BTreeMap::new(),
    }
}

/// Records outside chunks have only the checksum of the whole data section, if the writer computed one.
fn data_damage(container: &Container) -> Option<Damage> {
    let (end, saved) = container.data_end.filter(|(_, saved)| *saved != 0)?;
    if container.blocks.iter().all(|block| block.kind == BlockKind::Chunk) {
        return None;
    }
    let calculated = container.input.crc(end).ok()?;
    (calculated != saved).then(|| Damage::new(0, 0, Why::DataCrc { saved, calculated }))
}
