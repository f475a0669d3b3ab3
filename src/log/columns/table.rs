//! A table of signals in any of its formats.

use crate::log::columns::csv::CsvTable;
use crate::log::columns::head::Head;
use crate::log::columns::parquet_table::ParquetTable;
use crate::log::columns::row::EachRow;
use crate::log::file::input::LogInput;
use crate::log::file::record::MAGIC;
use crate::log::loss::Damage;
use crate::log::{Error, Result};
use std::path::Path;
use std::sync::Arc;

/// The format of a table.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum TableFormat {
    Csv,
    Parquet,
}

impl TableFormat {
    /// Names of CSV files end like this.
    const CSV: [&'static str; 4] = ["csv", "tsv", "tab", "txt"];
    /// Names of Parquet files end like this.
    const PARQUET: [&'static str; 2] = ["parquet", "pq"];

    /// The format of a file by its first bytes and, for CSV, the end of its name; `None` for a log that is no table.
    ///
    /// # Errors
    /// It is named as Parquet and does not begin so, or cannot be read.
    pub(crate) fn of(path: &Path, input: &LogInput) -> Result<Option<Self>> {
        let mut start = vec![0; input.length().min(16) as usize];
        input.read_at(0, &mut start).map_err(Error::Io)?;
        let is_other = |magic: &&[u8]| start.starts_with(magic);
        if start.is_empty() || start.starts_with(MAGIC) {
            return Ok(None);
        }
        if start.starts_with(b"PAR1") {
            return Ok(Some(Self::Parquet));
        }
        let packed: [&[u8]; 4] = [&[0x28, 0xb5, 0x2f, 0xfd], &[0x1f, 0x8b], b"SQLite format 3", b"#ROSBAG"];
        match Self::of_name(path) {
            Some(Self::Parquet) => Err(Error::BrokenParquet { reason: "its first bytes are not PAR1".to_owned() }),
            Some(Self::Csv) if !packed.iter().any(is_other) => Ok(Some(Self::Csv)),
            _ => Ok(None),
        }
    }

    /// The format that a file's name promises.
    pub(crate) fn of_name(path: &Path) -> Option<Self> {
        let end = path.extension()?.to_string_lossy().to_ascii_lowercase();
        match end.as_str() {
            end if Self::CSV.contains(&end) => Some(Self::Csv),
            end if Self::PARQUET.contains(&end) => Some(Self::Parquet),
            _ => None,
        }
    }
}

/// A table whose header has been read.
pub(crate) enum SignalTable {
    Csv(CsvTable),
    Parquet(ParquetTable),
}

/// What is known after the rows were read.
#[derive(Debug, Default)]
pub(crate) struct ReadRows {
    /// Checksum of the file, if all of it was read in order.
    pub crc: Option<u32>,
    pub damage: Vec<Damage>,
}

impl SignalTable {
    /// Reads the header.
    ///
    /// # Errors
    /// There is none, or it is damaged.
    pub(crate) fn open(format: TableFormat, input: &Arc<LogInput>) -> Result<Self> {
        let input = Arc::clone(input);
        Ok(match format {
            TableFormat::Csv => Self::Csv(CsvTable::open(input)?),
            TableFormat::Parquet => Self::Parquet(ParquetTable::open(input)?),
        })
    }

    /// Its columns.
    pub(crate) fn heads(&self) -> &[Head] {
        match self {
            Self::Csv(table) => &table.heads,
            Self::Parquet(table) => &table.heads,
        }
    }

    /// Reads the columns `wanted` of every row, in order, until `each` says `false`.
    ///
    /// # Errors
    /// The file cannot be read, or `each` fails.
    pub(crate) fn rows(&self, wanted: &[usize], progress: &(dyn Fn(u64) + Sync), each: &mut EachRow<'_>) -> Result<ReadRows> {
        Ok(match self {
            Self::Csv(table) => ReadRows { crc: table.rows(wanted, progress, each)?, damage: Vec::new() },
            Self::Parquet(table) => ReadRows { crc: None, damage: table.rows(wanted, progress, each)? },
        })
    }

    /// Number of rows, if the file says it.
    pub(crate) fn count(&self) -> Option<u64> {
        match self {
            Self::Csv(_) => None,
            Self::Parquet(table) => Some(table.count()),
        }
    }

    /// The format in a few words.
    pub(crate) fn text(&self) -> String {
        match self {
            Self::Csv(CsvTable { separator: '\t', .. }) => "CSV, separated by tabs".to_owned(),
            Self::Csv(table) => format!("CSV, separated by {:?}", table.separator),
            Self::Parquet(_) => "Parquet".to_owned(),
        }
    }

    /// What its rows are called: a line of text has a number that an editor shows.
    pub(crate) fn row_name(&self) -> &'static str {
        match self {
            Self::Csv(_) => "line",
            Self::Parquet(_) => "row",
        }
    }
}
