//! Why a map of a controller or a tool cannot be read.

use crate::text::shown;
use std::path::PathBuf;

/// Result of this room.
pub(crate) type Result<T> = std::result::Result<T, Error>;

/// Why a map cannot be read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
#[allow(missing_docs)] // the message explains the fields
pub(crate) enum Error {
    #[error("{}: {source}", shown(path))]
    Read { path: PathBuf, source: std::io::Error },
    #[error("{}, line {line}: {what}", shown(path))]
    Line { path: PathBuf, line: u64, what: String },
    #[error("{} ({format}): {what}", shown(path))]
    Content { path: PathBuf, format: &'static str, what: String },
    #[error("{}: {source}", shown(path))]
    File { path: PathBuf, source: crate::map::Error },
}

/// What is wrong in a text, and in which line; 0 for the whole.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct TextFault {
    pub(crate) line: u64,
    pub(crate) what: String,
}

impl TextFault {
    pub(crate) fn at(line: u64, what: impl Into<String>) -> Self {
        Self { line, what: what.into() }
    }

    pub(crate) fn whole(what: impl Into<String>) -> Self {
        Self::at(0, what)
    }
}
