//! The right to write into a folder of maps: one process at a time.
//!
//! The folder itself is locked (`flock`), so that no file is left behind, and a killed process holds nothing. File systems without such locks
//! are written to unlocked.

use crate::map::{Error, Result};
use std::fs::{File, TryLockError};
use std::path::{Path, PathBuf};
use std::time::Duration;

/// How often a lock is tried before its holder counts as at work: readers hold it for an instant to ask.
const TRIES: usize = 10;
const PAUSE: Duration = Duration::from_millis(10);

/// The right to write into a folder; it ends with this value or with the process.
#[derive(Debug)]
pub(crate) struct FolderLock {
    /// The locked folder.
    #[allow(dead_code)] // it is held, not read
    folder: Option<File>,
    /// The folder, if it was made for the lock: it is removed if nothing was written into it.
    made: Option<PathBuf>,
}

impl FolderLock {
    /// Locks `folder`, which is made if it is missing.
    ///
    /// # Errors
    /// Another process is at work in the folder; a folder that cannot be made.
    pub(crate) fn take(folder: &Path) -> Result<Self> {
        let at = |source| Error::Io { path: folder.to_owned(), source };
        let made = (!folder.exists()).then(|| folder.to_owned());
        std::fs::create_dir_all(folder).map_err(at)?;
        let Ok(opened) = File::open(folder) else { return Ok(Self { folder: None, made }) };
        for _ in 0..TRIES {
            match opened.try_lock() {
                Ok(()) => return Ok(Self { folder: Some(opened), made }),
                Err(TryLockError::WouldBlock) => std::thread::sleep(PAUSE),
                Err(TryLockError::Error(_)) => return Ok(Self { folder: None, made }),
            }
        }
        Err(Error::Busy { folder: folder.to_owned() })
    }
}

impl Drop for FolderLock {
    fn drop(&mut self) {
        if let Some(folder) = &self.made {
            let _ = std::fs::remove_dir(folder); // only if it is empty
        }
    }
}

/// Whether a process has the right to write into `folder` now.
pub(crate) fn is_written(folder: &Path) -> bool {
    File::open(folder).is_ok_and(|folder| matches!(folder.try_lock_shared(), Err(TryLockError::WouldBlock)))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn a_folder_has_one_writer_at_a_time() {
        let folder = tempfile::tempdir().unwrap();
        let first = FolderLock::take(folder.path()).unwrap();
        assert!(is_written(folder.path()));
        let error = FolderLock::take(folder.path()).unwrap_err().to_string();
        assert!(error.contains("another pivot-cal is writing"), "{error}");
        drop(first);
        assert!(!is_written(folder.path()));
        FolderLock::take(folder.path()).unwrap();
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0, "nothing is left in the folder");
    }

    #[test]
    fn a_folder_that_was_made_for_nothing_is_removed() {
        let outer = tempfile::tempdir().unwrap();
        let folder = outer.path().join("maps");
        drop(FolderLock::take(&folder).unwrap());
        assert!(!folder.exists());
        let lock = FolderLock::take(&folder).unwrap();
        std::fs::write(folder.join("table1.json"), "{}").unwrap();
        drop(lock);
        assert!(folder.exists());
    }
}
