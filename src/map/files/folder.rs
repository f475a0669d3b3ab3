//! A folder of maps, read once: the tables, the CSV files that they name, and the mismatches.
//!
//! In: the folder. Out: [`MapFolder`] and a list of [`Mismatch`]es. The callers decide what a mismatch means: `verify` and `export` refuse
//! it, `report` notes it, `invert` uses only Table 1's files.

use crate::map::files::folder_writer::{FolderView, read_settled};
use crate::map::files::lateral_table_file::LateralTableFile;
use crate::map::files::save::sha256_hex;
use crate::map::files::table1_file::{CsvRef, Table1File};
use crate::map::files::table2_file::Table2File;
use crate::text::shown;
use std::io;
use std::path::PathBuf;

/// `table1.json`.
pub(crate) const TABLE1_NAME: &str = "table1.json";
/// `table2.json`.
pub(crate) const TABLE2_NAME: &str = "table2.json";
/// `lateral_table.json`.
const LATERAL_NAME: &str = "lateral_table.json";

/// A file of the folder, as it is on disk.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct StoredFile {
    /// Its name, without the folder.
    pub name: String,
    /// Its bytes.
    pub bytes: Vec<u8>,
    /// SHA-256 of the bytes.
    pub sha256: String,
}

/// A folder of maps.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct MapFolder {
    /// The folder.
    pub view: FolderView,
    /// Content of `table1.json`.
    pub table1: Table1File,
    /// `table1.json` itself.
    pub table1_json: StoredFile,
    /// Content of `table2.json`, with the file itself.
    pub table2: Option<(Table2File, StoredFile)>,
    /// The CSV files that the tables name and that could be read: those of Table 1, then those of Table 2.
    pub csvs: Vec<StoredFile>,
}

/// Two files of a folder that do not belong together, or a file that is named and cannot be read.
#[derive(Debug)]
pub(crate) enum Mismatch {
    /// The file is there, but its hash is not the one in the file that names it.
    Hash {
        /// Name of the file.
        file: String,
        /// Name of the file that gives the hash.
        by: &'static str,
        /// SHA-256 of the file.
        found: String,
        /// SHA-256 that the other file gives.
        expected: String,
    },
    /// The file is of another generation than the file that describes it.
    Generation {
        /// Name of the file.
        file: String,
        /// Name of the file that describes it.
        by: &'static str,
        /// Generation of the file.
        found: String,
        /// Generation of the other file.
        expected: String,
    },
    /// The file cannot be read, usually because it is missing.
    Unreadable {
        /// Name of the file.
        file: String,
        /// Name of the file that names it.
        by: &'static str,
        /// The reason.
        source: io::Error,
    },
}

impl Mismatch {
    /// Name of the file.
    pub(crate) fn file(&self) -> &str {
        match self {
            Self::Hash { file, .. } | Self::Generation { file, .. } | Self::Unreadable { file, .. } => file,
        }
    }

    /// Name of the file that describes it.
    pub(crate) fn by(&self) -> &'static str {
        match self {
            Self::Hash { by, .. } | Self::Generation { by, .. } | Self::Unreadable { by, .. } => by,
        }
    }
}

/// Why a folder is unreadable.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs)] // the fields are what the message says
pub enum FolderError {
    #[error("{}: {source}", shown(path))]
    Read { path: PathBuf, source: io::Error },
    #[error("{}: {source}", shown(path))]
    File { path: PathBuf, source: crate::map::Error },
}

impl StoredFile {
    /// Reads the file `name` of a folder.
    ///
    /// # Errors
    /// Any error of the file system.
    pub(crate) fn read(folder: &FolderView, name: &str) -> io::Result<Self> {
        let bytes = folder.read(name)?;
        Ok(Self { name: name.to_owned(), sha256: sha256_hex(&bytes), bytes })
    }

    /// The bytes as text.
    ///
    /// # Errors
    /// Bytes that are not UTF-8.
    pub(crate) fn text(&self) -> io::Result<&str> {
        std::str::from_utf8(&self.bytes).map_err(|_| io::Error::new(io::ErrorKind::InvalidData, "stream did not contain valid UTF-8"))
    }

    /// The mismatch if `by` gives the hash `expected` for it.
    fn mismatch(&self, by: &'static str, expected: &str) -> Option<Mismatch> {
        let wrong = || Mismatch::Hash { file: self.name.clone(), by, found: self.sha256.clone(), expected: expected.to_owned() };
        (self.sha256 != expected).then(wrong)
    }
}

