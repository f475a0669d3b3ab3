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
/// begins no further cell.
pub(crate) fn cells_of_csv(text: &str) -> Vec<CsvLine> {
    let lines = text.trim_start_matches('\u{feff}').lines().enumerate();
    lines
        .filter(|(_, line)| !line.trim().is_empty())
        .map(|(k, line)| {
            let mut texts: Vec<_> = line.split(',').map(|cell| cell.trim().to_owned()).collect();
            if texts.len() > 1 && texts.last().is_some_and(String::is_empty) {
                texts.pop();
            }
            CsvLine { line: k as u64 + 1, texts }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_separator_at_the_end_begins_no_cell() {
        let cells = cells_of_csv("default,\r\n\n0,1 ,\n");
        assert_eq!(cells.iter().map(|c| (c.line, c.texts.len())).collect::<Vec<_>>(), [(1, 1), (3, 2)]);
        assert_eq!(cells[1].texts, ["0", "1"]);
    }
}
