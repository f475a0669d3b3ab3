//! The outer structure of a log: its channels and the positions of its messages.
//!
//! A valid summary lists the chunks; then only the gaps between them are scanned. Otherwise the whole file is scanned at its top level.
//! In both cases the result is a list of [`Block`]s, read later in parallel.

use crate::log::file::channel_set::{ChannelSet, ChannelSets};
use crate::log::file::input::LogInput;
use crate::log::file::record::MAX_SMALL;
use crate::log::file::structure::{Block, Inventory};
use crate::log::limits::MOST_DESCRIPTION;
use crate::log::loss::{Damage, Why};
use crate::log::{Error, Result};
use crate::text::owned_name;
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
    /// The sets of channels, shared by the blocks.
    pub sets: ChannelSets,
    pub statistics: Option<Statistics>,
    /// Metadata records by name. If two have the same name, the later one counts.
    pub metadata: BTreeMap<String, BTreeMap<String, String>>,
    /// Size of all metadata records [bytes], those that are not kept included.
    pub metadata_size: u64,
    pub attachments: u64,
    /// Whether the summary's chunk index was valid and used.
    pub indexed: bool,
    /// The data section's checksum, if the writer computed one, and the end of the section.
    pub data_end: Option<(u64, u32)>,
    /// Whether the scan found a footer. Without one, the end of the file is missing.
    pub footer: bool,
    pub damage: Vec<Damage>,
}

impl Container {
    /// Whether message indexes list the channels of every block, and all of them are described.
    pub(crate) fn is_listed(&self) -> bool {
        let described = |channels: &ChannelSet| channels.iter().all(|id| self.inventory.channels.contains_key(id));
        !self.blocks.is_empty() && self.blocks.iter().all(|block| block.channels.as_ref().is_some_and(described))
    }

    /// Whether the descriptions are within the memory that is kept for them.
    ///
    /// # Errors
    /// They are not.
    pub(crate) fn expect_bounded(&self) -> Result<()> {
        let is_overfull = self.inventory.is_overfull() || self.metadata_size > MOST_DESCRIPTION;
        if is_overfull { Err(Error::TooMuchDescription { allowed: MOST_DESCRIPTION }) } else { Ok(()) }
    }

    /// Adds channels and schemas found inside chunks; returns whether a channel was new.
    pub(crate) fn learn(&mut self, learned: Inventory) -> bool {
        self.inventory.merge(learned)
    }

    /// Adds a record found at the top level that is neither a message nor a chunk.
    pub(crate) fn take(&mut self, record: Record<'_>) {
        match record {
            Record::Header(header) => {
                self.library = owned_name(header.library);
                self.profile = owned_name(header.profile);
            }
            Record::Metadata(metadata) => {
                let size: usize = metadata.metadata.iter().map(|(key, value)| key.len() + value.len()).sum();
                self.metadata_size += size as u64;
                if self.metadata_size <= MOST_DESCRIPTION {
                    self.metadata.insert(owned_name(metadata.name), metadata.metadata);
                }
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

/// Largest record that is read completely, except chunks, messages and attachments.
pub(crate) fn is_small(length: u64) -> bool {
    length <= MAX_SMALL
}
