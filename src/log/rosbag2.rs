//! rosbag2 recordings in SQLite: which files they are, and the command that converts them.

use crate::log::file::input::LogInput;
use crate::log::{Error, Result};
use crate::text::shown;
use std::path::Path;

/// First bytes of a database of SQLite.
const SQLITE: &[u8] = b"SQLite format 3";

/// Whether a file's name is that of rosbag2's database.
pub(crate) fn is_database_name(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("db3"))
}

/// Whether the log at `path` is no database.
///
/// # Errors
/// It is one; the error has the command that converts it.
pub(crate) fn expect_no_database(path: &Path, input: &LogInput) -> Result<()> {
    let mut start = vec![0; input.length().min(SQLITE.len() as u64) as usize];
    input.read_at(0, &mut start).map_err(Error::Io)?;
    if start == SQLITE { Err(in_sqlite(path, Some(path))) } else { Ok(()) }
}

/// The error of the recording `bag`, a folder or a file; `database` is one of its files.
pub(crate) fn in_sqlite(bag: &Path, database: Option<&Path>) -> Error {
    let name = |path: &Path| path.file_name().map(shown).unwrap_or_default();
    let folder = format!("{}_mcap", name(bag).trim_end_matches(".db3"));
    let (from, to) = (quoted(&shown(bag)), quoted(&folder));
    let without_ros = database.map(|database| {
        let mcap = format!("{}.mcap", name(database).trim_end_matches(".db3"));
        format!("; or without ROS 2: mcap convert {} {}", quoted(&shown(database)), quoted(&mcap))
    });
    Error::Sqlite {
        converted: folder,
        command: format!(
            r"printf 'output_bags:\n- uri: %s\n  storage_id: mcap\n  all: true\n' {to} > convert.yaml && ros2 bag convert -i {from} -o convert.yaml"
        ),
        without_ros: without_ros.unwrap_or_default(),
    }
}

/// A name as a shell takes it.
fn quoted(name: &str) -> String {
    let is_plain = !name.is_empty() && name.chars().all(|c| c.is_ascii_alphanumeric() || matches!(c, '/' | '.' | '_' | '-' | '+' | ','));
    if is_plain { name.to_owned() } else { format!("'{}'", name.replace('\'', r"'\''")) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_converts_a_folder_or_a_file_whatever_its_name_is() {
        let text = in_sqlite("logs/drive 1".as_ref(), None).to_string();
        let command = r"printf 'output_bags:\n- uri: %s\n  storage_id: mcap\n  all: true\n' 'drive 1_mcap' > convert.yaml && ros2 bag convert -i 'logs/drive 1' -o convert.yaml";
        assert!(text.ends_with(command), "{text}");
        let file: &Path = "a/b.db3".as_ref();
        let text = in_sqlite(file, Some(file)).to_string();
        assert!(text.contains("ros2 bag convert -i a/b.db3 -o convert.yaml") && text.ends_with("mcap convert a/b.db3 b.mcap"), "{text}");
    }
}
