//! Finds the named logs: files, folders of logs, rosbag2 folders, patterns.

use crate::log::rosbag2::{in_sqlite, is_database_name};
use crate::log::{Error, Result};
use crate::map::read_whole_text;
use crate::text::shown;
use std::path::{Path, PathBuf};

/// The recordings named by `named`, each as its files in order; inside a folder or a pattern they are sorted by name.
///
/// A folder with a `metadata.yaml` is one rosbag2 recording; its files are taken in the listed order. Any other folder means the `.mcap`
/// files in it, without one the `.parquet` files, and without one of these the `.csv` and `.tsv` files, each a separate recording. A name that is neither a file nor a folder is a pattern such as `logs/*.mcap`, which may also
/// match folders.
///
/// # Errors
/// The first of `named` that matches nothing. The caller adds its text before the reason.
pub(crate) fn find_logs(named: &Path) -> Result<Vec<Vec<PathBuf>>> {
    if named.is_dir() {
        let metadata = named.join("metadata.yaml");
        return if metadata.is_file() { Ok(vec![bag(named, &metadata)?]) } else { Ok(each(folder(named)?)) };
    }
    let text = named.to_string_lossy();
    if named.exists() || !text.contains(['*', '?', '[']) {
        return Ok(vec![vec![named.to_owned()]]); // the reader reports a missing file
    }
    let bad = |reason: String| Error::BadPattern { pattern: shown(named), reason };
    let mut found = Vec::new();
    for path in glob::glob(&text).map_err(|error| bad(error.to_string()))? {
        found.push(path.map_err(|error| bad(error.to_string()))?);
    }
    if found.is_empty() {
        return Err(Error::NoMatch { pattern: shown(named) });
    }
    found.sort();
    let mut recordings = Vec::new();
    for path in found {
        // matches exist: a folder name that looks like a pattern is taken literally
        recordings.extend(if path.is_dir() { find_logs(&path)? } else { vec![vec![path]] });
    }
    Ok(recordings)
}

fn each(files: Vec<PathBuf>) -> Vec<Vec<PathBuf>> {
    files.into_iter().map(|file| vec![file]).collect()
}

fn folder(folder: &Path) -> Result<Vec<PathBuf>> {
    let mut files = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(Error::Io)? {
        let path = entry.map_err(Error::Io)?.path();
        if path.is_file() {
            files.push(path);
        }
    }
    files.sort();
    for ends in KINDS {
        let is_one = |path: &&PathBuf| path.extension().is_some_and(|extension| ends.iter().any(|end| extension.eq_ignore_ascii_case(end)));
        let found: Vec<PathBuf> = files.iter().filter(is_one).cloned().collect();
        if !found.is_empty() {
            return Ok(found);
        }
    }
    let database = files.iter().find(|path| is_database_name(path));
    Err(database.map_or(Error::NoLogs, |database| in_sqlite(folder, Some(database))))
}

/// Ends of the names of logs in a folder. The first kind that the folder has is meant: tables beside MCAP logs are mostly made of them.
const KINDS: [&[&str]; 3] = [&["mcap"], &["parquet", "pq"], &["csv", "tsv"]];

/// The files of a rosbag2 recording: the list `relative_file_paths` of its metadata, which is simple enough to be read by line.
fn bag(folder: &Path, metadata: &Path) -> Result<Vec<PathBuf>> {
    const LARGEST: u64 = 16 << 20;
    if std::fs::metadata(metadata).map_err(Error::Io)?.len() > LARGEST {
        return crate::log::find_logs::folder(folder);
    }
    let text = read_whole_text(metadata).map_err(Error::Io)?;
    let mut files = Vec::new();
    let mut lines = text.lines().skip_while(|line| line.trim() != "relative_file_paths:");
    lines.next();
    for line in lines {
        let Some(file) = line.trim().strip_prefix("- ") else { break };
        let file = file.trim().trim_matches(['"', '\'']);
        // only the file name: a recording never refers to files outside its folder
        let Some(name) = Path::new(file).file_name() else { continue };
        let path = folder.join(name);
        if is_database_name(&path) {
            return Err(in_sqlite(folder, Some(&path)));
        }
        if !path.is_file() {
            return Err(Error::MissingBagFile { file: file.to_owned() });
        }
        files.push(path);
    }
    if files.is_empty() { crate::log::find_logs::folder(folder) } else { Ok(files) }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    /// Each recording's files, joined by `+`.
    fn names(found: &[Vec<PathBuf>]) -> Vec<String> {
        let name = |path: &PathBuf| path.file_name().unwrap().to_string_lossy().into_owned();
        found.iter().map(|files| files.iter().map(name).collect::<Vec<_>>().join("+")).collect()
    }

    #[test]
    fn a_folder_a_bag_and_a_pattern_mean_their_logs() {
        let folder = tempfile::tempdir().unwrap();
        for name in ["bag_1.mcap", "bag_0.mcap", "bag_10.mcap", "notes.txt"] {
            std::fs::write(folder.path().join(name), b"").unwrap();
        }
        assert_eq!(names(&find_logs(folder.path()).unwrap()), ["bag_0.mcap", "bag_1.mcap", "bag_10.mcap"]);
        assert_eq!(names(&find_logs(&folder.path().join("bag_?.mcap")).unwrap()), ["bag_0.mcap", "bag_1.mcap"]);
        assert!(matches!(find_logs(&folder.path().join("x*.mcap")), Err(Error::NoMatch { .. })));
        let listed = "rosbag2_bagfile_information:\n  relative_file_paths:\n    - bag_1.mcap\n    - bag_10.mcap\n  files:\n    - path: x\n";
        std::fs::write(folder.path().join("metadata.yaml"), listed).unwrap();
        assert_eq!(names(&find_logs(folder.path()).unwrap()), ["bag_1.mcap+bag_10.mcap"]);
        let bag = folder.path().file_name().unwrap().to_str().unwrap();
        let pattern = folder.path().parent().unwrap().join(format!("{}[{}]", &bag[..bag.len() - 1], &bag[bag.len() - 1..]));
        assert_eq!(names(&find_logs(&pattern).unwrap()), ["bag_1.mcap+bag_10.mcap"]);
        std::fs::remove_file(folder.path().join("bag_1.mcap")).unwrap();
        assert!(matches!(find_logs(folder.path()), Err(Error::MissingBagFile { .. })));
    }

    #[test]
    fn tables_are_the_logs_of_a_folder_without_mcap() {
        let folder = tempfile::tempdir().unwrap();
        for (name, meant) in [("b.csv", "b.csv"), ("a.TSV", "a.TSV b.csv"), ("c.parquet", "c.parquet"), ("d.mcap", "d.mcap")] {
            std::fs::write(folder.path().join(name), b"").unwrap();
            assert_eq!(names(&find_logs(folder.path()).unwrap()).join(" "), meant);
        }
    }

    #[test]
    fn a_recording_in_sqlite_is_answered_with_its_conversion() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("bag_0.db3"), b"").unwrap();
        let alone = find_logs(folder.path()).unwrap_err().to_string();
        std::fs::write(folder.path().join("metadata.yaml"), "x:\n  relative_file_paths:\n    - bag_0.db3\n").unwrap();
        let listed = find_logs(folder.path()).unwrap_err().to_string();
        assert!(alone == listed && alone.contains("ros2 bag convert -i ") && alone.contains("bag_0.mcap"), "{alone}");
    }

    #[test]
    fn a_folder_without_logs_is_an_error() {
        let folder = tempfile::tempdir().unwrap();
        assert!(matches!(find_logs(folder.path()), Err(Error::NoLogs)));
    }
}
