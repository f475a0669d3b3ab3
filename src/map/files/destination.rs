//! Where a path that is written to leads: standard output, something that is open or is no file, or a file.
//!
//! A file is replaced whole (`save.rs`). Whatever else a path names is written to and stays what it is: a device, a pipe, a descriptor of
//! this process. A link stays a link, and what it leads to is replaced.

use std::ffi::OsStr;
use std::fs::OpenOptions;
use std::io::{self, ErrorKind, Write};
use std::path::{Path, PathBuf};

/// Most links that are followed, as in the kernel.
const MOST_LINKS: usize = 40;

/// Where a path leads.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Destination {
    /// Standard output of this process.
    StandardOutput,
    /// A device, a named pipe, or a descriptor that is open: written to, never replaced.
    Stream(PathBuf),
    /// A file, which may not exist yet.
    File(PathBuf),
}

impl Destination {
    /// Where `path` leads. `-` is standard output, as are `/dev/stdout` and `/dev/fd/1`.
    ///
    /// # Errors
    /// A folder, a disk or a socket; links without end; any error of the file system but that there is no file yet.
    pub(crate) fn of(path: &Path) -> io::Result<Self> {
        if path.as_os_str() == "-" {
            return Ok(Self::StandardOutput);
        }
        let mut at = path.to_owned();
        for _ in 0..MOST_LINKS {
            let kind = match std::fs::symlink_metadata(&at) {
                Ok(metadata) => metadata.file_type(),
                Err(error) if error.kind() == ErrorKind::NotFound => return Ok(Self::File(at)),
                Err(error) => return Err(error),
            };
            if kind.is_dir() {
                return Err(io::Error::new(ErrorKind::IsADirectory, "is a folder; a file is needed"));
            }
            if kind.is_file() {
                return Ok(Self::File(at));
            }
            if !kind.is_symlink() {
                return if is_stream(kind) {
                    Ok(Self::Stream(at))
                } else {
                    Err(io::Error::new(ErrorKind::InvalidInput, "is neither a file nor a stream that can be written to"))
                };
            }
            if let Some(is_own_output) = descriptor(&at) {
                return Ok(if is_own_output { Self::StandardOutput } else { Self::Stream(at) });
            }
            let leads_to = std::fs::read_link(&at)?;
            at = at.parent().map_or_else(|| leads_to.clone(), |folder| folder.join(&leads_to));
        }
        Err(io::Error::new(ErrorKind::InvalidInput, "is a link that leads to itself"))
    }

    /// Whether what is written there mixes with what the command prints.
    pub(crate) fn is_standard_output(path: &Path) -> bool {
        matches!(Self::of(path), Ok(Self::StandardOutput))
    }
}

/// Writes `bytes` to standard output. A reader that has closed the pipe wants no more: that is no error.
///
/// # Errors
/// Any other error, such as a full device.
pub(crate) fn write_standard_output(bytes: &[u8]) -> io::Result<()> {
    let mut output = io::stdout().lock();
    match output.write_all(bytes).and_then(|()| output.flush()) {
        Err(error) if error.kind() == ErrorKind::BrokenPipe => Ok(()),
        other => other,
    }
}

/// Writes `bytes` into the stream at `path`, from its present end.
///
/// # Errors
/// A stream that cannot be opened or written to.
pub(crate) fn write_stream(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let mut stream = OpenOptions::new().append(true).open(path)?;
    stream.write_all(bytes)?;
    stream.flush()
}

#[cfg(unix)]
fn is_stream(kind: std::fs::FileType) -> bool {
    use std::os::unix::fs::FileTypeExt;
    kind.is_char_device() || kind.is_fifo()
}

#[cfg(not(unix))]
fn is_stream(_: std::fs::FileType) -> bool {
    false
}

/// Whether `link` is an open descriptor (`/proc/self/fd/3`, whatever leads there), and if so, whether it is standard output of this process.
/// Such a link must not be followed by name: its text may be `pipe:[1234]`, or the name of a file whose place another one has taken.
fn descriptor(link: &Path) -> Option<bool> {
    let folder = link.parent()?.canonicalize().ok()?;
    let is_descriptor = folder.starts_with("/proc") && folder.file_name() == Some(OsStr::new("fd"));
    let own = Path::new("/proc").join(std::process::id().to_string()).join("fd");
    is_descriptor.then(|| folder == own && link.file_name() == Some(OsStr::new("1")))
}

#[cfg(all(test, unix))]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use std::os::unix::fs::symlink;

    #[test]
    fn devices_descriptors_and_a_dash_are_no_files() {
        assert_eq!(Destination::of(Path::new("-")).unwrap(), Destination::StandardOutput);
        assert_eq!(Destination::of(Path::new("/dev/null")).unwrap(), Destination::Stream("/dev/null".into()));
        if Path::new("/proc/self/fd/1").exists() {
            for path in ["/dev/stdout", "/dev/fd/1", "/proc/self/fd/1"] {
                assert_eq!(Destination::of(Path::new(path)).unwrap(), Destination::StandardOutput, "{path}");
            }
            assert!(matches!(Destination::of(Path::new("/dev/stderr")).unwrap(), Destination::Stream(_)));
        }
    }

    #[test]
    fn a_chain_of_links_ends_at_the_file_even_if_it_does_not_exist_yet() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        symlink("second", at("first")).unwrap();
        symlink(at("deep.json"), at("second")).unwrap();
        assert_eq!(Destination::of(&at("first")).unwrap(), Destination::File(at("deep.json")));
        symlink("/dev/null", at("nothing")).unwrap();
        assert_eq!(Destination::of(&at("nothing")).unwrap(), Destination::Stream("/dev/null".into()));
        symlink("round", at("round")).unwrap();
        assert!(Destination::of(&at("round")).unwrap_err().to_string().contains("leads to itself"));
        assert!(Destination::of(folder.path()).unwrap_err().to_string().contains("is a folder"));
    }
}
