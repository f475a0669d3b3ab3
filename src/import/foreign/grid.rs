//! A matrix with breaks, some of whose cells may be unreadable.

use crate::import::foreign::CsvLine;

/// A part that could not be read, and its place.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Misread {
    /// What is wrong.
    pub kind: MisreadKind,
    /// Line of the text, counted from 1.
    pub line: u64,
    /// Cell of the line, counted from 1; 0 for the whole line.
    pub column: usize,
    /// The text there, and what it should be.
    pub what: String,
}

/// Kind of an unreadable part.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum MisreadKind {
    /// Nothing, or less than a table.
    TooSmall,
    /// A line with more or fewer cells than the first.
    Ragged,
    /// A cell that is not a finite number.
    NotANumber,
    /// A message or line of another shape.
    Malformed,
}

/// A matrix with breaks. `None` is a cell that could not be read.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct CellGrid {
    /// The first cell of the first line.
    pub corner: String,
    /// Breaks of the rows.
    pub row_breaks: Vec<Option<f64>>,
    /// Breaks of the columns.
    pub column_breaks: Vec<Option<f64>>,
    /// The values, one vector per row, each as long as `column_breaks`.
    pub values: Vec<Vec<Option<f64>>>,
    /// The line of every row; empty when the grid is not from a text of lines.
    pub lines: Vec<u64>,
}

impl CellGrid {
    /// From the cells of a text: first line the column breaks, first cell of every other line its row break.
    pub(crate) fn of_cells(cells: &[CsvLine]) -> (Self, Vec<Misread>) {
        let mut misread = Vec::new();
        let Some((header, rows)) = cells.split_first() else {
            let what = "the file is empty; a map has a line of column breaks and a line per row break".to_owned();
            misread.push(Misread { kind: MisreadKind::TooSmall, line: 1, column: 0, what });
            return (Self::default(), misread);
        };
        if header.texts.len() < 2 {
            let what = format!("{} cell(s) in a line; a map has at least two: a row break and a value", header.texts.len());
            misread.push(Misread { kind: MisreadKind::TooSmall, line: header.line, column: 0, what });
        }
        let mut grid = Self { corner: header.texts.first().cloned().unwrap_or_default(), ..Self::default() };
        let mut number = |line: u64, k: usize, text: &str| match text.parse::<f64>() {
            Ok(value) if value.is_finite() => Some(value),
            _ => {
                let what = format!("{text:?} is not a finite number");
                misread.push(Misread { kind: MisreadKind::NotANumber, line, column: k + 1, what });
                None
            }
        };
        grid.column_breaks = (1..header.texts.len()).map(|k| number(header.line, k, &header.texts[k])).collect();
        let mut ragged = Vec::new();
        for row in rows {
            if row.texts.len() != header.texts.len() {
                let what = format!("{} cells; the first line has {}", row.texts.len(), header.texts.len());
                ragged.push(Misread { kind: MisreadKind::Ragged, line: row.line, column: 0, what });
            }
            grid.row_breaks.push(row.texts.first().and_then(|text| number(row.line, 0, text)));
            let values = (1..header.texts.len()).map(|k| row.texts.get(k).and_then(|text| number(row.line, k, text))).collect();
            grid.values.push(values);
            grid.lines.push(row.line);
        }
        misread.extend(ragged);
        if header.texts.len() >= 2 && grid.values.len() < 2 {
            let what = format!("{} row(s) of values; interpolation needs at least two", grid.values.len());
            misread.push(Misread { kind: MisreadKind::TooSmall, line: header.line, column: 0, what });
        }
        misread.sort_by_key(|m| (m.line, m.column));
        (grid, misread)
    }

    /// Number of rows and columns.
    pub(crate) fn shape(&self) -> (usize, usize) {
        (self.values.len(), self.column_breaks.len())
    }

    /// Value of row `i` and column `j`, `None` when it could not be read.
    pub(crate) fn at(&self, i: usize, j: usize) -> Option<f64> {
        self.values.get(i)?.get(j).copied().flatten()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::import::foreign::cells_of_csv;

    #[test]
    fn every_unreadable_cell_is_reported_and_the_others_are_kept() {
        let (grid, misread) = CellGrid::of_cells(&cells_of_csv("v,0,5\n0,1,x\n1,2\n2,nan,4\n"));
        let found: Vec<_> = misread.iter().map(|m| (m.kind, m.line, m.column)).collect();
        let expected = [(MisreadKind::NotANumber, 2, 3), (MisreadKind::Ragged, 3, 0), (MisreadKind::NotANumber, 4, 2)];
        assert_eq!(found, expected);
        assert_eq!(grid.values, [vec![Some(1.0), None], vec![Some(2.0), None], vec![None, Some(4.0)]]);
    }
}
