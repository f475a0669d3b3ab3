//! The outer structure of a log: which channels it has, and where its messages lie.
//!
//! With a sound summary the chunks are known at once and only the gaps between them are scanned; otherwise the whole file is scanned at
//! its top level. Either way the result is a list of [`Block`]s, read later in parallel.

use crate::log::{Error, Result};
use crate::log::file::{scan, summary};
use crate::log::file::channel_set::{ChannelSet, ChannelSets};
use crate::log::file::input::Input;
use crate::log::file::loss::{Damage, Why};
use crate::log::file::record::{MAGIC, MAX_SMALL, PREFIX};
use mcap::records::{Channel, Record, Statistics};
use std::collections::BTreeMap;
use std::sync::Arc;

/// A stretch of the file that holds messages.
#[derive(Debug, Clone)]
pub(crate) struct Block {
    /// Position of the chunk's body, or of the first record of the run.
    pub offset: u64,
    /// Length of the chunk's body, or of the run.
    pub length: u64,
    pub kind: BlockKind,
    /// Its channels as the message indexes tell; `None` when there are none.
    pub channels: Option<ChannelSet>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum BlockKind {
    /// A chunk.
    Chunk,
    /// A chunk that the end of the file cuts off: what can be decompressed is used.
    CutChunk,
    /// Records that lie outside of chunks.
    Loose,
}

/// A schema as the log stores it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Schema {
    pub name: String,
    pub encoding: String,
    pub data: Vec<u8>,
}

/// Channels and schemas of a log.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(crate) struct Inventory {
    pub schemas: BTreeMap<u16, Arc<Schema>>,
    pub channels: BTreeMap<u16, Channel>,
}

impl Inventory {
    /// Takes in a schema or channel record; the first description of an id counts, as the specification forbids another.
    /// Says whether it was new.
    pub(crate) fn learn(&mut self, record: Record<'_>) -> bool {
        match record {
            Record::Schema { header, data } => {
                let schema = || Arc::new(Schema { name: header.name, encoding: header.encoding, data: data.into_owned() });
                let new = header.id != 0 && !self.schemas.contains_key(&header.id);
                if new {
                    self.schemas.insert(header.id, schema());
                }
                new
            }
            Record::Channel(channel) => {
                let new = !self.channels.contains_key(&channel.id);
                if new {
                    self.channels.insert(channel.id, channel);
                }
                new
            }
            _ => false,
        }
    }

    pub(crate) fn schema(&self, channel: &Channel) -> Option<&Arc<Schema>> {
        self.schemas.get(&channel.schema_id)
    }
}

/// The outer structure of one log.
#[derive(Debug)]
pub(crate) struct Container {
    pub input: Arc<Input>,
    pub library: String,
    pub profile: String,
    pub inventory: Inventory,
    pub blocks: Vec<Block>,
    /// The sets of channels that the blocks share.
    pub sets: ChannelSets,
    pub statistics: Option<Statistics>,
    /// Metadata records by name; of two with one name the later counts.
    pub metadata: BTreeMap<String, BTreeMap<String, String>>,
    pub attachments: u64,
    /// Whether the summary's chunk index was sound and used.
    pub indexed: bool,
    /// The data section's checksum, if the writer computed one, and where the section ends.
    pub data_end: Option<(u64, u32)>,
    /// Whether the scan met a footer: without one, the end of the file is missing.
    pub footer: bool,
    pub damage: Vec<Damage>,
}

