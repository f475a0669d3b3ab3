//! Scanning a stretch of the file at its top level, and finding the step again where it was lost.

use crate::log::file::container::{Container, is_small};
use crate::log::file::input::LogInput;
use crate::log::file::record::{CHUNK_HEADER, ChunkHeader, Compression, PREFIX, parse, prefix};
use crate::log::file::structure::{Block, BlockKind};
use crate::log::loss::Why;
use mcap::records::op;
use std::collections::BTreeSet;

/// Runs of records outside of chunks are cut into blocks of about this size [bytes].
const LOOSE_BLOCK: u64 = 2 << 20;
/// Bytes read at once.
const WINDOW: usize = 64 << 10;
/// Records that must follow each other before a place is believed to be a record.
const CHAIN: usize = 3;

/// A window on the file that moves forward.
struct Window<'a> {
    input: &'a LogInput,
    end: u64,
    at: u64,
    bytes: Vec<u8>,
}

impl<'a> Window<'a> {
    fn new(input: &'a LogInput, end: u64) -> Self {
        Self { input, end: end.min(input.length()), at: 0, bytes: Vec::new() }
    }

    /// Up to `count` bytes from `offset` on, fewer at the end.
    fn peek(&mut self, offset: u64, count: usize) -> &[u8] {
        let count = (count as u64).min(self.end.saturating_sub(offset)) as usize;
        let inside = offset >= self.at && offset + count as u64 <= self.at + self.bytes.len() as u64;
        if !inside {
            let length = (count.max(WINDOW) as u64).min(self.end.saturating_sub(offset)) as usize;
            self.at = offset;
            if self.input.read_into(offset, length, &mut self.bytes).is_err() {
                self.bytes.clear();
                return &[];
            }
        }
        let from = (offset - self.at) as usize;
        &self.bytes[from..from + count]
    }

    /// Opcode and body length of the record at `offset`, if it is one and ends before the stretch does.
    fn record(&mut self, offset: u64) -> Option<(u8, u64)> {
        let (opcode, length) = prefix(self.peek(offset, PREFIX as usize))?;
        let end = offset.checked_add(PREFIX)?.checked_add(length)?;
        (opcode != 0 && end <= self.end).then_some((opcode, length))
    }

    /// Whether the record at `offset` has the inner structure that its opcode asks for; its end.
    fn is_plausible(&mut self, offset: u64, known: &Container) -> Option<u64> {
        let (opcode, length) = self.record(offset)?;
        let body = offset + PREFIX;
        let good = match opcode {
            op::CHUNK => ChunkHeader::parse(self.peek(body, CHUNK_HEADER)).is_some_and(|header| {
                !matches!(header.compression, Compression::Unknown(_))
                    && header.start_ns <= header.end_ns
                    && header.compressed.checked_add(header.length) == Some(length)
            }),
            op::MESSAGE => {
                length >= 22 && {
                    let head = self.peek(body, 2);
                    known.inventory.channels.contains_key(&u16::from_le_bytes([head[0], head[1]]))
                }
            }
            op::MESSAGE_INDEX => {
                length >= 6 && {
                    let head = self.peek(body, 6);
                    let size = u64::from(u32::from_le_bytes([head[2], head[3], head[4], head[5]]));
                    size % 16 == 0 && size + 6 == length
                }
            }
            op::SCHEMA | op::CHANNEL | op::METADATA => is_small(length) && parse(opcode, self.peek(body, length as usize)).is_some(),
            op::DATA_END => length == 4,
            op::FOOTER => length == 20,
            _ => false,
        };
        good.then_some(body + length)
    }

    /// The next place, from `offset` on, where records follow each other again.
    fn resynchronise(&mut self, mut offset: u64, known: &Container) -> Option<u64> {
        while offset + PREFIX <= self.end {
            let step = self.peek(offset, WINDOW);
            let candidate = step.iter().position(|byte| (op::HEADER..=op::DATA_END).contains(byte))? as u64 + offset;
            let mut at = Some(candidate);
            for _ in 0..CHAIN {
                at = at.and_then(|at| if at == self.end { Some(at) } else { self.is_plausible(at, known) });
            }
            if at.is_some() {
                return Some(candidate);
            }
            offset = candidate + 1;
        }
        None
    }
}

/// Whether a record that is allowed between chunks starts at `offset`, or the stretch ends there.
pub(crate) fn is_record(input: &LogInput, offset: u64, end: u64) -> bool {
    offset == end || Window::new(input, end).record(offset).is_some_and(|(opcode, _)| opcode <= op::DATA_END)
}

/// Scans the file from `from` to `to` and adds to `container` what lies there.
pub(crate) fn run(container: &mut Container, from: u64, to: u64) {
    if from >= to {
        return;
    }
    let input = container.input.clone();
    walk(container, &input, from, to);
}

