//! One pass over all messages of a log: it decodes the wanted values and counts all messages. It keeps no other data.
//!
//! Each thread runs one worker. The workers take blocks in file order, and their results are joined in file order. So the result does not
//! depend on the number of threads. No worker waits for another.

use crate::log::extract::column::Column;
use crate::log::extract::convert::Convert;
use crate::log::extract::extractor::Extractor;
use crate::log::extract::extractor::taken::Taken;
use crate::log::extract::stamp::StampPath;
use crate::log::file::block::{Scratch, load, lost};
use crate::log::file::container::Container;
use crate::log::file::record::{PREFIX, RawMessage, Records, parse};
use crate::log::file::structure::{Block, BlockKind, Inventory};
use crate::log::limits::{MOST_DESCRIPTION, MOST_VALUES};
use crate::log::loss::{Damage, Why};
use crate::log::timing::log_clock::{ClockStep, LEAST_STEP_NS};
use crate::log::timing::message_times::MessageTimes;
use crate::log::value::Raw;
use mcap::records::op;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

/// Samples of messages above this size are not kept [bytes].
const MAX_SAMPLE: usize = 1 << 20;
/// Number of blocks without a message index that are opened to find the channels of the log.
const BLIND_BLOCKS: usize = 4;

/// Places where the time of the log goes back that are kept: more are not caused by a clock.
const MOST_STEPS: usize = 100;

/// The wanted values of the messages of one channel.
#[derive(Debug)]
pub(crate) struct ChannelPlan {
    pub plan: Extractor,
    pub values: Vec<WantedValue>,
}

/// One wanted value of a channel.
#[derive(Debug)]
pub(crate) struct WantedValue {
    /// The column of the result that it fills.
    pub column: usize,
    pub slot: usize,
    pub stamp: Option<StampPath>,
    pub convert: Convert,
    /// A slice selects several values of each message.
    pub list: bool,
}

/// Messages of one channel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct PassTally {
    pub messages: u64,
    pub first_ns: u64,
    pub last_ns: u64,
}

/// Result of a pass.
#[derive(Debug, Default)]
pub(crate) struct Gathered {
    pub columns: Vec<Column>,
    pub tallies: BTreeMap<u16, PassTally>,
    /// For a channel that was not known before the pass: position of its first message, and the bytes of all its messages.
    pub undescribed: BTreeMap<u16, (u64, u64)>,
    /// Messages of wanted channels that do not fit their schema.
    pub broken: BTreeMap<u16, u64>,
    /// The reason why messages of a channel cannot be read at all.
    pub refused: BTreeMap<u16, &'static str>,
    pub damage: Vec<Damage>,
    /// Channels and schemas that were not known before the pass.
    pub learned: Inventory,
    /// The first payload of each channel that was not known before the pass.
    pub samples: BTreeMap<u16, Vec<u8>>,
    /// The first and the latest time of the log so far, and where it goes back.
    pub span_ns: Option<(i64, i64)>,
    pub clock_steps: Vec<ClockStep>,
    /// Checksum of the bytes of each block, as they were read; `None` where none could be.
    pub read_crc: Vec<Option<u32>>,
    /// Number of values, those beyond [`MOST_VALUES`] included, which are not kept.
    pub values: u64,
}

/// Reads every block; `columns` is the number of columns that `plans` fill. `progress` receives the number of bytes read.
pub(crate) fn all(container: &Container, plans: &BTreeMap<u16, ChannelPlan>, columns: usize, progress: &(dyn Fn(u64) + Sync)) -> Gathered {
    let known = Known::new(container, plans);
    let next = AtomicUsize::new(0);
    let joined = Mutex::new(Joined { whole: Gathered::new(columns), count: 0, early: BTreeMap::new() });
    let worker = || {
        let mut scratch = Scratch::default();
        loop {
            let number = next.fetch_add(1, Ordering::Relaxed);
            let Some(block) = container.blocks.get(number) else { return };
            let mut part = one(container, block, &known, columns, &mut scratch);
            part.read_crc = vec![scratch.read_crc];
            // a panic leaves no half-written data under this lock
            joined.lock().unwrap_or_else(PoisonError::into_inner).add(number, part);
            progress(block.length);
        }
    };
    rayon::scope(|scope| (0..rayon::current_num_threads()).for_each(|_| scope.spawn(|_| worker())));
    joined.into_inner().unwrap_or_else(PoisonError::into_inner).whole
}

/// The results of the blocks, joined in file order.
struct Joined {
    whole: Gathered,
    /// Number of blocks in `whole`.
    count: usize,
    /// Blocks that were ready before an earlier block.
    early: BTreeMap<usize, Gathered>,
}

impl Joined {
    fn add(&mut self, number: usize, part: Gathered) {
        if number != self.count {
            self.early.insert(number, part);
            return;
        }
        self.whole.append(part);
        self.count += 1;
        while let Some(part) = self.early.remove(&self.count) {
            self.whole.append(part);
            self.count += 1;
        }
    }
}

