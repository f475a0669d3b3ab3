//! Decompresses LZ4 frames in place: blocks are written directly to the buffer of the records, without the buffers and checksums of a
//! streaming decoder. Used only for chunks that have their own checksum.
//!
//! Source: the LZ4 frame format 1.6.4, <https://github.com/lz4/lz4/blob/dev/doc/lz4_Frame_format.md>.

use crate::log::file::bytes::Bytes;

/// Largest number of bytes decompressed from one byte of a frame: a byte that extends a match adds up to 255.
pub(crate) const MAX_RATIO: u64 = 255;
const MAGIC: u32 = 0x184D_2204;
/// Largest distance of a back-reference into earlier blocks [bytes].
const HISTORY: usize = 64 << 10;
/// The bit of a block's size that marks an uncompressed block.
const STORED: u32 = 1 << 31;

/// Fills `into` from a frame with exactly that much content. `None`: the frame is broken, has another size, or is of a kind that only the
/// streaming decoder reads; the content of `into` is then undefined.
pub fn decompress(frame: &[u8], into: &mut [u8]) -> Option<()> {
    let mut bytes = Bytes::new(frame);
    if bytes.u32()? != MAGIC {
        return None;
    }
    let (flags, sizes) = (bytes.u8()?, bytes.u8()?);
    let has = |bit: u8| flags & (1 << bit) != 0;
    let (is_version_1, independent, block_checksums, content_size, content_checksum, dictionary) =
        (flags >> 6 == 1, has(5), has(4), has(3), has(2), has(0));
    if !is_version_1 || dictionary {
        return None;
    }
    if content_size {
        bytes.u64()?;
    }
    bytes.u8()?; // checksum of the frame's header
    let largest = match sizes >> 4 & 7 {
        size @ 4..=7 => 1 << (2 * size + 8),
        _ => return None,
    };
    let mut at = 0;
    loop {
        let size = bytes.u32()?;
        if size == 0 {
            break;
        }
        let block = bytes.take((size & !STORED) as usize)?;
        let (before, room) = into.split_at_mut(at);
        let left = room.len();
        let room = &mut room[..largest.min(left)];
        at += if size & STORED != 0 {
            room.get_mut(..block.len())?.copy_from_slice(block);
            block.len()
        } else if independent || before.is_empty() {
            lz4_flex::block::decompress_into(block, room).ok()?
        } else {
            let history = &before[before.len().saturating_sub(HISTORY)..];
            lz4_flex::block::decompress_into_with_dict(block, room, history).ok()?
        };
        if block_checksums {
            bytes.u32()?;
        }
    }
    if content_checksum {
        bytes.u32()?;
    }
    (at == into.len() && bytes.rest().is_empty()).then_some(())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use lz4_flex::frame::{BlockMode, BlockSize, FrameEncoder, FrameInfo};
    use std::io::Write as _;

    fn frame(data: &[u8], mode: BlockMode, checksums: bool) -> Vec<u8> {
        let info = FrameInfo::new()
            .block_mode(mode)
            .block_size(BlockSize::Max64KB)
            .block_checksums(checksums)
            .content_checksum(checksums)
            .content_size(checksums.then_some(data.len() as u64));
        let mut encoder = FrameEncoder::with_frame_info(info, Vec::new());
        encoder.write_all(data).unwrap();
        encoder.finish().unwrap()
    }

    /// Text that repeats over block borders, then noise that is stored uncompressed.
    fn content() -> Vec<u8> {
        let noise = |n: u32| (n.wrapping_mul(2_654_435_761) ^ n.wrapping_mul(n).rotate_left(13)).to_le_bytes();
        b"the rear wheels stand, the front wheel drives ".repeat(5000).into_iter().chain((0..50_000_u32).flat_map(noise)).collect()
    }

    #[test]
    fn every_kind_of_frame_gives_its_content() {
        let data = content();
        for mode in [BlockMode::Independent, BlockMode::Linked] {
            for checksums in [false, true] {
                let mut found = vec![0; data.len()];
                decompress(&frame(&data, mode, checksums), &mut found).unwrap();
                assert!(found == data);
            }
        }
    }

    #[test]
    fn frames_that_are_broken_or_have_another_size_than_declared_are_refused() {
        let whole = frame(&content(), BlockMode::Linked, true);
        for size in [content().len() - 1, content().len() + 1, 0] {
            assert_eq!(decompress(&whole, &mut vec![0; size]), None);
        }
        let mut room = vec![0; content().len()];
        for cut in 0..whole.len().min(200) {
            assert_eq!(decompress(&whole[..cut], &mut room), None);
        }
        let mut wild = whole.clone();
        wild[15..19].copy_from_slice(&0x7fff_ffff_u32.to_le_bytes()); // the first block's size
        assert_eq!(decompress(&wild, &mut room), None);
    }
}
