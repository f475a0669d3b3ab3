//! Pieces of the page that several sections use: tables, and numbers that may be missing.
//!
//! Text is escaped where it enters the page, by its type: `html!` takes only [`Markup`] as it stands.

use crate::report::svg::num;
use maud::{Markup, Render, html};

/// A column of a table: its heading, and how its cells are aligned.
#[derive(Debug, Clone, Copy)]
pub(crate) enum TableColumn<'a> {
    /// Words, aligned left.
    Text(&'a str),
    /// Numbers, aligned right.
    Number(&'a str),
}

impl<'a> TableColumn<'a> {
    /// The heading.
    pub(crate) fn title(self) -> &'a str {
        match self {
            Self::Text(title) | Self::Number(title) => title,
        }
    }

    /// The class of its heading and of its cells.
    pub(crate) fn class(self) -> Option<&'static str> {
        matches!(self, Self::Text(_)).then_some("l")
    }
}

/// A table that scrolls sideways where it is too wide; `class` is the table's. A cell is a text, or markup.
pub(crate) fn table<C: Render>(class: &str, columns: &[TableColumn], rows: &[Vec<C>]) -> Markup {
    html! {
        div.scroll {
            table class=(class) {
                thead {
                    tr {
                        @for column in columns { th class=[column.class()] { (column.title()) } }
                    }
                }
                tbody {
                    @for row in rows {
                        tr {
                            @for (column, cell) in columns.iter().zip(row) { td class=[column.class()] { (cell) } }
                        }
                    }
                }
            }
        }
    }
}

/// A number with `digits` decimals, a dash where there is none.
pub(crate) fn num_or_dash(value: Option<f64>, digits: usize) -> String {
    value.map_or("–".to_owned(), |v| num(v, digits))
}

#[cfg(test)]
mod tests {
    use super::TableColumn::{Number, Text};
    use super::*;

    #[test]
    fn text_from_a_file_is_escaped_and_markup_is_kept() {
        let rows = [vec![html! { ("<b>&\"") }, html! { strong { "FAIL" } }]];
        let page = table("narrow", &[Text("log"), Number("a<b")], &rows).into_string();
        assert!(page.contains("<td class=\"l\">&lt;b&gt;&amp;&quot;</td><td><strong>FAIL</strong></td>"), "{page}");
        assert!(page.contains("<th class=\"l\">log</th><th>a&lt;b</th>"), "{page}");
        assert!(table("", &[Text("log")], &[vec!["<i>".to_owned()]]).into_string().contains(">&lt;i&gt;<"));
    }

    #[test]
    fn a_missing_number_is_a_dash() {
        assert_eq!(num_or_dash(Some(-0.26), 1), "−0.3");
        assert_eq!(num_or_dash(None, 1), "–");
    }
}
