//! Pieces of the page: tables and paragraphs.

use crate::report::svg::escaped;
use std::fmt::Write as _;

/// A table; `header` cells that end in `|` head columns of text, the others columns of numbers. `class` goes to the table. Cells are HTML.
pub(crate) fn table(class: &str, header: &[&str], rows: &[Vec<String>]) -> String {
    let text_column: Vec<bool> = header.iter().map(|h| h.ends_with('|')).collect();
    let mut html = format!("<div class=\"scroll\"><table class=\"{class}\"><thead><tr>");
    let left = |k: usize| if text_column.get(k).copied().unwrap_or(true) { " class=\"l\"" } else { "" };
    for (k, name) in header.iter().enumerate() {
        let _ = write!(html, "<th{}>{}</th>", left(k), escaped(name.trim_end_matches('|')));
    }
    html.push_str("</tr></thead><tbody>\n");
    for row in rows {
        html.push_str("<tr>");
        for (k, cell) in row.iter().enumerate() {
            let _ = write!(html, "<td{}>{cell}</td>", left(k));
        }
        html.push_str("</tr>\n");
    }
    html.push_str("</tbody></table></div>\n");
    html
}

/// A paragraph of plain text.
pub(crate) fn paragraph(text: &str) -> String {
    format!("<p>{}</p>\n", escaped(text))
}

/// A remark that something is absent.
pub(crate) fn absent(text: &str) -> String {
    format!("<p class=\"absent\">{}</p>\n", escaped(text))
}
