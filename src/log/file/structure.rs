//! The parts of a log's structure: blocks, schemas, channels.

use crate::log::file::channel_set::ChannelSet;
use crate::log::limits::MOST_DESCRIPTION;
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
    /// Size of the schemas and of the channels' metadata [bytes].
    size: u64,
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
                    self.add_schema(header.id, schema());
                }
                new
            }
            Record::Channel(mut channel) => {
                channel.topic = owned_name(channel.topic);
                channel.message_encoding = owned_name(channel.message_encoding);
                let new = !self.channels.contains_key(&channel.id);
                if new {
                    self.add_channel(channel);
                }
                new
            }
            _ => false,
        }
    }

    /// Adds what is new in `other`; returns whether a channel was.
    pub(crate) fn merge(&mut self, other: Self) -> bool {
        let before = self.channels.len();
        for (id, schema) in other.schemas {
            if !self.schemas.contains_key(&id) {
                self.add_schema(id, schema);
            }
        }
        for channel in other.channels.into_values() {
            if !self.channels.contains_key(&channel.id) {
                self.add_channel(channel);
            }
        }
        self.channels.len() > before
    }

    /// Whether the descriptions take more than is kept: what came after that is missing.
    pub(crate) fn is_overfull(&self) -> bool {
        self.size > MOST_DESCRIPTION
    }

    fn add_schema(&mut self, id: u16, schema: Arc<Schema>) {
        self.size += schema.data.len() as u64;
        if !self.is_overfull() {
            self.schemas.insert(id, schema);
        }
    }

    fn add_channel(&mut self, channel: Channel) {
        self.size += channel.metadata.iter().map(|(key, value)| (key.len() + value.len()) as u64).sum::<u64>();
        if !self.is_overfull() {
            self.channels.insert(channel.id, channel);
        }
    }

    pub(crate) fn schema(&self, channel: &Channel) -> Option<&Arc<Schema>> {
        self.schemas.get(&channel.schema_id)
    }
}