fn walk(container: &mut Container, input: &LogInput, from: u64, to: u64) {
    let mut window = Window::new(input, to);
    let mut at = from;
    let mut loose: Option<(u64, BTreeSet<u16>)> = None; // start of the current run, its channels
    let mut chunk: Option<(usize, BTreeSet<u16>)> = None; // the block whose message indexes are being read, its channels
    let close = |container: &mut Container, loose: &mut Option<(u64, BTreeSet<u16>)>, end: u64| {
        if let Some((start, channels)) = loose.take() {
            let channels = Some(container.sets.shared(channels));
            container.blocks.push(Block { offset: start, length: end - start, kind: BlockKind::Loose, channels });
        }
    };
    let list = |container: &mut Container, chunk: &mut Option<(usize, BTreeSet<u16>)>| {
        if let Some((index, channels)) = chunk.take().filter(|(_, channels)| !channels.is_empty()) {
            container.blocks[index].channels = Some(container.sets.shared(channels));
        }
    };
    while at < to {
        let Some((opcode, length)) = window.record(at) else {
            close(container, &mut loose, at);
            list(container, &mut chunk);
            let next = window.resynchronise(at + 1, container);
            let end = next.unwrap_or(to);
            cut_off(container, &mut window, at, end, next.is_none());
            at = end;
            continue;
        };
        let body = at + PREFIX;
        if opcode != op::MESSAGE && !matches!(opcode, op::SCHEMA | op::CHANNEL) {
            close(container, &mut loose, at);
        }
        if opcode != op::MESSAGE_INDEX {
            list(container, &mut chunk);
        }
        match opcode {
            op::MESSAGE => {
                let head = window.peek(body, 2);
                if length < 22 || head.len() < 2 {
                    close(container, &mut loose, at);
                    container.damaged(at, PREFIX + length, Why::NotARecord);
                } else {
                    let id = u16::from_le_bytes([head[0], head[1]]);
                    let run = loose.get_or_insert_with(|| (at, BTreeSet::new()));
                    run.1.insert(id);
                    if body + length - run.0 >= LOOSE_BLOCK {
                        close(container, &mut loose, body + length);
                    }
                }
            }
            op::CHUNK if !is_whole_chunk(&mut window, body, length) => {
                let end = window.resynchronise(at + 1, container).unwrap_or(to);
                container.damaged(at, end - at, Why::BadChunkHeader);
                at = end;
                continue;
            }
            op::CHUNK => {
                container.blocks.push(Block { offset: body, length, kind: BlockKind::Chunk, channels: None });
                chunk = Some((container.blocks.len() - 1, BTreeSet::new()));
            }
            op::MESSAGE_INDEX => {
                let head = window.peek(body, 6);
                if let (Some((_, channels)), 6.., [low, high, ..]) = (&mut chunk, length, head) {
                    channels.insert(u16::from_le_bytes([*low, *high]));
                }
            }
            op::HEADER | op::SCHEMA | op::CHANNEL | op::METADATA | op::STATISTICS if is_small(length) => {
                match parse(opcode, window.peek(body, length as usize)) {
                    Some(mcap::records::Record::Statistics(statistics)) => container.statistics = Some(statistics),
                    Some(record) => container.take(record),
                    None => {
                        container.damaged(at, PREFIX + length, Why::NotARecord);
                        // the length may be as wrong as the rest
                        at = window.resynchronise(at + 1, container).unwrap_or(to);
                        continue;
                    }
                }
            }
            op::ATTACHMENT => container.attachments += 1,
            op::DATA_END => {
                if let Ok(crc) = <[u8; 4]>::try_from(window.peek(body, 4)) {
                    container.data_end = Some((at, u32::from_le_bytes(crc)));
                }
            }
            op::FOOTER => {
                container.footer = true;
                return;
            }
            _ => {}
        }
        at = body + length;
    }
    close(container, &mut loose, at.min(to));
    list(container, &mut chunk);
}

/// Whether the chunk's header agrees with the length of its record.
fn is_whole_chunk(window: &mut Window<'_>, body: u64, length: u64) -> bool {
    ChunkHeader::parse(window.peek(body, CHUNK_HEADER.min(length as usize)))
        .is_some_and(|header| header.compressed.checked_add(header.length) == Some(length))
}

/// Notes the loss from `at` to `end`; a chunk that the end of the file cuts off is still worth a try.
fn cut_off(container: &mut Container, window: &mut Window<'_>, at: u64, end: u64, last: bool) {
    let is_end = last && end == window.input.length();
    let head = prefix(window.peek(at, PREFIX as usize));
    let chunk_header = ChunkHeader::parse(window.peek(at + PREFIX, CHUNK_HEADER));
    match (head, chunk_header) {
        (Some((op::CHUNK, _)), Some(header)) if is_end && !matches!(header.compression, Compression::Unknown(_)) => {
            let offset = at + PREFIX;
            container.blocks.push(Block { offset, length: end - offset, kind: BlockKind::CutChunk, channels: None });
            container.damaged(at, end - at, Why::Truncated);
        }
        _ if is_end => container.damaged(at, end - at, Why::Truncated),
        _ => container.damaged(at, end - at, Why::NotARecord),
    }
}
