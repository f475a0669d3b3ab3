//! The controller file of `--controller-settings`.

use crate::cli::text_file::read_file;
use crate::controller::ControllerFile;
use crate::text::shown;
use anyhow::Context;
use std::path::Path;

/// The file's settings; without a file those of the program.
///
/// # Errors
/// A file that cannot be read or is no controller file.
pub(crate) fn read(path: Option<&Path>) -> anyhow::Result<ControllerFile> {
    match path {
        Some(path) => ControllerFile::from_toml(&read_file(path)?).with_context(|| shown(path)),
        None => Ok(ControllerFile::bundled()?),
    }
}
