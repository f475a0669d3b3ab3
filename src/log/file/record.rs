//! Single MCAP records: the allowed sizes, and a parser that never makes a large allocation.
//!
//! Source: the MCAP specification, <https://mcap.dev/spec>.

use crate::log::file::bytes::Bytes;
use crate::text::owned_name;
use mcap::records::{Record, op};

/// The first and the last eight bytes of a log.
pub(crate) const MAGIC: &[u8; 8] = b"\x89MCAP0\r\n";
/// Opcode and length before each record.
pub(crate) const PREFIX: u64 = 9;
/// Length of a footer's body.
pub(crate) const FOOTER: u64 = 20;
/// Largest chunk that is decompressed [bytes]. Writers make chunks of 1 to 16 MB, or of one image or point cloud if that is larger.
pub(crate) const MAX_CHUNK: u64 = 256 << 20;
/// Largest schema, channel, metadata or index record that is parsed [bytes].
pub(crate) const MAX_SMALL: u64 = 32 << 20;

/// Opcode and body length of the record whose first nine bytes are `prefix`.
pub(crate) fn prefix(prefix: &[u8]) -> Option<(u8, u64)> {
    let mut bytes = Bytes::new(prefix);
    Some((bytes.u8()?, bytes.u64()?))
}

/// Parses a schema, channel, metadata, statistics, chunk index, header, footer or data end record; `None` if it is broken or of another
/// kind. The lengths inside are checked first, because the parser allocates the declared lengths.
pub(crate) fn parse(opcode: u8, body: &[u8]) -> Option<Record<'_>> {
    let mut bytes = Bytes::new(body);
    match opcode {
        op::HEADER => {
            bytes.block()?;
            bytes.block()?;
        }
        op::SCHEMA => {
            bytes.u16()?;
            for _ in 0..3 {
                bytes.block()?;
            }
        }
        op::CHANNEL => {
            bytes.u32()?;
            bytes.block()?;
            bytes.block()?;
            text_map(bytes.block()?)?;
        }
        op::METADATA => {
            bytes.block()?;
            text_map(bytes.block()?)?;
        }
        op::CHUNK_INDEX => {
            bytes.take(32)?;
            let offsets = bytes.block()?;
            if offsets.len() % 10 != 0 {
                return None;
            }
            bytes.u64()?;
            bytes.block()?;
            bytes.take(16)?;
        }
        op::STATISTICS => {
            bytes.take(42)?;
            if bytes.block()?.len() % 10 != 0 {
                return None;
            }
        }
        op::FOOTER | op::DATA_END => {}
        _ => return None,
    }
    mcap::parse_record(opcode, body).ok()
}

fn text_map(map: &[u8]) -> Option<()> {
    let mut bytes = Bytes::new(map);
    while !bytes.rest().is_empty() {
        bytes.block()?;
        bytes.block()?;
    }
    Some(())
}

/// Header of a chunk, before its compressed records.
#[derive(Debug, Clone)]
pub(crate) struct ChunkHeader {
    pub start_ns: u64,
    pub end_ns: u64,
    pub uncompressed: u64,
    /// Zero if the writer computed none.
    pub crc: u32,
    pub compression: Compression,
    pub compressed: u64,
    /// Bytes from the start of the chunk's body to the compressed records.
    pub length: u64,
}

/// Compression of a chunk's records.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Compression {
    None,
    Lz4,
    Zstd,
    Unknown(String),
}

impl Compression {
    pub(crate) fn name(&self) -> &str {
        match self {
            Self::None => "none",
            Self::Lz4 => "lz4",
            Self::Zstd => "zstd",
            Self::Unknown(name) => name,
        }
    }
}

/// Number of bytes needed to parse a chunk header with a compression name of 64 bytes.
pub(crate) const CHUNK_HEADER: usize = 8 + 8 + 8 + 4 + 4 + 64 + 8;

impl ChunkHeader {
    /// Parses the header of a chunk from the start of its body; `None` if it is broken.
    pub(crate) fn parse(body: &[u8]) -> Option<Self> {
        let mut bytes = Bytes::new(body);
        let (start_ns, end_ns, uncompressed, crc) = (bytes.u64()?, bytes.u64()?, bytes.u64()?, bytes.u32()?);
        let compression = match bytes.block()? {
            b"" => Compression::None,
            b"lz4" => Compression::Lz4,
            b"zstd" => Compression::Zstd,
            other => Compression::Unknown(owned_name(String::from_utf8_lossy(other).into_owned())),
        };
        let compressed = bytes.u64()?;
        let length = (body.len() - bytes.rest().len()) as u64;
        Some(Self { start_ns, end_ns, uncompressed, crc, compression, compressed, length })
    }
}

/// Header of a message, before its payload.
#[derive(Debug, Clone, Copy)]
pub(crate) struct RawMessage<'a> {
    pub channel: u16,
    pub log_time_ns: u64,
    pub publish_time_ns: u64,
    pub payload: &'a [u8],
}

impl<'a> RawMessage<'a> {
    /// Parses the body of a message record; `None` if it is too short.
    pub(crate) fn parse(body: &'a [u8]) -> Option<Self> {
        let mut bytes = Bytes::new(body);
        let channel = bytes.u16()?;
        bytes.u32()?;
        Some(Self { channel, log_time_ns: bytes.u64()?, publish_time_ns: bytes.u64()?, payload: bytes.rest() })
    }
}

/// Walks the records of a chunk or of a run of top-level records. Yields opcode and body. Afterwards [`Records::left`] holds the bytes that
/// could not be walked; it is empty if there are no errors.
#[derive(Debug)]
pub(crate) struct Records<'a> {
    bytes: Bytes<'a>,
}

impl<'a> Records<'a> {
    pub(crate) fn new(data: &'a [u8]) -> Self {
        Self { bytes: Bytes::new(data) }
    }

    /// Bytes that do not form a complete record.
    pub(crate) fn left(&self) -> usize {
        self.bytes.rest().len()
    }
}

impl<'a> Iterator for Records<'a> {
    type Item = (u8, &'a [u8]);

    fn next(&mut self) -> Option<Self::Item> {
        let mut bytes = self.bytes;
        let opcode = bytes.u8()?;
        let length = usize::try_from(bytes.u64()?).ok()?;
        let body = bytes.take(length)?;
        if opcode == 0 {
            return None; // the specification forbids it: the position is not at a record
        }
        self.bytes = bytes;
        Some((opcode, body))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_string_that_claims_gigabytes_is_refused_before_it_is_parsed() {
        let mut body = vec![1, 0];
        body.extend(u32::MAX.to_le_bytes());
        body.extend([0; 16]);
        assert!(parse(op::SCHEMA, &body).is_none());
        assert!(parse(op::ATTACHMENT, &[0; 12]).is_none());
    }

    #[test]
    fn records_stop_where_a_length_leaves_the_data() {
        let mut data = vec![op::MESSAGE, 1, 0, 0, 0, 0, 0, 0, 0, 7];
        data.extend([op::MESSAGE, 255, 255, 255, 255, 255, 255, 255, 255, 7]);
        let mut records = Records::new(&data);
        assert_eq!(records.next(), Some((op::MESSAGE, &[7][..])));
        assert_eq!(records.next(), None);
        assert_eq!(records.left(), 10);
    }
}
