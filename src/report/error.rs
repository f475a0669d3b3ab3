//! Why there is no report.

use crate::text::shown;
use std::path::PathBuf;

/// Result of this module.
pub(crate) type Result<T> = std::result::Result<T, Error>;

/// Why there is no report. A missing optional file is not an error: the page notes it.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
#[allow(missing_docs)] // the message explains the fields
pub enum Error {
    #[error("{}: {source}; fit logs first, or give the folder that holds table1.json", shown(path))]
    NoTable1 { path: PathBuf, source: std::io::Error },
    #[error("{}: {source}", shown(path))]
    Read { path: PathBuf, source: std::io::Error },
    #[error("{}: {source}", shown(path))]
    Map { path: PathBuf, source: crate::map::Error },
    #[error("{}: {source}", shown(path))]
    Described { path: PathBuf, source: crate::invert::Error },
    #[error("there is no table2.json, whose place the table is to take: run `pivot-cal invert` first")]
    NoTable2,
    #[error("{}: {source}", shown(path))]
    Verdict { path: PathBuf, source: crate::verify::Error },
    #[error(transparent)]
    Table(#[from] crate::map::Error),
    #[error("the page's data cannot be written as JSON: {0}")]
    Json(#[from] serde_json::Error),
}
