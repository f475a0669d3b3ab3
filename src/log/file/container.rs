//! The outer structure of a log: which channels it has, and where its messages lie.
//!
//! With a sound summary the chunks are known at once and only the gaps between them are scanned; otherwise the whole file is scanned at
//! its top level. Either way the result is a list of [`Block`]s, read later in parallel.

use crate::log::file::channel_set::{ChannelSet, ChannelSets};
use crate::log::file::input::LogInput;
use crate::log::file::record::MAX_SMALL;
use crate::log::file::structure::{Block, Inventory};
use crate::log::loss::{Damage, Why};
use mcap::records::{Record, Statistics};
use std::collections::BTreeMap;
use std::sync::Arc;

/// The outer structure of one log.
#[derive(Debug)]
pub(crate) struct Container {
    pub input: Arc<LogInput>,
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
