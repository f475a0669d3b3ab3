//! Parquet files: the columns with one value per row, read in small batches.
//!
//! In memory are one page of each wanted column and its dictionary. A damaged row group is a counted loss, a damaged footer an error.

use crate::log::columns::cell::TableCell;
use crate::log::columns::foreign_panics::caught;
use crate::log::columns::head::Head;
use crate::log::columns::row::{EachRow, Row};
use crate::log::file::input::LogInput;
use crate::log::loss::{Damage, Why};
use crate::log::{Error, Result};
use bytes::Bytes;
use parquet::basic::{LogicalType, TimeUnit};
use parquet::column::reader::{ColumnReader, ColumnReaderImpl};
use parquet::data_type::DataType;
use parquet::errors::{ParquetError, Result as ParquetResult};
use parquet::file::reader::{ChunkReader, FileReader, Length, RowGroupReader};
use parquet::file::serialized_reader::SerializedFileReader;
use parquet::schema::types::ColumnDescPtr;
use std::borrow::Cow;
use std::io::{BufReader, Read};
use std::sync::Arc;

/// Rows that are read at once.
const BATCH: usize = 4096;

/// A Parquet file whose footer has been read.
pub(crate) struct ParquetTable {
    reader: SerializedFileReader<PositionedInput>,
    pub heads: Vec<Head>,
    /// The column of the file behind each head.
    columns: Vec<usize>,
}

impl ParquetTable {
    /// Reads the footer.
    ///
    /// # Errors
    /// It is damaged or missing, or no column has one value per row.
    pub(crate) fn open(input: Arc<LogInput>) -> Result<Self> {
        let broken = |reason: String| Error::BrokenParquet { reason };
        let reader = caught(|| SerializedFileReader::new(PositionedInput(input))).map_err(broken)?.map_err(|e| broken(e.to_string()))?;
        let schema = reader.metadata().file_metadata().schema_descr();
        // lists of values are no signals
        let columns: Vec<usize> = (0..schema.num_columns()).filter(|k| schema.column(*k).max_rep_level() == 0).collect();
        if columns.is_empty() {
            return Err(broken("it has no column with one value per row".to_owned()));
        }
        let heads = columns.iter().map(|k| Head::new(&schema.column(*k).path().parts().join("."), None)).collect();
        Ok(Self { reader, heads, columns })
    }

    /// Number of rows, as the footer has it.
    pub(crate) fn count(&self) -> u64 {
        u64::try_from(self.reader.metadata().file_metadata().num_rows()).unwrap_or(0)
    }

    /// Reads the columns `wanted` of every row, in order; returns the places that could not be read.
    ///
    /// # Errors
    /// `each` fails.
    pub(crate) fn rows(&self, wanted: &[usize], progress: &(dyn Fn(u64) + Sync), each: &mut EachRow<'_>) -> Result<Vec<Damage>> {
        let mut damage = Vec::new();
        let mut before = 0;
        for group in 0..self.reader.num_row_groups() {
            let about = self.reader.metadata().row_group(group);
            let rows = u64::try_from(about.num_rows()).unwrap_or(0);
            let bytes = u64::try_from(about.compressed_size()).unwrap_or(0);
            let mut read = 0;
            // a panic in `each` would be ours, so only the parser's part is caught
            let mut group_reader = match caught(|| GroupReader::open(&self.reader, group, wanted.iter().map(|k| self.columns[*k]))) {
                Ok(Ok(reader)) => Ok(reader),
                Ok(Err(error)) => Err(error.to_string()),
                Err(panic) => Err(panic),
            };
            while read < rows {
                let batch = (rows - read).min(BATCH as u64) as usize;
                let cells = match &mut group_reader {
                    Ok(reader) => caught(|| reader.read(batch)).unwrap_or_else(|panic| Err(ParquetError::General(panic))),
                    Err(reason) => Err(ParquetError::General(std::mem::take(reason))),
                };
                let columns = match cells {
                    Ok(columns) => columns,
                    Err(error) => {
                        let why = Why::RowGroup { group: group as u32, rows: rows - read, reason: error.to_string().into() };
                        let offset = about.file_offset().and_then(|at| u64::try_from(at).ok()).unwrap_or(0);
                        damage.push(Damage { messages: Some(rows - read), ..Damage::new(offset, bytes, why) });
                        break;
                    }
                };
                let mut columns: Vec<_> = columns.into_iter().map(Vec::into_iter).collect();
                for k in 0..batch as u64 {
                    let cells: Vec<TableCell<'_>> = columns.iter_mut().map(|column| column.next().unwrap_or(TableCell::Empty)).collect();
                    if !each(&Row { number: before + read + k + 1, offset: 0, bytes: 0, cells: Ok(&cells) })? {
                        return Ok(damage);
                    }
                }
                read += batch as u64;
            }
            before += rows;
            progress(bytes);
        }
        Ok(damage)
    }
}

/// The wanted columns of one row group.
struct GroupReader {
    columns: Vec<(ColumnReader, ColumnType)>,
}

impl GroupReader {
    fn open(file: &SerializedFileReader<PositionedInput>, group: usize, columns: impl Iterator<Item = usize>) -> ParquetResult<Self> {
        let reader: Box<dyn RowGroupReader + '_> = file.get_row_group(group)?;
        let schema = file.metadata().file_metadata().schema_descr();
        let open = |k: usize| Ok((reader.get_column_reader(k)?, ColumnType::of(&schema.column(k))));
        Ok(Self { columns: columns.map(open).collect::<ParquetResult<_>>()? })
    }

