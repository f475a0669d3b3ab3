//! Files that are read whole: maps, signal maps, vehicles, campaigns; any but a log.
//!
//! In: a path. Out: its bytes or its text, if it has no more than 256 MiB.

use std::fs::File;
use std::io::{self, ErrorKind, Read as _};
use std::path::Path;

/// Largest file that is read whole [bytes]. The largest of them, traces of 500 runs, has under 10 MB.
const LARGEST_FILE: u64 = 256 << 20;

/// The bytes of a file.
///
/// # Errors
/// Any error of the file system; more than 256 MiB, with that number.
pub(crate) fn read_whole(path: &Path) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    File::open(path)?.take(LARGEST_FILE + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > LARGEST_FILE {
        let text = format!("it has more than {LARGEST_FILE} bytes; no file of a map or a setting has as many");
        return Err(io::Error::new(ErrorKind::FileTooLarge, text));
    }
    Ok(bytes)
}

/// The text of a file.
///
/// # Errors
/// As [`read_whole`], and bytes that are not UTF-8.
pub(crate) fn read_whole_text(path: &Path) -> io::Result<String> {
    String::from_utf8(read_whole(path)?).map_err(|_| io::Error::new(ErrorKind::InvalidData, "stream did not contain valid UTF-8"))
}
