//! The plain matrix that `table1.csv` and `table2.csv` are: corner cell `rows\columns` with units in the names, first row the column
//! breaks, first column the row breaks, shortest decimals that read back to the same number, `\n` line ends, no comments.

use crate::map::{Error, Result};

/// A matrix with named axes, as read from or written to CSV. Not yet checked as a table.
#[derive(Debug, Clone, PartialEq)]
pub struct Matrix {
    /// Name of the row axis, with its unit (`torque_nm`).
    pub rows_name: String,
    /// Name of the column axis, with its unit (`speed_mps`).
    pub columns_name: String,
    /// Breaks of the rows.
    pub row_breaks: Vec<f64>,
    /// Breaks of the columns.
    pub column_breaks: Vec<f64>,
    /// Values, row-major.
    pub values: Vec<f64>,
}

impl Matrix {
    /// The CSV text.
    pub fn to_csv(&self) -> String {
        let mut text = format!("{}\\{}", self.rows_name, self.columns_name);
        let push = |text: &mut String, value: f64| {
            text.push(',');
            text.push_str(&decimal(value));
        };
        for &b in &self.column_breaks {
            push(&mut text, b);
        }
        text.push('\n');
        for (row, values) in self.row_breaks.iter().zip(self.values.chunks(self.column_breaks.len().max(1))) {
            text.push_str(&decimal(*row));
            for &v in values {
                push(&mut text, v);
            }
            text.push('\n');
        }
        text
    }

    /// Reads the CSV text: any line ends, a UTF-8 byte order mark and blanks around numbers are forgiven.
    ///
    /// # Errors
    /// An empty text, rows of different lengths, cells that are not numbers: each with its line and column.
    pub fn from_csv(text: &str) -> Result<Self> {
        let text = text.trim_start_matches('\u{feff}');
        let mut reader = csv::ReaderBuilder::new().has_headers(false).flexible(true).trim(csv::Trim::All).from_reader(text.as_bytes());
        let mut records = reader.records();
        let header = records.next().ok_or(Error::EmptyCsv)??;
        let corner = header.get(0).unwrap_or_default();
        let (rows_name, columns_name) = corner.split_once('\\').unwrap_or((corner, ""));
        let number = |record: &csv::StringRecord, k: usize| {
            let cell = record.get(k).unwrap_or_default();
            cell.parse::<f64>().map_err(|_| Error::NotANumber {
                line: record.position().map_or(0, csv::Position::line),
                column: k + 1,
                text: cell.to_owned(),
            })
        };
        let column_breaks = (1..header.len()).map(|k| number(&header, k)).collect::<Result<Vec<_>>>()?;
        let mut matrix = Self {
            rows_name: rows_name.to_owned(),
            columns_name: columns_name.to_owned(),
            row_breaks: Vec::new(),
            column_breaks,
            values: Vec::new(),
        };
        for record in records {
            let record = record?;
            if record.len() != header.len() {
                let line = record.position().map_or(0, csv::Position::line);
                return Err(Error::RaggedCsv { line, found: record.len(), expected: header.len() });
            }
            matrix.row_breaks.push(number(&record, 0)?);
            for k in 1..record.len() {
                matrix.values.push(number(&record, k)?);
            }
        }
        Ok(matrix)
    }

    /// Checks the corner cell.
    ///
    /// # Errors
    /// Axis names other than these.
    pub fn expect_axes(&self, rows: &str, columns: &str) -> Result<()> {
        if self.rows_name == rows && self.columns_name == columns {
            return Ok(());
        }
        let found = format!("{}\\{}", self.rows_name, self.columns_name);
        Err(Error::WrongAxes { found, expected: format!("{rows}\\{columns}") })
    }
}

/// Shortest decimal that reads back to the same number; negative zero is written as 0.
pub(crate) fn decimal(value: f64) -> String {
    format!("{}", if value == 0.0 { 0.0 } else { value })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use proptest::prelude::*;

    fn example() -> Matrix {
        Matrix {
            rows_name: "torque_nm".into(),
            columns_name: "speed_mps".into(),
            row_breaks: vec![-4.0, 0.0],
            column_breaks: vec![0.0, 0.05],
            values: vec![-0.5, -0.625, 0.0, -0.1],
        }
    }

    #[test]
    fn the_text_is_what_a_spreadsheet_reads() {
        insta::assert_snapshot!(example().to_csv(), @r"
        torque_nm\speed_mps,0,0.05
        -4,-0.5,-0.625
        0,0,-0.1
        ");
    }

    #[test]
    fn broken_cells_are_named_with_line_and_column() {
        let error = Matrix::from_csv("a\\b,0,1\n0,1,x\n").unwrap_err();
        assert!(matches!(&error, Error::NotANumber { line: 2, column: 3, text } if text == "x"), "{error}");
        assert!(matches!(Matrix::from_csv("a\\b,0,1\n0,1\n"), Err(Error::RaggedCsv { line: 2, found: 2, expected: 3 })));
        assert!(matches!(Matrix::from_csv(""), Err(Error::EmptyCsv)));
    }

    #[test]
    fn windows_line_ends_and_a_byte_order_mark_are_forgiven() {
        let text = format!("\u{feff}{}", example().to_csv().replace('\n', "\r\n"));
        assert_eq!(Matrix::from_csv(&text).unwrap(), example());
    }

    proptest! {
        #[test]
        fn every_number_survives_the_file(values in prop::collection::vec(-1e9..1e9f64, 4)) {
            let matrix = Matrix { values, ..example() };
            prop_assert_eq!(Matrix::from_csv(&matrix.to_csv()).unwrap(), matrix);
        }
    }
}
