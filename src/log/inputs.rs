//! Which logs are meant: files, folders of logs, rosbag2 folders, patterns.

use super::{Error, Result};
use std::path::{Path, PathBuf};

/// The log files that `named` means, each once, in the order named; inside a folder or a pattern by name.
///
/// A folder with a `metadata.yaml` is a rosbag2 recording, whose files are taken in the order that it lists; any other folder means the
/// `.mcap` files in it. What is no file and no folder is a pattern such as `logs/*.mcap`.
///
/// # Errors
/// The first of `named` that means nothing, with its text in front of the reason left to the caller.
pub fn find_logs(named: &Path) -> Result<Vec<PathBuf>> {
    if named.is_dir() {
        let metadata = named.join("metadata.yaml");
        return if metadata.is_file() { bag(named, &metadata) } else { folder(named) };
    }
    let text = named.to_string_lossy();
    if named.exists() || !text.contains(['*', '?', '[']) {
        return Ok(vec![named.to_owned()]); // reading it tells if it is missing
    }
    let bad = |reason: String| Error::BadPattern { pattern: text.to_string(), reason };
    let mut found = Vec::new();
    for path in glob::glob(&text).map_err(|error| bad(error.to_string()))? {
        found.push(path.map_err(|error| bad(error.to_string()))?);
    }
    if found.is_empty() {
        return Err(Error::NoMatch { pattern: text.into_owned() });
    }
    found.sort();
    Ok(found)
}

fn folder(folder: &Path) -> Result<Vec<PathBuf>> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(Error::Io)? {
        let path = entry.map_err(Error::Io)?.path();
        if path.is_file() && path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("mcap")) {
            found.push(path);
        }
    }
    found.sort();
    if found.is_empty() { Err(Error::NoLogs) } else { Ok(found) }
}

/// The files of a rosbag2 recording: the list `relative_file_paths` of its metadata, which is simple enough to be read by line.
fn bag(folder: &Path, metadata: &Path) -> Result<Vec<PathBuf>> {
    const LARGEST: u64 = 16 << 20;
    if std::fs::metadata(metadata).map_err(Error::Io)?.len() > LARGEST {
        return self::folder(folder);
    }
    let text = std::fs::read_to_string(metadata).map_err(Error::Io)?;
    let mut files = Vec::new();
    let mut lines = text.lines().skip_while(|line| line.trim() != "relative_file_paths:");
    lines.next();
    for line in lines {
        let Some(file) = line.trim().strip_prefix("- ") else { break };
        let file = file.trim().trim_matches(['"', '\'']);
        // the name only: a recording does not reach outside its folder
        let Some(name) = Path::new(file).file_name() else { continue };
        let path = folder.join(name);
        if !path.is_file() {
            return Err(Error::MissingBagFile { file: file.to_owned() });
        }
        files.push(path);
    }
    if files.is_empty() { self::folder(folder) } else { Ok(files) }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn names(found: &[PathBuf]) -> Vec<String> {
        found.iter().map(|path| path.file_name().unwrap().to_string_lossy().into_owned()).collect()
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
        assert_eq!(names(&find_logs(folder.path()).unwrap()), ["bag_1.mcap", "bag_10.mcap"]);
        std::fs::remove_file(folder.path().join("bag_1.mcap")).unwrap();
        assert!(matches!(find_logs(folder.path()), Err(Error::MissingBagFile { .. })));
    }

    #[test]
    fn a_folder_without_logs_is_an_error() {
        let folder = tempfile::tempdir().unwrap();
        assert!(matches!(find_logs(folder.path()), Err(Error::NoLogs)));
    }
}
