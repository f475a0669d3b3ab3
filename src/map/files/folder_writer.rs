//! The files of one generation: made in memory, written together.
//!
//! In: the files, by name. Out: a folder that holds all of them. While they are made, the folder keeps what it held; then each file is written
//! beside its place, and at last all are renamed. A reader in between sees files of two generations, knows it by their hashes, and reads
//! again ([`read_settled`]). A process that is killed in between leaves a folder whose mismatch every command finds.

use crate::map::Result;
use crate::map::files::csv_name::is_csv_name;
use crate::map::files::fault;
use crate::map::files::folder_lock::{FolderLock, is_written};
use crate::map::files::read::read_whole;
use crate::map::files::save::{StagedFile, sync_folder};
use std::collections::BTreeMap;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

/// How often a folder that is being written is read again, and the pause before. Renaming a generation takes milliseconds.
const TRIES: usize = 100;
const PAUSE: Duration = Duration::from_millis(20);

/// A folder as its files are read: those that are made and not yet written, otherwise those on disk.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct FolderView {
    /// The folder.
    pub path: PathBuf,
    made: Arc<BTreeMap<String, Vec<u8>>>,
    /// Whether this process is the one that writes into the folder.
    is_own: bool,
}

impl From<&Path> for FolderView {
    fn from(path: &Path) -> Self {
        Self { path: path.to_owned(), made: Arc::default(), is_own: false }
    }
}

impl FolderView {
    /// A folder that this process has the right to write into: what is read there does not change meanwhile.
    pub(crate) fn own(path: &Path) -> Self {
        Self { is_own: true, ..Self::from(path) }
    }

    /// The bytes of a file.
    ///
    /// # Errors
    /// Any error of the file system.
    pub(crate) fn read(&self, name: &str) -> io::Result<Vec<u8>> {
        self.made.get(name).map_or_else(|| read_whole(&self.path.join(name)), |bytes| Ok(bytes.clone()))
    }
}

/// What `read` gives, read again while its parts do not fit together and another process writes into the folder.
pub(crate) fn read_settled<T>(view: &FolderView, read: impl Fn() -> T, fits_together: impl Fn(&T) -> bool) -> T {
    let mut found = read();
    for _ in 0..TRIES {
        if fits_together(&found) || view.is_own || !is_written(&view.path) {
            break;
        }
        std::thread::sleep(PAUSE);
        found = read();
    }
    found
}

/// A generation of files on its way into a folder.
#[derive(Debug)]
pub(crate) struct FolderWriter {
    path: PathBuf,
    /// The files in the order in which they were made.
    files: Vec<(String, Vec<u8>)>,
    /// Files of an earlier generation that would be taken for ones of this.
    stale: Vec<Stale>,
    _lock: FolderLock,
}