fn one(container: &Container, block: &Block, known: &Known<'_>, columns: usize, scratch: &mut Scratch) -> Gathered {
    let mut found = Gathered::new(columns);
    let data = match load(&container.input, block, scratch) {
        Ok(data) => data,
        Err(why) => {
            found.damage.push(lost(container, block, why));
            return found;
        }
    };
    let mut met: Vec<(PassTally, Taken<'_>)> = Vec::new();
    met.resize_with(known.places.len(), Default::default);
    let size = data.len();
    let mut records = Records::new(data);
    while let Some((opcode, body)) = records.next() {
        if opcode != op::MESSAGE {
            if let (op::SCHEMA | op::CHANNEL, Some(record)) = (opcode, parse(opcode, body)) {
                found.learned.learn(record);
            }
            continue;
        }
        let Some(message) = RawMessage::parse(body) else {
            found.damage.push(Damage::new(block.offset, body.len() as u64, Why::BrokenRecords));
            continue;
        };
        let Some((place, plan)) = known.get(message.channel) else {
            found.count(message.channel, PassTally::default().with(message.log_time_ns));
            // where the record begins; for a chunk, only the chunk's own position in the file is meaningful
            let inside = if block.kind == BlockKind::Loose { (size - records.left() - body.len()) as u64 } else { 0 };
            let lost = found.undescribed.entry(message.channel).or_insert((block.offset + inside - PREFIX, 0));
            lost.1 += PREFIX + body.len() as u64;
            if message.payload.len() <= MAX_SAMPLE {
                keep_sample(&mut found.samples, message.channel, || message.payload.to_vec());
            }
            continue;
        };
        let (tally, taken) = &mut met[place];
        *tally = tally.with(message.log_time_ns);
        found.log_time(nanoseconds(message.log_time_ns));
        if let Some(plan) = plan {
            found.decode(plan, &message, taken);
        }
    }
    for ((channel, _), (tally, _)) in known.places.iter().zip(met) {
        if tally.messages > 0 {
            found.count(*channel, tally);
        }
    }
    if records.left() > 0 && block.kind == BlockKind::Chunk {
        found.damage.push(Damage::new(block.offset, records.left() as u64, Why::BrokenRecords));
    }
    found
}

/// The described channels, found by their number without a search: the lookup runs once per message.
struct Known<'p> {
    /// One more than the place of each channel number; 0 where no channel is described.
    numbers: Vec<u16>,
    places: Vec<(u16, Option<&'p ChannelPlan>)>,
}

impl<'p> Known<'p> {
    fn new(container: &Container, plans: &'p BTreeMap<u16, ChannelPlan>) -> Self {
        let channels = &container.inventory.channels;
        let mut numbers = vec![0; channels.last_key_value().map_or(0, |(last, _)| usize::from(*last) + 1)];
        // no number is left for the last of 65536 channels: it counts as not described
        let places: Vec<_> = channels.keys().take(usize::from(u16::MAX)).map(|id| (*id, plans.get(id))).collect();
        for (place, (id, _)) in places.iter().enumerate() {
            numbers[usize::from(*id)] = place as u16 + 1;
        }
        Self { numbers, places }
    }

    fn get(&self, channel: u16) -> Option<(usize, Option<&'p ChannelPlan>)> {
        let place = usize::from(*self.numbers.get(usize::from(channel))?).checked_sub(1)?;
        Some((place, self.places[place].1))
    }
}

impl Default for PassTally {
    fn default() -> Self {
        Self { messages: 0, first_ns: u64::MAX, last_ns: 0 }
    }
}

impl PassTally {
    /// The tally with one more message.
    fn with(self, time_ns: u64) -> Self {
        Self { messages: self.messages + 1, first_ns: self.first_ns.min(time_ns), last_ns: self.last_ns.max(time_ns) }
    }

    fn add(&mut self, other: Self) {
        self.messages += other.messages;
        self.first_ns = self.first_ns.min(other.first_ns);
        self.last_ns = self.last_ns.max(other.last_ns);
    }
}

impl Gathered {
    fn new(columns: usize) -> Self {
        Self { columns: vec![Column::default(); columns], ..Self::default() }
    }

    fn count(&mut self, channel: u16, tally: PassTally) {
        self.tallies.entry(channel).and_modify(|sum| sum.add(tally)).or_insert(tally);
    }

    fn decode<'a>(&mut self, plan: &ChannelPlan, message: &RawMessage<'a>, taken: &mut Taken<'a>) {
        if plan.plan.decode(message.payload, taken).is_none() {
            *self.broken.entry(message.channel).or_default() += 1;
            self.refused.extend(plan.plan.refusal(message.payload).map(|reason| (message.channel, reason)));
            return;
        }
        let log_time_ns = nanoseconds(message.log_time_ns);
        for wanted in &plan.values {
            let times = || MessageTimes {
                stamp_ns: wanted.stamp.and_then(|stamp| stamp.time_ns(taken)).unwrap_or(0),
                publish_ns: nanoseconds(message.publish_time_ns),
                log_ns: log_time_ns,
            };
            if wanted.list {
                let list = taken.list(wanted.slot).iter().map(|raw| wanted.convert.apply(&Raw::Number(*raw)).unwrap_or(f64::NAN));
                self.columns[wanted.column].push_list(times(), list);
                continue;
            }
            let Some(value) = wanted.convert.apply(taken.get(wanted.slot)) else { continue };
            if !value.is_finite() {
                self.columns[wanted.column].not_finite += 1;
                continue;
            }
            self.columns[wanted.column].push(times(), value);
        }
    }

    /// Notes the time of the next message.
    fn log_time(&mut self, time_ns: i64) {
        let (first, latest) = self.span_ns.unwrap_or((time_ns, time_ns));
        if time_ns < latest.saturating_sub(LEAST_STEP_NS) {
            let values = self.columns.iter().map(|column| column.value.len()).collect();
            self.clock_steps.push(ClockStep { before_ns: latest, after_ns: time_ns, values });
            self.clock_steps.truncate(MOST_STEPS);
            self.span_ns = Some((first, time_ns));
        } else {
            self.span_ns = Some((first, latest.max(time_ns)));
        }
    }

    fn append(&mut self, part: Self) {
        self.read_crc.extend(part.read_crc);
        if let Some((first, latest)) = part.span_ns {
            self.log_time(first);
            let so_far: Vec<usize> = self.columns.iter().map(|column| column.value.len()).collect();
            self.clock_steps.extend(part.clock_steps.into_iter().map(|step| step.after(&so_far)));
            self.clock_steps.truncate(MOST_STEPS);
            self.span_ns = self.span_ns.map(|(first, _)| (first, latest));
        }
        let more: usize = part.columns.iter().map(|column| column.value.len()).sum();
        self.values += more as u64;
        if self.values <= MOST_VALUES {
            for (whole, part) in self.columns.iter_mut().zip(part.columns) {
                whole.append(part);
            }
        }
        for (channel, tally) in part.tallies {
            self.count(channel, tally);
        }
        for (channel, count) in part.broken {
            *self.broken.entry(channel).or_default() += count;
        }
        for (channel, (offset, bytes)) in part.undescribed {
            self.undescribed.entry(channel).or_insert((offset, 0)).1 += bytes;
        }
        self.refused.extend(part.refused);
        self.damage.extend(part.damage);
        for (id, payload) in part.samples {
            keep_sample(&mut self.samples, id, || payload);
        }
        self.learned.merge(part.learned);
    }
}

