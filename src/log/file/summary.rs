//! The summary at the end of a log, believed only as far as the file confirms it.

use crate::log::file::channel_set::ChannelSets;
use crate::log::file::input::LogInput;
use crate::log::file::record::{FOOTER, MAGIC, PREFIX, Records, parse, prefix};
use crate::log::file::structure::{Block, BlockKind, Inventory};
use crate::log::loss::{Damage, Why};
use mcap::records::{Record, Statistics, op};
use std::collections::BTreeSet;

/// Largest summary that is read [bytes].
const MAX_SUMMARY: u64 = 256 << 20;

/// What the summary of a log says.
#[derive(Debug)]
pub(crate) struct FileSummary {
    /// Position of its first byte: the data section ends here.
    pub start: u64,
    pub inventory: Inventory,
    pub statistics: Option<Statistics>,
    /// The chunks in file order, each with the length of the message indexes that follow it.
    pub chunks: Vec<(Block, u64)>,
}

impl FileSummary {
    /// Whether every chunk that the log counts is indexed, so that the file need not be scanned.
    pub(crate) fn covers_messages(&self) -> bool {
        !self.chunks.is_empty() && self.statistics.as_ref().is_none_or(|s| u64::from(s.chunk_count) == self.chunks.len() as u64)
    }
}

/// Reads the summary. `Ok(None)` when the log has none.
///
/// # Errors
/// The damage, when there is a summary and it cannot be believed: the caller then scans the file.
pub(crate) fn read(input: &LogInput) -> Result<Option<FileSummary>, Damage> {
    let length = input.length();
    let tail = PREFIX + FOOTER + MAGIC.len() as u64;
    let Some(footer_at) = length.checked_sub(tail).filter(|at| *at >= MAGIC.len() as u64) else {
        return Ok(None); // truncated: the scan tells
    };
    let mut footer = vec![0; tail as usize];
    let bad = |offset, bytes, what| Damage::new(offset, bytes, Why::BadSummary(what));
    input.read_at(footer_at, &mut footer).map_err(|_| bad(footer_at, tail, "the footer cannot be read"))?;
    let (head, magic) = footer.split_at((PREFIX + FOOTER) as usize);
    if magic != MAGIC || prefix(head) != Some((op::FOOTER, FOOTER)) {
        return Ok(None);
    }
    let Some(Record::Footer(found)) = parse(op::FOOTER, &head[PREFIX as usize..]) else {
        return Ok(None);
    };
    if found.summary_start == 0 {
        return Ok(None);
    }
    if found.summary_start < MAGIC.len() as u64 || found.summary_start > footer_at {
        return Err(bad(footer_at, 0, "the footer points outside the file"));
    }
    let size = footer_at - found.summary_start;
    if size > MAX_SUMMARY {
        return Err(bad(footer_at, 0, "it is larger than any log needs"));
    }
    let mut section = Vec::new();
    input.read_into(found.summary_start, size as usize, &mut section).map_err(|_| bad(found.summary_start, size, "it cannot be read"))?;
    if found.summary_crc != 0 {
        let mut crc = crc32fast::Hasher::new();
        crc.update(&section);
        crc.update(&head[..(PREFIX + 16) as usize]);
        if crc.finalize() != found.summary_crc {
            return Err(bad(found.summary_start, size, "its checksum differs"));
        }
    }
    let mut summary = FileSummary { start: found.summary_start, inventory: Inventory::default(), statistics: None, chunks: Vec::new() };
    let mut sets = ChannelSets::default();
    let mut records = Records::new(&section);
    for (opcode, body) in &mut records {
        match parse(opcode, body) {
            Some(Record::Statistics(statistics)) => summary.statistics = Some(statistics),
            Some(Record::ChunkIndex(index)) => {
                let block = confirmed(input, &index, found.summary_start, &mut sets)
                    .ok_or_else(|| bad(found.summary_start, 0, "its chunk index does not match the file"))?;
                summary.chunks.push((block, index.message_index_length));
            }
            Some(record @ (Record::Schema { .. } | Record::Channel(_))) => {
                summary.inventory.learn(record);
            }
            _ => {}
        }
    }
    if records.left() > 0 {
        return Err(bad(found.summary_start, size, "its records are broken"));
    }
    summary.chunks.sort_by_key(|(block, _)| block.offset);
    if summary.chunks.windows(2).any(|pair| pair[0].0.offset + pair[0].0.length + PREFIX > pair[1].0.offset) {
        return Err(bad(found.summary_start, 0, "its chunks overlap"));
    }
    Ok(Some(summary))
}

/// The chunk that an index entry describes, if the file has one there.
fn confirmed(input: &LogInput, index: &mcap::records::ChunkIndex, end: u64, sets: &mut ChannelSets) -> Option<Block> {
    let offset = index.chunk_start_offset.checked_add(PREFIX)?;
    let length = index.chunk_length.checked_sub(PREFIX)?;
    if index.chunk_start_offset < MAGIC.len() as u64 || offset.checked_add(length)? > end {
        return None;
    }
    let mut head = [0; PREFIX as usize];
    input.read_at(index.chunk_start_offset, &mut head).ok()?;
    if prefix(&head) != Some((op::CHUNK, length)) {
        return None;
    }
    // the index lists the channels; how many messages each has stands in the message indexes, read only if the chunk is lost
    let channels: BTreeSet<u16> = index.message_index_offsets.keys().copied().collect();
    let channels = (!channels.is_empty()).then(|| sets.shared(channels));
    Some(Block { offset, length, kind: BlockKind::Chunk, channels })
}
