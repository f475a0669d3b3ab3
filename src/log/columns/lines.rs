//! The lines of a text file, one at a time, with their positions and a checksum of all bytes.

use crate::log::file::input::LogInput;
use crate::log::{Error, Result};

/// Longest line [bytes]: tens of thousands of columns.
const LONGEST_LINE: usize = 4 << 20;
/// What is read at once [bytes].
const STEP: usize = 1 << 20;

/// A line without its end.
#[derive(Debug)]
pub(crate) struct TextLine<'l> {
    pub bytes: &'l [u8],
    /// From 1.
    pub number: u64,
    pub offset: u64,
}

/// Reads a file line by line.
pub(crate) struct Lines<'i> {
    input: &'i LogInput,
    buffer: Vec<u8>,
    /// Place of the next line in the buffer.
    next: usize,
    /// Position of the buffer's end in the file.
    read: u64,
    number: u64,
    crc: crc32fast::Hasher,
}

impl<'i> Lines<'i> {
    pub(crate) fn new(input: &'i LogInput) -> Self {
        Self { input, buffer: Vec::new(), next: 0, read: 0, number: 0, crc: crc32fast::Hasher::new() }
    }

    /// Number of the last line.
    pub(crate) fn number(&self) -> u64 {
        self.number
    }

    /// Position of the next line in the file.
    pub(crate) fn position(&self) -> u64 {
        self.read - (self.buffer.len() - self.next) as u64
    }

    /// Checksum of the bytes that were read.
    pub(crate) fn crc(self) -> u32 {
        self.crc.finalize()
    }

    /// The next line; `None` at the end.
    ///
    /// # Errors
    /// The file cannot be read, or the line is too long.
    pub(crate) fn next(&mut self) -> Result<Option<TextLine<'_>>> {
        let mut searched = self.next;
        loop {
            if let Some(at) = self.buffer[searched..].iter().position(|byte| *byte == b'\n') {
                return Ok(Some(self.take(searched + at, 1)));
            }
            searched = self.buffer.len();
            let left = self.input.length().saturating_sub(self.read).min(STEP as u64) as usize;
            if left == 0 {
                let end = self.buffer.len();
                return Ok((self.next < end).then(|| self.take(end, 0)));
            }
            if searched - self.next > LONGEST_LINE {
                return Err(Error::LongLine { line: self.number + 1, allowed: LONGEST_LINE });
            }
            self.buffer.drain(..self.next);
            searched -= self.next;
            self.next = 0;
            self.buffer.resize(searched + left, 0);
            self.input.read_at(self.read, &mut self.buffer[searched..]).map_err(Error::Io)?;
            self.crc.update(&self.buffer[searched..]);
            self.read += left as u64;
        }
    }

    /// The line that ends at `end`, before a line end of so many bytes.
    fn take(&mut self, end: usize, line_end: usize) -> TextLine<'_> {
        let (offset, start) = (self.position(), self.next);
        self.next = end + line_end;
        self.number += 1;
        let bytes = &self.buffer[start..end];
        TextLine { bytes: bytes.strip_suffix(b"\r").unwrap_or(bytes), number: self.number, offset }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn lines_across_the_borders_of_what_is_read_are_whole() {
        let long = "x".repeat(STEP - 3);
        let text = format!("{long}\r\nab\n\nlast");
        let input = LogInput::Memory(text.clone().into_bytes());
        let mut lines = Lines::new(&input);
        let mut found = Vec::new();
        while let Some(line) = lines.next().unwrap() {
            found.push((line.number, line.offset, line.bytes.len()));
        }
        let at = STEP as u64;
        assert_eq!(found, [(1, 0, STEP - 3), (2, at - 1, 2), (3, at + 2, 0), (4, at + 3, 4)]);
        assert_eq!(lines.crc(), crc32fast::hash(text.as_bytes()));
    }

    #[test]
    fn a_file_without_line_ends_is_refused_before_it_fills_the_memory() {
        let input = LogInput::Memory(vec![b'x'; LONGEST_LINE + 3 * STEP]);
        assert!(matches!(Lines::new(&input).next(), Err(Error::LongLine { line: 1, .. })));
    }
}