/// Keeps the first message of a channel, as long as all of them together are small.
fn keep_sample(samples: &mut BTreeMap<u16, Vec<u8>>, id: u16, payload: impl FnOnce() -> Vec<u8>) {
    if !samples.contains_key(&id) && samples.values().map(|kept| kept.len() as u64).sum::<u64>() < MOST_DESCRIPTION {
        samples.insert(id, payload());
    }
}

/// Log times after the year 2262 come from a broken clock.
fn nanoseconds(time: u64) -> i64 {
    i64::try_from(time).unwrap_or(i64::MAX)
}

/// Opens as few blocks as needed to see one message of every channel, and adds the channels that only chunks describe.
/// Returns a payload of each channel.
pub(crate) fn explore(container: &mut Container) -> BTreeMap<u16, Vec<u8>> {
    let mut samples: BTreeMap<u16, Vec<u8>> = BTreeMap::new();
    let mut tried: BTreeSet<u16> = BTreeSet::new();
    let mut blind = BLIND_BLOCKS;
    let mut scratch = Scratch::default();
    let mut learned = Inventory::default();
    for block in &container.blocks {
        match &block.channels {
            Some(channels) if channels.iter().all(|id| tried.contains(id)) => continue,
            Some(_) => {}
            None if blind == 0 => continue,
            None => blind -= 1,
        }
        let Ok(data) = load(&container.input, block, &mut scratch) else { continue };
        tried.extend(block.channels.iter().flat_map(|channels| channels.iter()));
        for (opcode, body) in Records::new(data) {
            if opcode == op::MESSAGE {
                if let Some(message) = RawMessage::parse(body).filter(|message| message.payload.len() <= MAX_SAMPLE) {
                    keep_sample(&mut samples, message.channel, || message.payload.to_vec());
                }
            } else if let (op::SCHEMA | op::CHANNEL, Some(record)) = (opcode, parse(opcode, body)) {
                learned.learn(record);
            }
        }
    }
    container.learn(learned);
    samples
}
