//! The folder of a map: the files that stages read, and the removal of files of earlier runs.

use crate::calibrate::error::About as _;
use crate::calibrate::{Error, Result};
use crate::map::{FolderError, MapFolder, Mismatch, is_csv_name};
use std::io::ErrorKind;
use std::path::Path;

/// Reads `table1.json` and the CSV files that it names.
///
/// # Errors
/// A file that is missing or cannot be read.
pub(crate) fn read_table1(folder: &Path) -> Result<(MapFolder, Vec<Mismatch>)> {
    MapFolder::read_table1(folder).or_else(|error| match error {
        FolderError::Read { path, source } => {
            let what = if source.kind() == ErrorKind::InvalidData { "read from" } else { "open" };
            let error = Error::About { what: format!("failed to {what} file `{}`", path.display()), source: Box::new(source.into()) };
            Err(Error::NoTable1 { source: Box::new(error) })
        }
        FolderError::File { path, source } => Err(source).in_file(&path),
    })
}

/// Removes the CSV files of `table` in `folder` that are not among `kept`: a table of an earlier run would be taken for one of this run.
pub(crate) fn remove_stale<'a>(folder: &Path, table: &str, kept: impl Iterator<Item = &'a str>) -> Result<()> {
    let kept: Vec<&str> = kept.collect();
    let Ok(entries) = std::fs::read_dir(folder) else { return Ok(()) };
    for entry in entries {
        let name = entry?.file_name();
        if let Some(name) = name.to_str().filter(|n| is_csv_name(n, table) && !kept.contains(n)) {
            fs_err::remove_file(folder.join(name))?;
        }
    }
    Ok(())
}