/// A file that must not stay.
#[derive(Debug)]
enum Stale {
    /// Every CSV of this table that is not among the new files.
    Csvs(&'static str),
    /// This file.
    File(&'static str),
}

impl FolderWriter {
    /// The right to write into `folder`, which is made if it is missing.
    ///
    /// # Errors
    /// Another process writes there; a folder that cannot be made.
    pub(crate) fn open(folder: &Path) -> Result<Self> {
        Ok(Self { path: folder.to_owned(), files: Vec::new(), stale: Vec::new(), _lock: FolderLock::take(folder)? })
    }

    /// Adds a file.
    pub(crate) fn put(&mut self, name: &str, text: impl Into<Vec<u8>>) {
        self.files.retain(|(other, _)| other != name);
        self.files.push((name.to_owned(), text.into()));
    }

    /// Removes the CSV files of `table` that are not among the new files: one of an earlier run would be taken for one of this run.
    pub(crate) fn replaces_csvs_of(&mut self, table: &'static str) {
        self.stale.push(Stale::Csvs(table));
    }

    /// Removes a file that an earlier run may have left.
    pub(crate) fn removes(&mut self, name: &'static str) {
        self.stale.push(Stale::File(name));
    }

    /// The folder as it will be.
    pub(crate) fn view(&self) -> FolderView {
        FolderView { path: self.path.clone(), made: Arc::new(self.files.iter().cloned().collect()), is_own: true }
    }

    /// Writes everything.
    ///
    /// # Errors
    /// Any error of the file system. Before the first rename it leaves the folder as it was.
    pub(crate) fn commit(self) -> Result<()> {
        let staged = self.files.iter().map(|(name, bytes)| StagedFile::new(&self.path.join(name), bytes)).collect::<Result<Vec<_>>>()?;
        let mut folders: Vec<PathBuf> = Vec::new();
        for file in staged {
            fault::before_rename();
            folders.extend(file.put()?.filter(|folder| !folders.contains(folder)));
        }
        for stale in &self.stale {
            self.remove(stale)?;
        }
        folders.iter().try_for_each(|folder| sync_folder(folder, &self.path))
    }

    fn remove(&self, stale: &Stale) -> Result<()> {
        let is_new = |name: &str| self.files.iter().any(|(new, _)| new == name);
        let gone = |path: PathBuf| match std::fs::remove_file(&path) {
            Err(source) if source.kind() != io::ErrorKind::NotFound => Err(crate::map::Error::Io { path, source }),
            _ => Ok(()),
        };
        match stale {
            Stale::File(name) if is_new(name) => Ok(()),
            Stale::File(name) => gone(self.path.join(name)),
            Stale::Csvs(table) => {
                let entries = std::fs::read_dir(&self.path).into_iter().flatten().flatten();
                let mut names = entries.filter_map(|entry| entry.file_name().into_string().ok());
                names.try_for_each(|name| if is_csv_name(&name, table) && !is_new(&name) { gone(self.path.join(name)) } else { Ok(()) })
            }
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn a_generation_is_seen_in_memory_first_and_written_together() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        for (name, text) in [("table1.csv", "old"), ("table1.reverse.csv", "old"), ("verify_traces.json", "old"), ("notes.txt", "mine")] {
            std::fs::write(at(name), text).unwrap();
        }
        let mut writer = FolderWriter::open(folder.path()).unwrap();
        writer.put("table1.csv", "new");
        writer.replaces_csvs_of("table1");
        writer.removes("verify_traces.json");
        assert_eq!(writer.view().read("table1.csv").unwrap(), b"new");
        assert_eq!(writer.view().read("notes.txt").unwrap(), b"mine");
        assert_eq!(std::fs::read(at("table1.csv")).unwrap(), b"old");
        writer.commit().unwrap();
        assert_eq!(std::fs::read(at("table1.csv")).unwrap(), b"new");
        assert!(!at("table1.reverse.csv").exists() && !at("verify_traces.json").exists() && at("notes.txt").exists());
    }

    #[test]
    fn a_file_that_cannot_be_written_leaves_the_folder_as_it_was() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("table1.csv"), "old").unwrap();
        std::fs::create_dir(folder.path().join("table1.json")).unwrap();
        let mut writer = FolderWriter::open(folder.path()).unwrap();
        writer.put("table1.csv", "new");
        writer.put("table1.json", "{}");
        assert!(writer.commit().is_err());
        assert_eq!(std::fs::read(folder.path().join("table1.csv")).unwrap(), b"old");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 2, "no temporary file is left");
    }

    #[test]
    fn a_reader_reads_again_until_the_writer_has_finished() {
        let folder = tempfile::tempdir().unwrap();
        let view = FolderView::from(folder.path());
        let lock = FolderLock::take(folder.path()).unwrap();
        let writer = std::thread::spawn(move || {
            std::thread::sleep(Duration::from_millis(60));
            drop(lock);
        });
        let path = folder.path().to_owned();
        let reads = read_settled(&view, || is_written(&path), |written| !written);
        writer.join().unwrap();
        assert!(!reads, "the last reading is the one after the writer");
    }
}
