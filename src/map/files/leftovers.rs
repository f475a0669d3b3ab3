//! Temporary files of runs that were killed: found and removed by the next run that writes into their folder.

use std::collections::HashSet;
use std::path::{Path, PathBuf};
use std::sync::{LazyLock, Mutex, PoisonError};
use std::time::{Duration, SystemTime};

/// Beginning of the name of a temporary file.
pub(crate) const PREFIX: &str = ".pivot-cal-";
/// Characters after it.
const RANDOM: usize = 6;
/// Age from which a temporary file belongs to no run that still works: one lives for the time of writing a few megabytes.
const OLD: Duration = Duration::from_hours(1);

/// Folders that were looked through by this process.
static SEEN: LazyLock<Mutex<HashSet<PathBuf>>> = LazyLock::new(Mutex::default);

/// Removes the temporary files in `folder` that a killed run has left: only files, only by our name, only old ones. A folder is looked through
/// once per process; what cannot be removed stays.
pub(crate) fn remove_leftovers(folder: &Path) {
    let first = SEEN.lock().unwrap_or_else(PoisonError::into_inner).insert(folder.to_owned());
    if first {
        remove_older(folder, SystemTime::now());
    }
}

fn remove_older(folder: &Path, now: SystemTime) {
    let Ok(entries) = std::fs::read_dir(folder) else { return };
    for entry in entries.flatten() {
        let is_ours = entry.file_name().to_str().and_then(|name| name.strip_prefix(PREFIX)).is_some_and(is_random);
        if !is_ours || !entry.file_type().is_ok_and(|kind| kind.is_file()) {
            continue;
        }
        let age = entry.metadata().and_then(|metadata| metadata.modified()).ok().and_then(|written| now.duration_since(written).ok());
        if age.is_some_and(|age| age >= OLD) {
            let _ = std::fs::remove_file(entry.path());
        }
    }
}

fn is_random(rest: &str) -> bool {
    rest.len() == RANDOM && rest.chars().all(|c| c.is_ascii_alphanumeric())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use std::fs::File;

    #[test]
    fn only_old_temporary_files_of_this_program_are_removed() {
        let folder = tempfile::tempdir().unwrap();
        let now = SystemTime::now();
        for (name, age_s) in [
            (".pivot-cal-aB3dE9", 7200),
            (".pivot-cal-fresh1", 60),
            (".pivot-cal-notes.txt", 7200),
            (".other-aB3dE9", 7200),
            ("table1.json", 7200),
        ] {
            let file = File::create(folder.path().join(name)).unwrap();
            file.set_modified(now - Duration::from_secs(age_s)).unwrap();
        }
        std::fs::create_dir(folder.path().join(".pivot-cal-folder")).unwrap();
        remove_older(folder.path(), now + Duration::from_secs(1));
        let mut left: Vec<String> =
            std::fs::read_dir(folder.path()).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        left.sort();
        assert_eq!(left, [".other-aB3dE9", ".pivot-cal-folder", ".pivot-cal-fresh1", ".pivot-cal-notes.txt", "table1.json"]);
    }

    #[test]
    fn the_name_of_a_temporary_file_is_recognised() {
        let folder = tempfile::tempdir().unwrap();
        let file = tempfile::Builder::new().prefix(PREFIX).tempfile_in(folder.path()).unwrap();
        let name = file.path().file_name().unwrap().to_str().unwrap().to_owned();
        assert!(name.strip_prefix(PREFIX).is_some_and(is_random), "{name}");
    }
}