    /// The next `count` cells of each column.
    fn read(&mut self, count: usize) -> ParquetResult<Vec<Vec<TableCell<'static>>>> {
        self.columns.iter_mut().map(|(reader, meaning)| next(reader, *meaning, count)).collect()
    }
}

/// What the numbers of a column mean.
#[derive(Debug, Clone, Copy, PartialEq)]
struct ColumnType {
    /// Definition level of a value; below it is a hole.
    defined: i16,
    /// Nanoseconds in one unit of a time.
    ns_per_unit: Option<i64>,
    /// What multiplies the whole numbers of a decimal.
    scale: f64,
    is_unsigned: bool,
}

impl ColumnType {
    fn of(column: &ColumnDescPtr) -> Self {
        let mut meaning = Self { defined: column.max_def_level(), ns_per_unit: None, scale: 1.0, is_unsigned: false };
        match column.logical_type_ref() {
            Some(LogicalType::Timestamp(time) | LogicalType::Time(time)) => {
                meaning.ns_per_unit = Some(match time.unit {
                    TimeUnit::MILLIS => 1_000_000,
                    TimeUnit::MICROS => 1_000,
                    TimeUnit::NANOS => 1,
                });
            }
            Some(LogicalType::Date) => meaning.ns_per_unit = Some(86_400_000_000_000),
            Some(LogicalType::Decimal(decimal)) => meaning.scale = 10_f64.powi(-decimal.scale),
            Some(LogicalType::Integer(integer)) => meaning.is_unsigned = !integer.is_signed,
            _ => {}
        }
        meaning
    }

    /// `unsigned` are the same bits without a sign.
    fn integer(self, value: i64, unsigned: u64) -> TableCell<'static> {
        match self.ns_per_unit {
            Some(scale) => value.checked_mul(scale).map_or(TableCell::Empty, TableCell::Instant),
            None if self.scale != 1.0 => TableCell::Number(value as f64 * self.scale),
            None if self.is_unsigned => i64::try_from(unsigned).map_or(TableCell::Number(unsigned as f64), TableCell::Integer),
            None => TableCell::Integer(value),
        }
    }
}

fn next(reader: &mut ColumnReader, meaning: ColumnType, count: usize) -> ParquetResult<Vec<TableCell<'static>>> {
    let text = |bytes: &[u8]| TableCell::Text(Cow::Owned(String::from_utf8_lossy(bytes).into_owned()));
    match reader {
        ColumnReader::BoolColumnReader(reader) => cells(reader, meaning, count, |value| TableCell::Integer(i64::from(*value))),
        ColumnReader::Int32ColumnReader(reader) => {
            cells(reader, meaning, count, |value| meaning.integer(i64::from(*value), u64::from(value.cast_unsigned())))
        }
        ColumnReader::Int64ColumnReader(reader) => cells(reader, meaning, count, |value| meaning.integer(*value, value.cast_unsigned())),
        ColumnReader::Int96ColumnReader(reader) => cells(reader, meaning, count, |value| TableCell::Instant(value.to_nanos())),
        ColumnReader::FloatColumnReader(reader) => cells(reader, meaning, count, |value| TableCell::Number(f64::from(*value))),
        ColumnReader::DoubleColumnReader(reader) => cells(reader, meaning, count, |value| TableCell::Number(*value)),
        ColumnReader::ByteArrayColumnReader(reader) => cells(reader, meaning, count, |value| text(value.data())),
        ColumnReader::FixedLenByteArrayColumnReader(reader) => cells(reader, meaning, count, |value| text(value.data())),
    }
}

fn cells<T: DataType>(
    reader: &mut ColumnReaderImpl<T>,
    meaning: ColumnType,
    count: usize,
    cell: impl Fn(&T::T) -> TableCell<'static>,
) -> ParquetResult<Vec<TableCell<'static>>> {
    let (mut values, mut levels) = (Vec::new(), Vec::new());
    let (records, _, _) = reader.read_records(count, (meaning.defined > 0).then_some(&mut levels), None, &mut values)?;
    if records != count {
        return Err(ParquetError::EOF(format!("a column ends {} row(s) before the others", count - records)));
    }
    let mut values = values.iter();
    if meaning.defined == 0 {
        return Ok(values.map(cell).collect());
    }
    Ok(levels
        .iter()
        .map(|level| if *level == meaning.defined { values.next().map_or(TableCell::Empty, &cell) } else { TableCell::Empty })
        .collect())
}

/// A log's bytes by position, for the parser.
struct PositionedInput(Arc<LogInput>);

impl Length for PositionedInput {
    fn len(&self) -> u64 {
        self.0.length()
    }
}

impl ChunkReader for PositionedInput {
    type T = BufReader<PositionedReader>;

    fn get_read(&self, start: u64) -> ParquetResult<Self::T> {
        Ok(BufReader::with_capacity(512, PositionedReader { input: Arc::clone(&self.0), at: start }))
    }

    fn get_bytes(&self, start: u64, length: usize) -> ParquetResult<Bytes> {
        if start.checked_add(length as u64).is_none_or(|end| end > self.0.length()) {
            return Err(ParquetError::EOF(format!("{length} bytes are expected at byte {start}, beyond the end of the file")));
        }
        let mut bytes = Vec::new();
        self.0.read_into(start, length, &mut bytes)?;
        Ok(bytes.into())
    }
}

struct PositionedReader {
    input: Arc<LogInput>,
    at: u64,
}

impl Read for PositionedReader {
    fn read(&mut self, into: &mut [u8]) -> std::io::Result<usize> {
        let count = self.input.length().saturating_sub(self.at).min(into.len() as u64) as usize;
        self.input.read_at(self.at, &mut into[..count])?;
        self.at += count as u64;
        Ok(count)
    }
}
