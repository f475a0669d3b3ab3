//! CSV of any program: separators comma, semicolon or tab; quotes; a byte-order mark; comments before the header; UTF-8 or Latin-1.
//!
//! One line at a time is in memory.

use crate::log::columns::cell::{TableCell, number};
use crate::log::columns::head::Head;
use crate::log::columns::lines::{Lines, TextLine};
use crate::log::columns::row::{EachRow, Row};
use crate::log::file::input::LogInput;
use crate::log::{Error, Result};
use crate::units::Unit;
use std::borrow::Cow;
use std::sync::Arc;

/// More columns than any vehicle has signals.
const MOST_COLUMNS: usize = 20_000;

/// A CSV file whose header has been read.
#[derive(Debug)]
pub(crate) struct CsvTable {
    input: Arc<LogInput>,
    pub separator: char,
    pub heads: Vec<Head>,
    /// Number of lines before the first row.
    skipped: u64,
}

impl CsvTable {
    /// Reads the header.
    ///
    /// # Errors
    /// The file holds no header, or is no text in one byte per character.
    pub(crate) fn open(input: Arc<LogInput>) -> Result<Self> {
        let mut lines = Lines::new(&input);
        let mut named = None;
        let (skipped, header) = loop {
            let Some(line) = lines.next()? else {
                return Err(Error::NoHeader { line: lines.number(), found: "the end of the file".into() });
            };
            if line.number == 1 && (line.bytes.starts_with(&[0xff, 0xfe]) || line.bytes.starts_with(&[0xfe, 0xff])) {
                return Err(Error::Utf16);
            }
            let text = text(&line);
            if let Some(separator) = text.strip_prefix("sep=").and_then(|rest| rest.chars().next()) {
                named = Some(separator); // a spreadsheet's own way to say it
            } else if !text.trim().is_empty() && !text.starts_with('#') {
                break (line.number, text.into_owned());
            }
        };
        let separator = named.filter(char::is_ascii).unwrap_or_else(|| separator_of(&header));
        let names: Vec<String> = cells(&header, separator).into_iter().map(Cow::into_owned).collect();
        if names.iter().all(|name| name.trim().is_empty() || number(name).is_some()) {
            let found = crate::text::name_from_outside(header.trim()).into_owned();
            return Err(Error::NoHeader { line: skipped, found });
        }
        if names.len() > MOST_COLUMNS {
            return Err(Error::TooManyColumns { found: names.len(), allowed: MOST_COLUMNS });
        }
        let second = lines.next()?.map(|line| text(&line).into_owned()).unwrap_or_default();
        let second = cells(&second, separator);
        let units = if is_units(&second, names.len()) { Some(second) } else { None };
        let head = |(k, name): (usize, &String)| Head::new(name, units.as_ref().map(|units| units[k].trim().trim_matches(['[', ']'])));
        let heads = names.iter().enumerate().map(head).collect();
        let skipped = skipped + u64::from(units.is_some());
        Ok(Self { input, separator, heads, skipped })
    }

    /// Reads the columns `wanted` of every row, in order; returns the checksum of the whole file if it was read to its end.
    ///
    /// # Errors
    /// The file cannot be read, a line is too long, or `each` fails.
    pub(crate) fn rows(&self, wanted: &[usize], progress: &(dyn Fn(u64) + Sync), each: &mut EachRow<'_>) -> Result<Option<u32>> {
        let mut lines = Lines::new(&self.input);
        let mut reported = 0;
        while let Some(line) = lines.next()? {
            let (number, offset, bytes) = (line.number, line.offset, line.bytes.len() as u64);
            let goes_on = number <= self.skipped || {
                let text = text(&line);
                text.trim().is_empty() || each(&self.row(&cells(&text, self.separator), wanted, (number, offset, bytes)).borrowed())?
            };
            if !goes_on {
                return Ok(None);
            }
            if lines.position() >= reported + (1 << 20) {
                progress(lines.position() - reported);
                reported = lines.position();
            }
        }
        progress(lines.position() - reported);
        Ok(Some(lines.crc()))
    }

    fn row<'c>(&self, found: &'c [Cow<'c, str>], wanted: &[usize], (number, offset, bytes): (u64, u64, u64)) -> OwnedRow<'c> {
        let all = self.heads.len();
        // a separator at the end of each row is common
        let is_whole = found.len() >= all && found[all..].iter().all(|cell| cell.trim().is_empty());
        let cell = |column: &usize| match found[*column].trim() {
            "" => TableCell::Empty,
            text => TableCell::Text(Cow::Borrowed(text)),
        };
        let cells = if is_whole { Ok(wanted.iter().map(cell).collect()) } else { Err(found.len()) };
        OwnedRow { number, offset, bytes, cells }
    }
}

/// A row that owns the list of its cells.
struct OwnedRow<'c> {
    number: u64,
    offset: u64,
    bytes: u64,
    cells: std::result::Result<Vec<TableCell<'c>>, usize>,
}

impl OwnedRow<'_> {
    fn borrowed(&self) -> Row<'_> {
        Row { number: self.number, offset: self.offset, bytes: self.bytes, cells: self.cells.as_deref().map_err(|found| *found) }
    }
}

/// A line as text. Bytes that are no UTF-8 are Latin-1, in which spreadsheets write `°` and `µ`.
fn text<'l>(line: &TextLine<'l>) -> Cow<'l, str> {
    let bytes = line.bytes.strip_prefix(&[0xef, 0xbb, 0xbf]).filter(|_| line.number == 1).unwrap_or(line.bytes);
    std::str::from_utf8(bytes).map_or_else(|_| Cow::Owned(bytes.iter().map(|byte| char::from(*byte)).collect()), Cow::Borrowed)
}

