//! Reads the records of one block by position, decompresses them within the allowed size, and checks them.

use crate::log::file::container::Container;
use crate::log::file::input::LogInput;
use crate::log::file::lz4;
use crate::log::file::record::{ChunkHeader, Compression, MAX_CHUNK, PREFIX, prefix};
use crate::log::file::structure::{Block, BlockKind};
use crate::log::loss::{Damage, Why};
use mcap::records::op;
use std::collections::BTreeMap;
use std::io::Read;

/// Buffers that a thread keeps from block to block.
#[derive(Default)]
pub(crate) struct Scratch {
    raw: Vec<u8>,
    records: Vec<u8>,
    zstd: Option<zstd::bulk::Decompressor<'static>>,
    /// Checksum of the bytes of the block that was read last; `None` if none could be read.
    pub read_crc: Option<u32>,
}

/// Buffers above this size are freed after use, so that one giant image does not stay in memory [bytes].
const KEEP: usize = 64 << 20;

/// Reads a block and returns its records, complete and checked.
///
/// # Errors
/// The reason why the block cannot be used. For a [`BlockKind::CutChunk`], the decompressed part is returned unchecked.
pub(crate) fn load<'s>(input: &LogInput, block: &Block, scratch: &'s mut Scratch) -> Result<&'s [u8], Why> {
    if scratch.raw.capacity() + scratch.records.capacity() > KEEP {
        scratch.raw = Vec::new();
        scratch.records = Vec::new();
    }
    scratch.read_crc = None;
    // a block never exceeds the file; chunks have the same size limit as their decompressed content
    if block.kind != BlockKind::Loose && block.length > MAX_CHUNK {
        return Err(Why::TooLarge { declared: block.length, allowed: MAX_CHUNK });
    }
    input.read_into(block.offset, block.length as usize, &mut scratch.raw).map_err(|error| Why::Io(error.to_string()))?;
    scratch.read_crc = Some(crc32fast::hash(&scratch.raw));
    if block.kind == BlockKind::Loose {
        return Ok(&scratch.raw);
    }
    let header = ChunkHeader::parse(&scratch.raw).ok_or(Why::BadChunkHeader)?;
    if header.uncompressed > MAX_CHUNK {
        return Err(Why::TooLarge { declared: header.uncompressed, allowed: MAX_CHUNK });
    }
    let data = &scratch.raw[header.length as usize..];
    if block.kind == BlockKind::CutChunk {
        return Ok(salvage(&header, data, &mut scratch.records));
    }
    if header.compressed != data.len() as u64 {
        return Err(Why::BadChunkHeader);
    }
    let size = header.uncompressed as usize;
    let records: &[u8] = match &header.compression {
        Compression::None => {
            if data.len() != size {
                return Err(Why::ChunkSize { declared: header.uncompressed, found: data.len() as u64 });
            }
            data
        }
        Compression::Zstd => {
            // space for the declared size only: a chunk that holds more is an error, not an allocation
            scratch.records.clear();
            scratch.records.reserve(size);
            let zstd = match &mut scratch.zstd {
                Some(zstd) => zstd,
                none => none.insert(zstd::bulk::Decompressor::new().map_err(|error| Why::Decompression(error.to_string()))?),
            };
            zstd.decompress_to_buffer(data, &mut scratch.records).map_err(|error| Why::Decompression(error.to_string()))?;
            &scratch.records
        }
        Compression::Lz4 => {
            let allowed = data.len() as u64 * lz4::MAX_RATIO;
            if header.uncompressed > allowed {
                return Err(Why::TooLarge { declared: header.uncompressed, allowed });
            }
            scratch.records.resize(size, 0);
            if header.crc != 0 && lz4::decompress(data, &mut scratch.records).is_some() {
                return checked(&header, &scratch.records);
            }
            let mut decoder = lz4_flex::frame::FrameDecoder::new(data);
            let found = fill(&mut decoder, &mut scratch.records).map_err(|error| Why::Decompression(error.to_string()))?;
            scratch.records.truncate(found);
            let more = found == size && decoder.read(&mut [0]).map_err(|error| Why::Decompression(error.to_string()))? > 0;
            if more {
                return Err(Why::ChunkSize { declared: header.uncompressed, found: header.uncompressed + 1 });
            }
            &scratch.records
        }
        Compression::Unknown(name) => return Err(Why::UnknownCompression(name.clone())),
    };
    if records.len() != size {
        return Err(Why::ChunkSize { declared: header.uncompressed, found: records.len() as u64 });
    }
    checked(&header, records)
}

