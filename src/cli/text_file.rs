//! Small text files on the command line: signal maps, vehicles, campaigns, gates, points.

use crate::map::read_whole_text;
use crate::text::shown;
use anyhow::Context;
use std::path::Path;

/// The text of a file.
///
/// # Errors
/// A file that is missing, too large or no text, with its path.
pub(crate) fn read_file(path: &Path) -> anyhow::Result<String> {
    read_whole_text(path).with_context(|| shown(path))
}
