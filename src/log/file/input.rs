//! Where a log's bytes come from: a file read by position, or memory.

use crate::log::{Error, Result};
use sha2::{Digest, Sha256};
use std::fmt::Write as _;
use std::fs::File;
use std::path::Path;

/// The bytes of a log. Reads go by position, so that several threads may read at once.
#[derive(Debug)]
pub(crate) enum LogInput {
    File { file: File, length: u64 },
    Memory(Vec<u8>),
}

impl LogInput {
    pub(crate) fn open(path: &Path) -> Result<Self> {
        let file = File::open(path).map_err(Error::Io)?;
        let about = file.metadata().map_err(Error::Io)?;
        if about.is_dir() {
            return Err(Error::Folder);
        }
        Ok(Self::File { file, length: about.len() })
    }

    pub(crate) fn length(&self) -> u64 {
        match self {
            Self::File { length, .. } => *length,
            Self::Memory(bytes) => bytes.len() as u64,
        }
    }

    /// Fills `into` from `offset` on; the caller has checked that this lies inside the log.
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

    /// Replaces `into` by `length` bytes from `offset` on.
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

    /// SHA-256 of the whole log in lower-case hexadecimal; `progress` is told the bytes.
    pub(crate) fn sha256(&self, progress: &(dyn Fn(u64) + Sync)) -> Result<String> {
        let mut hash = Sha256::new();
        self.each_part(self.length(), |part| {
            hash.update(part);
            progress(part.len() as u64);
        })
        .map_err(Error::Io)?;
        Ok(hash.finalize().iter().fold(String::with_capacity(64), |mut text, byte| {
            let _ = write!(text, "{byte:02x}");
            text
        }))
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