impl MapFolder {
    /// Reads `table1.json`, `table2.json` and the CSV files that they name. A folder without `table2.json` is a mismatch, since Table 2
    /// has not been made yet.
    ///
    /// # Errors
    /// No `table1.json`; a JSON file that is there and cannot be read.
    pub(crate) fn read(view: &FolderView) -> Result<(Self, Vec<Mismatch>), FolderError> {
        read_settled(view, || Self::read_once(view), |read| read.as_ref().is_ok_and(|(_, mismatches)| mismatches.is_empty()))
    }

    fn read_once(view: &FolderView) -> Result<(Self, Vec<Mismatch>), FolderError> {
        let (mut folder, csv_mismatches) = Self::read_table1_once(view)?;
        let mut mismatches = Vec::new();
        match StoredFile::read(view, TABLE2_NAME) {
            Ok(json) => {
                let table2 = folder.parsed(&json, Table2File::from_json)?;
                let of_table1 = folder.table1_json.mismatch(TABLE2_NAME, &table2.table1.sha256);
                // the hash of a file that was edited and hashed again is right; its generation is not
                mismatches.extend(
                    of_table1.or_else(|| other_generation(TABLE1_NAME, &folder.table1.generation, TABLE2_NAME, &table2.generation)),
                );
                mismatches.extend(csv_mismatches);
                mismatches.extend(folder.take_csvs(TABLE2_NAME, table2.maps.iter().map(|m| &m.csv)));
                folder.table2 = Some((table2, json));
            }
            Err(source) if source.kind() == io::ErrorKind::NotFound => {
                mismatches.push(Mismatch::Unreadable { file: TABLE2_NAME.to_owned(), by: TABLE1_NAME, source });
                mismatches.extend(csv_mismatches);
            }
            Err(source) => return Err(folder.unread(TABLE2_NAME, source)),
        }
        Ok((folder, mismatches))
    }

    /// The same for `table1.json` and its CSV files alone: an old or damaged Table 2 does not matter for results from Table 1.
    ///
    /// # Errors
    /// No `table1.json`, or one that cannot be read.
    pub(crate) fn read_table1(view: &FolderView) -> Result<(Self, Vec<Mismatch>), FolderError> {
        read_settled(view, || Self::read_table1_once(view), |read| read.as_ref().is_ok_and(|(_, mismatches)| mismatches.is_empty()))
    }

    fn read_table1_once(view: &FolderView) -> Result<(Self, Vec<Mismatch>), FolderError> {
        let path = &view.path;
        let unread = |source| FolderError::Read { path: path.join(TABLE1_NAME), source };
        let json = StoredFile::read(view, TABLE1_NAME).map_err(unread)?;
        let text = json.text().map_err(unread)?;
        let table1 = Table1File::from_json(text).map_err(|source| FolderError::File { path: path.join(TABLE1_NAME), source })?;
        let mut folder = Self { view: view.clone(), table1, table1_json: json, table2: None, csvs: Vec::new() };
        let csvs: Vec<CsvRef> = folder.table1.maps.iter().map(|m| m.csv.clone()).collect();
        let mismatches = folder.take_csvs(TABLE1_NAME, &csvs);
        Ok((folder, mismatches))
    }

    /// The CSV file of that name, if it could be read.
    pub(crate) fn csv(&self, name: &str) -> Option<&StoredFile> {
        self.csvs.iter().find(|csv| csv.name == name)
    }

    /// Another file of the folder; `None` if it is missing.
    ///
    /// # Errors
    /// A file that is there and cannot be read.
    pub(crate) fn other(&self, name: &str) -> Result<Option<StoredFile>, FolderError> {
        match StoredFile::read(&self.view, name) {
            Ok(file) => Ok(Some(file)),
            Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
            Err(source) => Err(self.unread(name, source)),
        }
    }

    /// The lateral compensation table, if the folder has one, with the mismatch of its CSV.
    ///
    /// # Errors
    /// A file that is there and cannot be read.
    pub(crate) fn lateral(&self) -> Result<Option<(LateralTableFile, Option<Mismatch>)>, FolderError> {
        let Some(json) = self.other(LATERAL_NAME)? else { return Ok(None) };
        let file = self.parsed(&json, LateralTableFile::from_json)?;
        let mismatch = described(&self.view, &file.csv, LATERAL_NAME).1;
        Ok(Some((file, mismatch)))
    }

    /// A file's text read by `from_text`.
    fn parsed<T>(&self, file: &StoredFile, from_text: impl Fn(&str) -> crate::map::Result<T>) -> Result<T, FolderError> {
        let text = file.text().map_err(|source| self.unread(&file.name, source))?;
        from_text(text).map_err(|source| FolderError::File { path: self.view.path.join(&file.name), source })
    }

    fn unread(&self, name: &str, source: io::Error) -> FolderError {
        FolderError::Read { path: self.view.path.join(name), source }
    }