impl Container {
    /// Finds the structure of the log.
    ///
    /// # Errors
    /// A log that is empty or no MCAP file at all.
    pub(crate) fn open(input: Input) -> Result<Self> {
        let length = input.length();
        if length == 0 {
            return Err(Error::Empty);
        }
        let mut start = vec![0; length.min(16) as usize];
        input.read_at(0, &mut start).map_err(Error::Io)?;
        if !start.starts_with(MAGIC) {
            return Err(Error::NotMcap { hint: foreign(&start) });
        }
        let mut container = Self {
            input: Arc::new(input),
            library: String::new(),
            profile: String::new(),
            inventory: Inventory::default(),
            blocks: Vec::new(),
            sets: ChannelSets::default(),
            statistics: None,
            metadata: BTreeMap::new(),
            attachments: 0,
            indexed: false,
            data_end: None,
            footer: false,
            damage: Vec::new(),
        };
        match summary::read(&container.input) {
            Ok(Some(found)) if found.covers_messages() => {
                container.inventory = found.inventory;
                container.statistics = found.statistics;
                container.indexed = true;
                let mut at = MAGIC.len() as u64;
                for (block, index_length) in found.chunks {
                    let start = block.offset - PREFIX;
                    scan::run(&mut container, at, start);
                    let end = block.offset + block.length;
                    at = end.saturating_add(index_length);
                    container.blocks.push(block);
                    // an index length that does not lead to the next chunk is not believed: the records behind the chunk are walked
                    if at > found.start || !scan::is_record(&container.input, at, found.start) {
                        at = end;
                    }
                }
                scan::run(&mut container, at, found.start);
            }
            Ok(found) => {
                if let Some(found) = found {
                    container.statistics = found.statistics;
                    container.inventory = found.inventory;
                }
                scan::run(&mut container, MAGIC.len() as u64, length);
            }
            Err(damage) => {
                container.damage.push(damage);
                scan::run(&mut container, MAGIC.len() as u64, length);
            }
        }
        if !container.indexed && !container.footer && container.damage.iter().all(|damage| damage.why != Why::Truncated) {
            container.damaged(length, 0, Why::Truncated);
        }
        container.blocks.sort_by_key(|block| block.offset);
        container.damage.sort_by_key(|damage| damage.offset);
        Ok(container)
    }

    /// Whether message indexes list the channels of every block, and all of them are described.
    pub(crate) fn is_listed(&self) -> bool {
        let described = |channels: &ChannelSet| channels.iter().all(|id| self.inventory.channels.contains_key(id));
        !self.blocks.is_empty() && self.blocks.iter().all(|block| block.channels.as_ref().is_some_and(described))
    }

    /// Takes in channels and schemas found inside chunks; says whether a channel was new.
    pub(crate) fn learn(&mut self, learned: Inventory) -> bool {
        for (id, schema) in learned.schemas {
            self.inventory.schemas.entry(id).or_insert(schema);
        }
        let before = self.inventory.channels.len();
        for (id, channel) in learned.channels {
            self.inventory.channels.entry(id).or_insert(channel);
        }
        self.inventory.channels.len() > before
    }

    /// Takes in a record found at the top level that is not a message and not a chunk.
    pub(crate) fn take(&mut self, record: Record<'_>) {
        match record {
            Record::Header(header) => {
                self.library = header.library;
                self.profile = header.profile;
            }
            Record::Metadata(metadata) => {
                self.metadata.insert(metadata.name, metadata.metadata);
            }
            other => {
                self.inventory.learn(other);
            }
        }
    }

    /// The damage list, with a new entry.
    pub(crate) fn damaged(&mut self, offset: u64, bytes: u64, why: Why) {
        self.damage.push(Damage::new(offset, bytes, why));
    }
}

/// Largest record, other than chunks, messages and attachments, that is read whole.
pub(crate) fn is_small(length: u64) -> bool {
    length <= MAX_SMALL
}

/// What a file that is no MCAP probably is, and what helps.
fn foreign(start: &[u8]) -> &'static str {
    if start.starts_with(&[0x28, 0xb5, 0x2f, 0xfd]) {
        "it is compressed as a whole: unpack it with `zstd -d` first"
    } else if start.starts_with(b"SQLite format 3") {
        "it is a rosbag2 database: convert it with `ros2 bag convert` to MCAP first"
    } else if start.starts_with(b"#ROSBAG") {
        "it is a ROS 1 bag: convert it with `mcap convert` first"
    } else if start.starts_with(&[0x1f, 0x8b]) {
        "it is compressed as a whole: unpack it with `gunzip` first"
    } else {
        "its first bytes are not those of an MCAP file"
    }
}
