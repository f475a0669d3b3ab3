//! The parts of a log's structure: blocks, schemas, channels.

use crate::log::file::channel_set::ChannelSet;
use crate::text::owned_name;
use mcap::records::{Channel, Record};
use std::collections::BTreeMap;
use std::sync::Arc;

/// A section of the file that holds messages.
#[derive(Debug, Clone)]
pub(crate) struct Block {
    /// Position of the chunk's body, or of the first record of the run.
    pub offset: u64,
    /// Length of the chunk's body, or of the run.
    pub length: u64,
    pub kind: BlockKind,
    /// Its channels according to the message indexes; `None` if there are none.
    pub channels: Option<ChannelSet>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum BlockKind {
    /// A chunk.
    Chunk,
    /// A chunk that is cut by the end of the file: the part that can be decompressed is used.
    CutChunk,
    /// Records outside chunks.
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
    /// Adds a schema or channel record, its names as they are shown ([`owned_name`]).
    /// The first description of an id counts: the specification forbids another.
    /// Returns whether it was new.
    pub(crate) fn learn(&mut self, record: Record<'_>) -> bool {
        match record {
            Record::Schema { header, data } => {
                let schema =
                    || Arc::new(Schema { name: owned_name(header.name), encoding: owned_name(header.encoding), data: data.into_owned() });
                let new = header.id != 0 && !self.schemas.contains_key(&header.id);
                if new {
                    self.schemas.insert(header.id, schema());
                }
                new
            }
            Record::Channel(mut channel) => {
                channel.topic = owned_name(channel.topic);
                channel.message_encoding = owned_name(channel.message_encoding);
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
