//! Why two maps cannot be read for a comparison. Maps that do not belong together are a verdict, not an error.

use crate::text::shown;
use std::path::PathBuf;

/// Result of this room.
pub(crate) type Result<T> = std::result::Result<T, Error>;

/// Why a map cannot be read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
#[allow(missing_docs)] // the fields are what the message says
pub(crate) enum Error {
    #[error("{}: {source}; give a table1.json, a table2.json, or the folder of a map, whose table2.json is used", shown(path))]
    Read { path: PathBuf, source: std::io::Error },
    #[error(
        "{}: {file} is not the one that the other files describe: the folder holds files of several runs; give a file of it, or make the map again",
        shown(path)
    )]
    Mixed { path: PathBuf, file: String },
    #[error("{}: {source}", shown(path))]
    File { path: PathBuf, source: crate::map::Error },
}
