//! Files written whole or not at all.

use crate::map::files::destination::{Destination, write_standard_output, write_stream};
use crate::map::files::leftovers::{PREFIX, remove_leftovers};
use crate::map::{Error, Result};
use sha2::{Digest, Sha256};
use std::fmt::Write as _;
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};
use tempfile::NamedTempFile;

/// Writes `bytes` to `path`. A file is written beside itself, synced, and renamed onto its name: a reader sees the old file or the new one,
/// never half of one. Missing folders are made. A link stays, and what it leads to is replaced; a device, a pipe or standard output (`-`) is
/// written to.
///
/// # Errors
/// Any error of the file system, with the path.
pub(crate) fn write_whole(path: &Path, bytes: &[u8]) -> Result<()> {
    StagedFile::new(path, bytes)?.put()?.map_or(Ok(()), |folder| sync_folder(&folder, path))
}

/// A file that is written in full beside its place, and not yet there.
#[derive(Debug)]
pub(crate) struct StagedFile {
    path: PathBuf,
    /// The temporary file and its place; `None` where there was nothing to wait for, since the bytes went to a stream.
    waiting: Option<(NamedTempFile, PathBuf)>,
}

impl StagedFile {
    /// Writes `bytes` beside the place that `path` leads to. To a stream they are written at once.
    ///
    /// # Errors
    /// Any error of the file system, with the path.
    pub(crate) fn new(path: &Path, bytes: &[u8]) -> Result<Self> {
        let at = |source| Error::Io { path: path.to_owned(), source };
        let waiting = match Destination::of(path).map_err(at)? {
            Destination::StandardOutput => write_standard_output(bytes).map_err(at).map(|()| None)?,
            Destination::Stream(stream) => write_stream(&stream, bytes).map_err(at).map(|()| None)?,
            Destination::File(place) => Some((written_beside(&place, bytes).map_err(at)?, place)),
        };
        Ok(Self { path: path.to_owned(), waiting })
    }

    /// Moves the file to its place. Returns its folder, which is to be synced ([`sync_folder`]).
    ///
    /// # Errors
    /// Any error of the file system, with the path.
    pub(crate) fn put(self) -> Result<Option<PathBuf>> {
        let Some((file, place)) = self.waiting else { return Ok(None) };
        match file.persist(&place) {
            Ok(_) => Ok(Some(folder_of(&place).to_owned())),
            Err(error) => Err(Error::Io { path: self.path, source: error.error }),
        }
    }
}

/// Makes the names in `folder` last. File systems that cannot sync a folder keep them in their own order.
///
/// # Errors
/// A disk that fails; `path` is the file that was written.
pub(crate) fn sync_folder(folder: &Path, path: &Path) -> Result<()> {
    #[cfg(unix)]
    match std::fs::File::open(folder).and_then(|folder| folder.sync_all()) {
        Err(source) if matches!(source.raw_os_error(), Some(EIO | ENOSPC | EDQUOT)) => {
            return Err(Error::Io { path: path.to_owned(), source });
        }
        _ => {}
    }
    let _ = (folder, path);
    Ok(())
}

/// Linux's numbers of the errors of a disk that fails or is full.
#[cfg(unix)]
const EIO: i32 = 5;
#[cfg(unix)]
const ENOSPC: i32 = 28;
#[cfg(unix)]
const EDQUOT: i32 = 122;

fn written_beside(place: &Path, bytes: &[u8]) -> io::Result<NamedTempFile> {
    let folder = folder_of(place);
    std::fs::create_dir_all(folder)?;
    remove_leftovers(folder);
    let mut builder = tempfile::Builder::new();
    builder.prefix(PREFIX);
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        // the mode of a plain `File::create`; the process's umask still applies
        builder.permissions(std::fs::Permissions::from_mode(0o666));
    }
    let file = builder.tempfile_in(folder).map_err(|error| without_temporary_path(&error))?;
    file.as_file().write_all(bytes)?;
    file.as_file().sync_all()?;
    Ok(file)
}

fn folder_of(place: &Path) -> &Path {
    place.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// The error without the name of the temporary file, which says nothing to anybody: `tempfile` adds it.
fn without_temporary_path(error: &io::Error) -> io::Error {
    let text = error.to_string();
    let cause = text.rsplit_once(" at path ").map_or(text.as_str(), |(cause, _)| cause);
    io::Error::new(error.kind(), cause.to_owned())
}

/// SHA-256 of `bytes` in lower-case hexadecimal.
pub fn sha256_hex(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().fold(String::with_capacity(64), |mut text, byte| {
        let _ = write!(text, "{byte:02x}");
        text
    })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn the_hash_is_the_published_test_vector() {
        assert_eq!(sha256_hex(b"abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
    }

    #[test]
    fn a_file_replaces_the_old_one_and_leaves_nothing_beside_it() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("deep/table1.csv");
        write_whole(&path, b"old").unwrap();
        write_whole(&path, b"new").unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), b"new");
        assert_eq!(std::fs::read_dir(path.parent().unwrap()).unwrap().count(), 1);
    }

    #[test]
    fn an_error_names_the_file_that_was_asked_for_and_not_the_temporary_one() {
        let folder = tempfile::tempdir().unwrap();
        let blocker = folder.path().join("blocker");
        write_whole(&blocker, b"a file").unwrap();
        let error = write_whole(&blocker.join("table1.json"), b"x").unwrap_err().to_string();
        assert!(error.contains("blocker") && !error.contains(PREFIX), "{error}");
        let missing = tempfile::Builder::new().prefix(PREFIX).tempfile_in(folder.path().join("missing")).unwrap_err();
        let shown = without_temporary_path(&missing).to_string();
        assert!(shown.contains("No such file") && !shown.contains(PREFIX), "{shown}");
    }

    #[cfg(unix)]
    #[test]
    fn a_link_stays_and_what_it_leads_to_is_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let (file, link) = (folder.path().join("real.json"), folder.path().join("link.json"));
        std::os::unix::fs::symlink("real.json", &link).unwrap();
        write_whole(&link, b"first").unwrap();
        write_whole(&link, b"second").unwrap();
        assert!(std::fs::symlink_metadata(&link).unwrap().is_symlink());
        assert_eq!(std::fs::read(&file).unwrap(), b"second");
    }

    #[cfg(unix)]
    #[test]
    fn a_device_is_written_to() {
        write_whole(Path::new("/dev/null"), b"anything").unwrap();
        assert!(std::os::unix::fs::FileTypeExt::is_char_device(&std::fs::metadata("/dev/null").unwrap().file_type()));
        assert!(write_whole(Path::new("/dev/full"), b"anything").is_err());
    }
}
