//! A text of separated values as cells with their lines.

/// One line of the text: its number, counted from 1, and its cells without blanks around them.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct CsvLine {
    /// Line, counted from 1.
    pub line: u64,
    /// The line's cells.
    pub texts: Vec<String>,
}

/// The lines of `text` that are not blank. As in the loaders of most controllers, there are no quotes, and a separator at the end of a line
/// begins no further cell. Semicolons and tabs of spreadsheets separate too; then a comma in a number is a decimal comma.
pub(crate) fn cells_of_csv(text: &str) -> Vec<CsvLine> {
    let text = text.trim_start_matches('\u{feff}');
    let first = text.lines().find(|line| !line.trim().is_empty()).unwrap_or_default();
    let separator = [';', '\t'].into_iter().find(|sign| first.contains(*sign)).unwrap_or(',');
    text.lines()
        .enumerate()
        .filter(|(_, line)| !line.trim().is_empty())
        .map(|(k, line)| {
            let mut texts: Vec<_> = line.split(separator).map(|cell| cell_text(cell, separator)).collect();
            if texts.len() > 1 && texts.last().is_some_and(String::is_empty) {
                texts.pop();
            }
            CsvLine { line: k as u64 + 1, texts }
        })
        .collect()
}

/// A cell without blanks around it, and a number with its decimal point.
fn cell_text(cell: &str, separator: char) -> String {
    let cell = cell.trim();
    let pointed = cell.replacen(',', ".", 1);
    if separator != ',' && cell.contains(',') && pointed.parse::<f64>().is_ok() { pointed } else { cell.to_owned() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spreadsheets_separate_by_semicolons_or_tabs_and_have_decimal_commas() {
        for text in ["\u{feff}speed;0,1;-0,2\r\n0;1,25;2\r\n", "speed\t0,1\t-0,2\n0\t1,25\t2\n", "speed,0.1,-0.2\n0,1.25,2\n"] {
            let cells = cells_of_csv(text);
            assert_eq!(cells[0].texts, ["speed", "0.1", "-0.2"], "{text}");
            assert_eq!(cells[1].texts, ["0", "1.25", "2"], "{text}");
        }
    }

    #[test]
    fn a_separator_at_the_end_begins_no_cell() {
        let cells = cells_of_csv("default,\r\n\n0,1 ,\n");
        assert_eq!(cells.iter().map(|c| (c.line, c.texts.len())).collect::<Vec<_>>(), [(1, 1), (3, 2)]);
        assert_eq!(cells[1].texts, ["0", "1"]);
    }
}