/// The records, if their checksum is correct or the writer computed none.
fn checked<'r>(header: &ChunkHeader, records: &'r [u8]) -> Result<&'r [u8], Why> {
    match header.crc {
        0 => Ok(records),
        saved => match crc32fast::hash(records) {
            calculated if calculated == saved => Ok(records),
            calculated => Err(Why::ChunkCrc { saved, calculated }),
        },
    }
}

/// Fills `into` until the decoder has no more bytes.
fn fill(decoder: &mut impl Read, into: &mut [u8]) -> std::io::Result<usize> {
    let mut filled = 0;
    while filled < into.len() {
        match decoder.read(&mut into[filled..])? {
            0 => break,
            count => filled += count,
        }
    }
    Ok(filled)
}

/// The readable part of a chunk without an end.
fn salvage<'s>(header: &ChunkHeader, data: &[u8], into: &'s mut Vec<u8>) -> &'s [u8] {
    into.clear();
    // each read is small, so that an error loses few of the bytes before it
    let mut take = |decoder: &mut dyn Read| {
        let mut part = [0; 1 << 10];
        while let Ok(count @ 1..) = decoder.read(&mut part) {
            let room = header.uncompressed as usize - into.len();
            into.extend_from_slice(&part[..count.min(room)]);
            if count >= room {
                break; // never more than the chunk declares
            }
        }
    };
    match &header.compression {
        Compression::None => take(&mut &data[..]),
        Compression::Lz4 => take(&mut lz4_flex::frame::FrameDecoder::new(data)),
        Compression::Zstd => {
            if let Ok(mut decoder) = zstd::stream::read::Decoder::with_buffer(data) {
                take(&mut decoder);
            }
        }
        Compression::Unknown(_) => {}
    }
    into
}

/// The loss of a whole block. Its messages per channel come from the message indexes, if there are any.
pub(crate) fn lost(container: &Container, block: &Block, why: Why) -> Damage {
    let (offset, bytes) = match block.kind {
        BlockKind::Loose => (block.offset, block.length),
        BlockKind::Chunk | BlockKind::CutChunk => (block.offset - PREFIX, block.length + PREFIX),
    };
    let mut damage = Damage::new(offset, bytes, why);
    let counted = indexed_messages(&container.input, block.offset + block.length);
    let listed = || block.channels.iter().flat_map(|channels| channels.iter().map(|id| (*id, 0))).collect();
    damage.channels = if counted.is_empty() { listed() } else { counted };
    damage.messages = Some(damage.channels.values().sum()).filter(|sum| *sum > 0);
    damage
}

/// Messages per channel according to the message indexes from `at` on.
fn indexed_messages(input: &LogInput, mut at: u64) -> BTreeMap<u16, u64> {
    let mut channels = BTreeMap::new();
    let mut head = [0; PREFIX as usize + 2];
    while at.checked_add(head.len() as u64).is_some_and(|end| end <= input.length()) && input.read_at(at, &mut head).is_ok() {
        let Some((op::MESSAGE_INDEX, length @ 6..)) = prefix(&head) else { break };
        let id = u16::from_le_bytes([head[PREFIX as usize], head[PREFIX as usize + 1]]);
        *channels.entry(id).or_default() += (length - 6) / 16;
        let Some(next) = length.checked_add(PREFIX).and_then(|step| at.checked_add(step)) else { break };
        at = next;
    }
    channels
}