/// The separator of a header: a tab or a semicolon where there is one outside quotes, otherwise the comma.
fn separator_of(header: &str) -> char {
    let outside: String = header.split('"').step_by(2).collect();
    ['\t', ';'].into_iter().find(|separator| outside.contains(*separator)).unwrap_or(',')
}

/// The cells of a line. A quote inside a quoted cell is doubled.
fn cells(line: &str, separator: char) -> Vec<Cow<'_, str>> {
    let mut found = Vec::new();
    let mut rest = line;
    loop {
        let start = rest.trim_start_matches(' ');
        let quoted = start.strip_prefix('"').and_then(|inside| Some((inside, closing_quote(inside)?)));
        let (cell, after) = if let Some((inside, end)) = quoted {
            let cell = &inside[..end];
            let cell = if cell.contains('"') { Cow::Owned(cell.replace("\"\"", "\"")) } else { Cow::Borrowed(cell) };
            (cell, inside[end + 1..].find(separator).map(|at| &inside[end + 1 + at..]))
        } else {
            let end = rest.find(separator);
            (Cow::Borrowed(&rest[..end.unwrap_or(rest.len())]), end.map(|at| &rest[at..]))
        };
        found.push(cell);
        match after {
            Some(next) => rest = &next[separator.len_utf8()..],
            None => return found,
        }
    }
}

fn closing_quote(inside: &str) -> Option<usize> {
    let mut at = 0;
    loop {
        at += inside[at..].find('"')?;
        if !inside[at + 1..].starts_with('"') {
            return Some(at);
        }
        at += 2;
    }
}

/// Whether the second line holds units: no number, nothing long, and at least one unit that is known.
fn is_units(second: &[Cow<'_, str>], columns: usize) -> bool {
    let bare = |cell: &Cow<'_, str>| cell.trim().trim_matches(['[', ']']).to_owned();
    let is_unit = |text: &String| !text.is_empty() && text != "number" && text.parse::<Unit>().is_ok();
    let texts: Vec<String> = second.iter().map(bare).collect();
    texts.len() == columns && texts.iter().all(|text| number(text).is_none() && text.len() <= 12) && texts.iter().any(is_unit)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    /// Names with units, separator, and the rows as text.
    fn read(bytes: &[u8]) -> (Vec<String>, char, Vec<String>) {
        let table = CsvTable::open(Arc::new(LogInput::Memory(bytes.to_vec()))).unwrap();
        let wanted: Vec<usize> = (0..table.heads.len()).collect();
        let mut rows = Vec::new();
        let crc = table.rows(&wanted, &|_| {}, &mut |row| {
            rows.push(match row.cells {
                Ok(cells) => format!("{}: {}", row.number, cells.iter().map(TableCell::shown).collect::<Vec<_>>().join("|")),
                Err(found) => format!("{}: {found} cells", row.number),
            });
            Ok(true)
        });
        assert_eq!(crc.unwrap(), Some(crc32fast::hash(bytes)));
        let heads = table.heads.iter().map(|head| format!("{} {:?}", head.bare, head.unit)).collect();
        (heads, table.separator, rows)
    }

    #[test]
    fn separators_quotes_byte_order_marks_and_line_ends_are_found_out() {
        for (text, separator) in [("\u{feff}t;a\r\n1;\"2;5\"\r\n\r\n3;;\r\n4", ';'), ("# by hand\nt\ta\n1\t2;5\n3\t\t\n4", '\t')] {
            let (_, found, rows) = read(text.as_bytes());
            let first = rows[0].split_once(": ").unwrap().1;
            assert_eq!((found, first, rows.len()), (separator, "1|2;5", 3), "{rows:?}");
            assert!(rows[1].ends_with("3|") && rows[2] == "5: 1 cells", "{rows:?}");
        }
        assert_eq!(read(b"sep=;\nt;a,b\n1;2\n").2, ["3: 1|2"]);
        assert_eq!(read(b"t,\"a \"\"b\"\"\"\n1,2\n").0[1], "a \"b\" None");
    }

    #[test]
    fn a_second_line_of_units_belongs_to_the_header_and_one_of_words_does_not() {
        let (heads, _, rows) = read("time,speed,gear\ns,km/h,\n0,1,2\n".as_bytes());
        assert!(heads[1].contains("km/h") && rows == ["3: 0|1|2"], "{heads:?}");
        assert_eq!(read(b"time,gear\n,D\n0,R\n").2.len(), 2);
    }

    #[test]
    fn latin_1_is_read_and_utf_16_is_refused() {
        assert!(read(b"t,angle [\xb0]\n0,1\n").0[1].contains("deg"));
        let utf16 = CsvTable::open(Arc::new(LogInput::Memory(vec![0xff, 0xfe, b't', 0, b'\n', 0])));
        assert!(matches!(utf16, Err(Error::Utf16)));
    }

    #[test]
    fn a_line_of_separators_is_no_header_of_a_million_columns() {
        let table = CsvTable::open(Arc::new(LogInput::Memory(format!("time{}\n", ",x".repeat(MOST_COLUMNS)).into_bytes())));
        assert!(matches!(table, Err(Error::TooManyColumns { found: 20_001, .. })));
    }

    #[test]
    fn a_file_that_begins_with_numbers_or_ends_at_once_has_no_header() {
        for text in ["1,2,3\n4,5,6\n", "# only a comment\n", "\n\n"] {
            let table = CsvTable::open(Arc::new(LogInput::Memory(text.as_bytes().to_vec())));
            assert!(matches!(table, Err(Error::NoHeader { .. })), "{text:?}");
        }
    }
}
