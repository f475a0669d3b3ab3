//! Finds the outer structure of a log: by its summary where the file confirms it, otherwise by a scan of its top level.

use crate::log::file::channel_set::ChannelSets;
use crate::log::file::container::Container;
use crate::log::file::input::LogInput;
use crate::log::file::record::{MAGIC, PREFIX};
use crate::log::file::structure::Inventory;
use crate::log::file::{scan, summary};
use crate::log::loss::Why;
use crate::log::{Error, Result};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Finds the structure of a log.
///
/// # Errors
/// The log is empty or not an MCAP file.
pub(crate) fn open(input: LogInput) -> Result<Container> {
    let length = input.length();
    if length == 0 {
        return Err(Error::Empty);
    }
    let mut start = vec![0; length.min(16) as usize];
    input.read_at(0, &mut start).map_err(Error::Io)?;
    if !start.starts_with(MAGIC) {
        return Err(Error::NotMcap { hint: foreign(&start) });
    }
    let mut container = Container {
        input: Arc::new(input),
        library: String::new(),
        profile: String::new(),
        inventory: Inventory::default(),
        blocks: Vec::new(),
        sets: ChannelSets::default(),
        statistics: None,
        metadata: BTreeMap::new(),
        metadata_size: 0,
        attachments: 0,
        indexed: false,
        data_end: None,
        footer: false,
        damage: Vec::new(),
    };
    match summary::read(&container.input) {
        Ok(Some(found)) if found.covers_messages() => {
            container.inventory = found.inventory;
            container.statistics = found.statistics;
            container.indexed = true;
            let mut at = MAGIC.len() as u64;
            for (block, index_length) in found.chunks {
                let start = block.offset - PREFIX;
                scan::run(&mut container, at, start);
                let end = block.offset + block.length;
                at = end.saturating_add(index_length);
                container.blocks.push(block);
                // an index length that does not lead to the next chunk is ignored: the records after the chunk are walked
                if at > found.start || !scan::is_record(&container.input, at, found.start) {
                    at = end;
                }
            }
            scan::run(&mut container, at, found.start);
        }
        Ok(found) => {
            if let Some(found) = found {
                container.statistics = found.statistics;
                container.inventory = found.inventory;
            }
            scan::run(&mut container, MAGIC.len() as u64, length);
        }
        Err(damage) => {
            container.damage.push(damage);
            scan::run(&mut container, MAGIC.len() as u64, length);
        }
    }
    if !container.indexed && !container.footer && container.damage.iter().all(|damage| damage.why != Why::Truncated) {
        container.damaged(length, 0, Why::Truncated);
    }
    container.blocks.sort_by_key(|block| block.offset);
    container.damage.sort_by_key(|damage| damage.offset);
    container.expect_bounded()?;
    Ok(container)
}

/// The probable type of a file that is not MCAP, and the remedy.
fn foreign(start: &[u8]) -> &'static str {
    if start.starts_with(&[0x28, 0xb5, 0x2f, 0xfd]) {
        "it is compressed as a whole: unpack it with `zstd -d` first"
    } else if start.starts_with(b"#ROSBAG") {
        "it is a ROS 1 bag: convert it with `mcap convert` first"
    } else if start.starts_with(&[0x1f, 0x8b]) {
        "it is compressed as a whole: unpack it with `gunzip` first"
    } else {
        "its first bytes are not those of an MCAP file; a table of signals is read if its name ends in .csv, .tsv, .txt or .parquet"
    }
}
