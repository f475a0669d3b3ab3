//! Table 1 with its CSV files, as the commands read it that make something from it.

use crate::map::{FolderError, MapFolder, Mismatch};
use anyhow::Error;
use std::io::ErrorKind;
use std::path::Path;

/// Reads `table1.json` and the CSV files that it names.
pub(crate) fn read(folder: &Path) -> anyhow::Result<(MapFolder, Vec<Mismatch>)> {
    MapFolder::read_table1(folder).map_err(|error| match error {
        FolderError::Read { path, source } => {
            let what = if source.kind() == ErrorKind::InvalidData { "read from" } else { "open" };
            Error::new(source)
                .context(format!("failed to {what} file `{}`", path.display()))
                .context("Table 1 is made by `pivot-cal fit LOG…`; --maps names its folder")
        }
        FolderError::File { path, source } => Error::new(source).context(path.display().to_string()),
    })
}
