//! The unusable parts of a log: position, number of bytes, channels and reason.

use crate::map::LogLoss;
use serde::Serialize;
use std::collections::BTreeMap;
use std::fmt;

/// The read and the lost data of one log.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Loss {
    /// Number of intact messages, on any channel.
    pub messages_read: u64,
    /// Number of messages known to be lost, from the indexes of damaged chunks or the log's own count. `None` if there is no count.
    pub messages_lost: Option<u64>,
    /// Bytes of the file that could not be used.
    pub bytes_lost: u64,
    /// The damaged places, in file order.
    pub places: Vec<Damage>,
    /// Number of skipped messages of wanted channels whose payload does not fit the schema, by topic.
    pub broken_messages: BTreeMap<String, u64>,
    /// Number of dropped values that were NaN or infinite, by signal.
    pub not_finite: BTreeMap<String, u64>,
}

impl Loss {
    /// Whether the file is damaged or messages could not be read; NaN values are not damage.
    pub fn is_damaged(&self) -> bool {
        !self.places.is_empty() || !self.broken_messages.is_empty()
    }

    /// The loss as `table1.json` reports it, or `None` when there is none.
    pub(crate) fn reported(&self) -> Option<LogLoss> {
        let unreadable_messages = self.broken_messages.values().sum();
        let loss = LogLoss {
            messages: self.messages_lost,
            unreadable_messages,
            places: self.places.len() as u64,
            bytes: self.bytes_lost,
            messages_read: self.messages_read,
        };
        (self.is_damaged() || self.messages_lost.is_some_and(|lost| lost > 0)).then_some(loss)
    }

    /// The loss in one sentence, or `None` when there is none.
    pub fn summary(&self) -> Option<String> {
        let mut parts = Vec::new();
        if let Some(first) = self.places.first() {
            let messages = self.messages_lost.map_or("an unknown number of".to_owned(), |n| n.to_string());
            parts.push(format!(
                "{messages} message(s) and {} byte(s) lost in {} damaged place(s), the first at byte {}: {}; {} message(s) are intact",
                self.bytes_lost,
                self.places.len(),
                first.offset,
                first.why,
                self.messages_read
            ));
        }
        for (topic, count) in &self.broken_messages {
            parts.push(format!("{count} message(s) of {topic} do not fit their schema and were skipped"));
        }
        (!parts.is_empty()).then(|| parts.join("; "))
    }
}

/// One damaged place of a log.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Damage {
    /// First byte of the place in the file.
    pub offset: u64,
    /// Number of unusable bytes; inside a chunk, uncompressed.
    pub bytes: u64,
    /// Number of lost messages, if an index gives it.
    pub messages: Option<u64>,
    /// Topics of those messages, as far as known.
    pub topics: Vec<String>,
    /// The kind of damage.
    #[serde(serialize_with = "as_text")]
    pub why: Why,
    /// Number of lost messages by channel; converted to topics when all channels are known.
    #[serde(skip)]
    pub(crate) channels: BTreeMap<u16, u64>,
}

impl Damage {
    pub(crate) fn new(offset: u64, bytes: u64, why: Why) -> Self {
        Self { offset, bytes, messages: None, topics: Vec::new(), why, channels: BTreeMap::new() }
    }
}

fn as_text<S: serde::Serializer>(why: &Why, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_str(why)
}

/// The reason why a part of a log cannot be used.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
#[allow(missing_docs)] // the message explains the fields
pub enum Why {
    /// The end of the file is missing.
    Truncated,
    /// Bytes that are not a record.
    NotARecord,
    /// The checksum of a chunk's records differs.
    ChunkCrc { saved: u32, calculated: u32 },
    /// The checksum of the data section differs, although every chunk is intact.
    DataCrc { saved: u32, calculated: u32 },
    /// The checksum of the summary differs, or it cannot be parsed.
    BadSummary(&'static str),
    /// The compressed records cannot be decompressed.
    Decompression(String),
    /// The chunk holds fewer or more bytes than it declares.
    ChunkSize { declared: u64, found: u64 },
    /// The chunk declares more than is allowed.
    TooLarge { declared: u64, allowed: u64 },
    /// The compression is not known.
    UnknownCompression(String),
    /// The chunk's header is broken.
    BadChunkHeader,
    /// A record inside a chunk does not fit into it.
    BrokenRecords,
    /// Messages of a channel that the log does not describe.
    NoChannel { channel: u16 },
    /// The file could not be read here.
    Io(String),
    /// A row of a table with fewer or more cells than its header.
    RaggedRow { line: u64, found: usize, expected: usize },
    /// A row of a table without a time.
    BadTime { place: Box<str>, found: Box<str> },
    /// Rows of a Parquet file that cannot be read.
    RowGroup { group: u32, rows: u64, reason: Box<str> },
}

impl fmt::Display for Why {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Truncated => f.write_str("the end of the file is missing"),
            Self::NotARecord => f.write_str("these bytes are not a record"),
            Self::ChunkCrc { saved, calculated } => write!(f, "the chunk's checksum is {calculated:08x}; the file says {saved:08x}"),
            Self::DataCrc { saved, calculated } => {
                write!(f, "the data section's checksum is {calculated:08x}; the file says {saved:08x}")
            }
            Self::BadSummary(what) => write!(f, "the summary cannot be used ({what}); the log was scanned instead"),
            Self::Decompression(error) => write!(f, "the chunk cannot be decompressed: {error}"),
            Self::ChunkSize { declared, found } => write!(f, "the chunk declares {declared} bytes and holds {found}"),
            Self::TooLarge { declared, allowed } => write!(f, "the chunk declares {declared} bytes; at most {allowed} are allowed"),
            Self::UnknownCompression(name) => write!(f, "the compression {name:?} is not known; known are zstd, lz4 and none"),
            Self::BadChunkHeader => f.write_str("the chunk's header is broken"),
            Self::BrokenRecords => f.write_str("records inside the chunk do not fit into it"),
            Self::NoChannel { channel } => write!(f, "the log does not describe channel {channel}"),
            Self::Io(error) => write!(f, "the file cannot be read here: {error}"),
            Self::RaggedRow { line, found, expected } => write!(f, "line {line} has {found} cell(s), the header {expected}"),
            Self::BadTime { place, found } => write!(f, "the time in {place} is {found:?}"),
            Self::RowGroup { group, rows, reason } => write!(f, "{rows} row(s) of row group {group} cannot be read: {reason}"),
        }
    }
}
