//! Source of a log's bytes: a file, read by position, or memory.

use crate::log::{Error, Result};
use sha2::{Digest, Sha256};
use std::fmt::Write as _;
use std::fs::{File, Metadata};
use std::path::Path;
use std::time::SystemTime;

/// The bytes of a log. Reads are by position, so that several threads may read at the same time.
#[derive(Debug)]
pub(crate) enum LogInput {
    File { file: File, length: u64, opened: FileState },
    Memory(Vec<u8>),
}

impl LogInput {
    pub(crate) fn open(path: &Path) -> Result<Self> {
        let file = File::open(path).map_err(Error::Io)?;
        let about = file.metadata().map_err(Error::Io)?;
        if about.is_dir() {
            return Err(Error::Folder);
        }
        Ok(Self::File { file, length: about.len(), opened: FileState::of(&about) })
    }

    pub(crate) fn length(&self) -> u64 {
        match self {
            Self::File { length, .. } => *length,
            Self::Memory(bytes) => bytes.len() as u64,
        }
    }

    /// Fills `into` from `offset` on. The caller has checked that this range is inside the log.
    pub(crate) fn read_at(&self, offset: u64, into: &mut [u8]) -> std::io::Result<()> {
        match self {
            Self::File { file, .. } => read_exact_at(file, offset, into),
            Self::Memory(bytes) => {
                let from = usize::try_from(offset).ok().and_then(|at| bytes.get(at..)).and_then(|rest| rest.get(..into.len()));
                into.copy_from_slice(from.ok_or(std::io::ErrorKind::UnexpectedEof)?);
                Ok(())
            }
        }
    }

    /// Replaces the content of `into` by `length` bytes from `offset` on.
    pub(crate) fn read_into(&self, offset: u64, length: usize, into: &mut Vec<u8>) -> std::io::Result<()> {
        into.resize(length, 0);
        self.read_at(offset, into)
    }

    /// Reads the first `length` bytes in order.
    fn each_part(&self, length: u64, mut take: impl FnMut(&[u8])) -> std::io::Result<()> {
        const STEP: u64 = 1 << 20;
        let mut buffer = Vec::new();
        let mut at = 0;
        while at < length {
            let step = STEP.min(length - at);
            self.read_into(at, step as usize, &mut buffer)?;
            take(&buffer);
            at += step;
        }
        Ok(())
    }

    /// CRC-32 of the first `length` bytes.
    pub(crate) fn crc(&self, length: u64) -> std::io::Result<u32> {
        let mut crc = crc32fast::Hasher::new();
        self.each_part(length, |part| crc.update(part))?;
        Ok(crc.finalize())
    }

    /// Whether the file is the one that was opened, as far as its size and times say.
    ///
    /// # Errors
    /// A file that has changed since, or that cannot be asked.
    pub(crate) fn expect_unchanged(&self) -> Result<()> {
        match self {
            Self::File { file, opened, .. } if FileState::of(&file.metadata().map_err(Error::Io)?) != *opened => Err(Error::Changed),
            _ => Ok(()),
        }
    }

    /// SHA-256 of the whole log in lower-case hexadecimal, and the checksum of each of `ranges` (offset and length, ascending, apart) of the
    /// same bytes; `progress` receives the number of bytes.
    pub(crate) fn sha256(&self, ranges: &[(u64, u64)], progress: &(dyn Fn(u64) + Sync)) -> Result<(String, Vec<u32>)> {
        let mut hash = Sha256::new();
        let mut sums = RangeSums::new(ranges);
        self.each_part(self.length(), |part| {
            hash.update(part);
            sums.update(part);
            progress(part.len() as u64);
        })
        .map_err(Error::Io)?;
        let hash = hash.finalize().iter().fold(String::with_capacity(64), |mut text, byte| {
            let _ = write!(text, "{byte:02x}");
            text
        });
        Ok((hash, sums.finish()))
    }
}

/// What the file system says about a file's content.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct FileState {
    length: u64,
    written: Option<SystemTime>,
    /// Time of the last change [s, ns], which no program can set back.
    changed: (i64, i64),
}

impl FileState {
    fn of(about: &Metadata) -> Self {
        #[cfg(unix)]
        let changed = {
            use std::os::unix::fs::MetadataExt;
            (about.ctime(), about.ctime_nsec())
        };
        #[cfg(not(unix))]
        let changed = (0, 0);
        Self { length: about.len(), written: about.modified().ok(), changed }
    }
}

/// Checksums of ranges of a stream.
struct RangeSums<'r> {
    ranges: &'r [(u64, u64)],
    /// Position in the stream.
    at: u64,
    current: crc32fast::Hasher,
    found: Vec<u32>,
}

impl<'r> RangeSums<'r> {
    fn new(ranges: &'r [(u64, u64)]) -> Self {
        Self { ranges, at: 0, current: crc32fast::Hasher::new(), found: Vec::with_capacity(ranges.len()) }
    }

    fn update(&mut self, part: &[u8]) {
        let end = self.at + part.len() as u64;
        while let Some((offset, length)) = self.ranges.get(self.found.len()).copied() {
            let (from, to) = (offset.max(self.at), offset.saturating_add(length).min(end));
            if from < to {
                self.current.update(&part[(from - self.at) as usize..(to - self.at) as usize]);
            }
            if offset.saturating_add(length) > end {
                break;
            }
            self.found.push(std::mem::take(&mut self.current).finalize());
        }
        self.at = end;
    }

    fn finish(self) -> Vec<u32> {
        self.found
    }
}

#[cfg(unix)]
fn read_exact_at(file: &File, offset: u64, into: &mut [u8]) -> std::io::Result<()> {
    std::os::unix::fs::FileExt::read_exact_at(file, into, offset)
}

#[cfg(windows)]
fn read_exact_at(file: &File, mut offset: u64, mut into: &mut [u8]) -> std::io::Result<()> {
    while !into.is_empty() {
        let count = std::os::windows::fs::FileExt::seek_read(file, into, offset)?;
        if count == 0 {
            return Err(std::io::ErrorKind::UnexpectedEof.into());
        }
        offset += count as u64;
        into = &mut into[count..];
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn the_checksums_of_ranges_are_those_of_their_bytes_wherever_the_parts_end() {
        let bytes: Vec<u8> = (0..100u8).collect();
        let ranges = [(0, 10), (10, 0), (15, 40), (55, 45)];
        for step in [1, 7, 15, 100] {
            let mut sums = RangeSums::new(&ranges);
            bytes.chunks(step).for_each(|part| sums.update(part));
            let expected: Vec<u32> = ranges.iter().map(|(at, n)| crc32fast::hash(&bytes[*at as usize..(at + n) as usize])).collect();
            assert_eq!(sums.finish(), expected, "{step}");
        }
    }

    #[test]
    fn a_file_that_is_written_to_after_it_was_opened_has_changed() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.mcap");
        std::fs::write(&path, b"before").unwrap();
        let long_ago = SystemTime::now() - std::time::Duration::from_secs(10);
        File::options().write(true).open(&path).unwrap().set_modified(long_ago).unwrap();
        let input = LogInput::open(&path).unwrap();
        input.expect_unchanged().unwrap();
        std::fs::write(&path, b"after!").unwrap();
        assert!(matches!(input.expect_unchanged(), Err(Error::Changed)));
    }
}
