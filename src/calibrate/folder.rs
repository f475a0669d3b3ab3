//! The folder of a map as the stages read it.

use crate::calibrate::error::About as _;
use crate::calibrate::{Error, Result};
use crate::map::{FolderError, FolderView, MapFolder, Mismatch};
use crate::text::shown;
use std::io::ErrorKind;

/// Reads `table1.json` and the CSV files that it names.
///
/// # Errors
/// A file that is missing or cannot be read.
pub(crate) fn read_table1(folder: &FolderView) -> Result<(MapFolder, Vec<Mismatch>)> {
    MapFolder::read_table1(folder).or_else(|error| match error {
        FolderError::Read { path, source } => {
            let what = if source.kind() == ErrorKind::InvalidData { "read from" } else { "open" };
            let error = Error::About { what: format!("failed to {what} file `{}`", shown(&path)), source: Box::new(source.into()) };
            Err(Error::NoTable1 { source: Box::new(error) })
        }
        FolderError::File { path, source } => Err(source).in_file(&path),
    })
}
