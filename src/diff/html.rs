//! The comparison as one HTML page: heat maps of change over standard error with values on hover, and the largest changes. No script, no
//! request; light and dark.

use crate::diff::heat_map::heat_map;
use crate::diff::{MapComparison, MapDiff, Significant, Table};
use maud::{DOCTYPE, Markup, PreEscaped, html};

/// Changes listed in a table.
const LISTED: usize = 25;

const STYLE: &str = "\
:root{--bg:#fff;--fg:#1b1f24;--soft:#5b6470;--line:#d5dae0;--zero:#f2f3f5;--none:#e3e6ea}\
@media (prefers-color-scheme:dark){:root{--bg:#14171a;--fg:#e6e8ea;--soft:#9aa4af;--line:#333a42;--zero:#23282d;--none:#1b1f23}}\
body{background:var(--bg);color:var(--fg);font:15px/1.5 system-ui,sans-serif;max-width:64rem;margin:2rem auto;padding:0 1rem}\
h1{font-size:1.5rem}h2{font-size:1.15rem;margin-top:2rem}p.soft,figcaption{color:var(--soft)}figure{margin:1rem 0}\
svg{max-width:100%;height:auto}svg text{fill:var(--fg);font:12px system-ui,sans-serif}\
table{border-collapse:collapse}td,th{padding:.2rem .7rem;border-bottom:1px solid var(--line);text-align:right}\
.verdict{font-size:1.15rem;font-weight:600}\
@media print{:root{--bg:#fff;--fg:#000;--soft:#444;--line:#999;--zero:#f2f3f5;--none:#ddd}}";

/// The page. Files are named as they were given; it contains nothing more about the machine.
pub(crate) fn html(comparison: &MapComparison) -> String {
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width";
                title { "Map difference" }
                style { (PreEscaped(STYLE)) }
            }
            body {
                h1 { "Map difference" }
                p { "a: " (comparison.a) br; "b: " (comparison.b) }
                p.verdict { (comparison.sentence()) }
                @for note in comparison.reasons.iter().chain(&comparison.notes) { p.soft { (note) } }
                @for map in &comparison.maps { (one_map(comparison.table, map)) }
            }
        }
    };
    page.into_string()
}

fn one_map(table: Table, map: &MapDiff) -> Markup {
    html! {
        h2 { (map.gear) " gear at " (map.wheel_angle_deg) "°" }
        p {
            (map.compared) " cells compared, " (map.left_out) " left out; change " (format!("{:.4}", map.rms_change)) " " (table.unit())
            " rms, z " (format!("{:.2}", map.rms_z)) " rms (1 is chance)."
            @if map.interpolated { " The axes differ: b is interpolated at the breaks of a." }
        }
        (heat_map(table, map))
        @if !map.largest.is_empty() { (changes(table, &map.largest)) }
    }
}

/// The largest changes.
fn changes(table: Table, largest: &[Significant]) -> Markup {
    let [rows_name, columns_name] = table.axes();
    let unit = table.unit();
    html! {
        table {
            tr {
                th { (rows_name) }
                th { (columns_name) }
                th { "a" }
                th { "b" }
                th { "change [" (unit) "]" }
                th { "± [" (unit) "]" }
                th { "z" }
                th { "worth [m/s²]" }
            }
            @for cell in largest.iter().take(LISTED) {
                tr {
                    td { (cell.row) }
                    td { (cell.column) }
                    td { (format!("{:.4}", cell.a)) }
                    td { (format!("{:.4}", cell.b)) }
                    td { (format!("{:+.4}", cell.change)) }
                    td { (format!("{:.4}", cell.std_err)) }
                    td { (format!("{:+.1}", cell.z)) }
                    td { (format!("{:+.3}", cell.accel_mps2)) }
                }
            }
        }
        @if largest.len() > LISTED { p.soft { "and " (largest.len() - LISTED) " more" } }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diff::{DiffSettings, DiffVerdict};

    fn change(row: usize) -> Significant {
        Significant { row: row as f64, column: 0.5, a: 1.0, b: 2.0, change: 1.0, std_err: 0.1, z: 10.0, p: 1e-6, accel_mps2: -0.25 }
    }

    #[test]
    fn names_of_files_are_escaped() {
        let page = html(&MapComparison {
            a: "<script>\"&".to_owned(),
            b: "b".to_owned(),
            table: Table::Table1,
            verdict: DiffVerdict::Incompatible,
            matters: 0,
            reasons: vec!["a <is> b".to_owned()],
            notes: Vec::new(),
            settings: DiffSettings::default(),
            threshold_p: None,
            maps: Vec::new(),
        });
        assert!(page.contains("a: &lt;script&gt;&quot;&amp;<br>b: b") && page.contains("a &lt;is&gt; b"), "{page}");
        assert!(!page.contains("<script"));
    }

    #[test]
    fn a_long_list_of_changes_is_cut_and_the_rest_counted() {
        let all: Vec<Significant> = (0..LISTED + 2).map(change).collect();
        let list = changes(Table::Table2, &all).into_string();
        assert_eq!(list.matches("<tr>").count(), LISTED + 1, "a heading and the listed ones");
        assert!(list.ends_with(">and 2 more</p>"), "{list}");
        assert!(!changes(Table::Table2, &all[..LISTED]).into_string().contains("more"));
        assert!(list.contains("<td>+10.0</td><td>-0.250</td>") && list.contains("<th>change [N·m]</th>"), "{list}");
    }
}