    fn take_csvs<'a>(&mut self, by: &'static str, csvs: impl IntoIterator<Item = &'a CsvRef>) -> Vec<Mismatch> {
        let mut mismatches = Vec::new();
        for csv in csvs {
            let (file, mismatch) = described(&self.view, csv, by);
            self.csvs.extend(file);
            mismatches.extend(mismatch);
        }
        mismatches
    }
}

/// The mismatch of two generations.
fn other_generation(file: &str, found: &str, by: &'static str, expected: &str) -> Option<Mismatch> {
    let wrong = || Mismatch::Generation { file: file.to_owned(), by, found: found.to_owned(), expected: expected.to_owned() };
    (found != expected).then(wrong)
}

/// The file that `csv` names, and its mismatch.
fn described(folder: &FolderView, csv: &CsvRef, by: &'static str) -> (Option<StoredFile>, Option<Mismatch>) {
    match StoredFile::read(folder, &csv.file) {
        Ok(file) => {
            let mismatch = file.mismatch(by, &csv.sha256);
            (Some(file), mismatch)
        }
        Err(source) => (None, Some(Mismatch::Unreadable { file: csv.file.clone(), by, source })),
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use std::path::Path;

    /// A copy of the maps of this repository.
    fn copied() -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        for entry in std::fs::read_dir("maps").unwrap() {
            let path = entry.unwrap().path();
            std::fs::copy(&path, folder.path().join(path.file_name().unwrap())).unwrap();
        }
        folder
    }

    fn summary(mismatches: &[Mismatch]) -> Vec<(&str, &str, bool)> {
        mismatches.iter().map(|m| (m.file(), m.by(), matches!(m, Mismatch::Hash { .. }))).collect()
    }

    #[test]
    fn a_folder_as_it_was_written_fits_together() {
        let (folder, mismatches) = MapFolder::read(&Path::new("maps").into()).unwrap();
        assert!(mismatches.is_empty(), "{mismatches:?}");
        let names: Vec<&str> = folder.csvs.iter().map(|csv| csv.name.as_str()).collect();
        assert_eq!(names, ["table1.csv", "table1.reverse.csv", "table2.csv", "table2.reverse.csv"]);
        let (_, mismatch) = folder.lateral().unwrap().unwrap();
        assert!(mismatch.is_none());
        assert!(folder.other("no_such_file.json").unwrap().is_none());
    }

    #[test]
    fn each_file_that_was_edited_or_removed_is_one_mismatch() {
        let copy = copied();
        let at = |name: &str| copy.path().join(name);
        std::fs::write(at("table1.csv"), "edited").unwrap();
        std::fs::remove_file(at("table2.reverse.csv")).unwrap();
        let json = std::fs::read_to_string(at("table1.json")).unwrap();
        std::fs::write(at("table1.json"), format!("{json}\n")).unwrap();
        let (_, mismatches) = MapFolder::read(&copy.path().into()).unwrap();
        let expected =
            [("table1.json", "table2.json", true), ("table1.csv", "table1.json", true), ("table2.reverse.csv", "table2.json", false)];
        assert_eq!(summary(&mismatches), expected);
    }

    #[test]
    fn a_table_1_of_another_generation_is_a_mismatch_even_if_its_hash_is_right() {
        let copy = copied();
        let at = |name: &str| copy.path().join(name);
        let other = Table1File { generation: "0".repeat(16), ..Table1File::from_json(include_str!("../../../maps/table1.json")).unwrap() };
        let text = other.to_json().unwrap();
        std::fs::write(at("table1.json"), &text).unwrap();
        let mut table2 = Table2File::from_json(include_str!("../../../maps/table2.json")).unwrap();
        table2.table1.sha256 = sha256_hex(text.as_bytes());
        std::fs::write(at("table2.json"), table2.to_json().unwrap()).unwrap();
        let (_, mismatches) = MapFolder::read(&copy.path().into()).unwrap();
        assert!(matches!(&mismatches[..], [Mismatch::Generation { found, .. }] if *found == "0".repeat(16)), "{mismatches:?}");
    }

    #[test]
    fn a_missing_or_broken_table_2_does_not_matter_to_table_1() {
        let copy = copied();
        std::fs::remove_file(copy.path().join("table2.json")).unwrap();
        let (folder, mismatches) = MapFolder::read(&copy.path().into()).unwrap();
        assert!(folder.table2.is_none());
        assert_eq!(summary(&mismatches), [("table2.json", "table1.json", false)]);
        std::fs::write(copy.path().join("table2.json"), "{").unwrap();
        assert!(matches!(MapFolder::read(&copy.path().into()), Err(FolderError::File { path, .. }) if path.ends_with("table2.json")));
        assert!(MapFolder::read_table1(&copy.path().into()).unwrap().1.is_empty());
    }
}
