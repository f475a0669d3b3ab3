//! The comparison as one HTML page: heat maps of change over standard error with values on hover, and the largest changes. No script, no
//! request; light and dark.

use crate::diff::{MapComparison, MapDiff, Significant};
use std::fmt::Write as _;

/// Changes listed in a table.
const LISTED: usize = 25;
/// |z| at which the colour is full.
const FULL_Z: f64 = 6.0;

const STYLE: &str = "\
:root{--bg:#fff;--fg:#1b1f24;--soft:#5b6470;--line:#d5dae0;--zero:#f2f3f5;--none:#e3e6ea}\
@media (prefers-color-scheme:dark){:root{--bg:#14171a;--fg:#e6e8ea;--soft:#9aa4af;--line:#333a42;--zero:#23282d;--none:#1b1f23}}\
body{background:var(--bg);color:var(--fg);font:15px/1.5 system-ui,sans-serif;max-width:64rem;margin:2rem auto;padding:0 1rem}\
h1{font-size:1.5rem}h2{font-size:1.15rem;margin-top:2rem}p.soft,figcaption{color:var(--soft)}figure{margin:1rem 0}\
svg{max-width:100%;height:auto}svg text{fill:var(--fg);font:12px system-ui,sans-serif}\
table{border-collapse:collapse}td,th{padding:.2rem .7rem;border-bottom:1px solid var(--line);text-align:right}\
.verdict{font-size:1.15rem;font-weight:600}\
@media print{:root{--bg:#fff;--fg:#000;--soft:#444;--line:#999;--zero:#f2f3f5;--none:#ddd}}";

/// The page. Files are named as they were given; nothing else of the machine is in it.
pub fn html(comparison: &MapComparison) -> String {
    let mut page = String::from("<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n");
    page.push_str("<meta name=\"viewport\" content=\"width=device-width\">\n<title>Map difference</title>\n");
    let _ = writeln!(page, "<style>{STYLE}</style>\n</head>\n<body>\n<h1>Map difference</h1>");
    let _ = writeln!(page, "<p>a: {}<br>b: {}</p>", escaped(&comparison.a), escaped(&comparison.b));
    let _ = writeln!(page, "<p class=\"verdict\">{}</p>", escaped(&comparison.sentence()));
    for note in comparison.reasons.iter().chain(&comparison.notes) {
        let _ = writeln!(page, "<p class=\"soft\">{}</p>", escaped(note));
    }
    for map in &comparison.maps {
        heat_map(&mut page, comparison, map);
    }
    page.push_str("</body>\n</html>\n");
    page
}

fn heat_map(page: &mut String, comparison: &MapComparison, map: &MapDiff) {
    let [rows_name, columns_name] = comparison.table.axes();
    let unit = comparison.table.unit();
    let (left, top, width, height) = (64.0, 8.0, 880.0, 420.0);
    let (rows, columns) = (map.rows.len(), map.columns.len());
    let (w, h) = (width / columns as f64, height / rows as f64);
    let _ = writeln!(page, "<h2>{} gear at {}°</h2>", map.gear, map.wheel_angle_deg);
    let _ = writeln!(
        page,
        "<p>{} cells compared, {} left out; change {:.4} {unit} rms, z {:.2} rms (1 is chance).{}</p>",
        map.compared,
        map.left_out,
        map.rms_change,
        map.rms_z,
        if map.interpolated { " The axes differ: b is interpolated at the breaks of a." } else { "" }
    );
    let _ =
        writeln!(page, "<figure>\n<svg viewBox=\"0 0 960 500\" role=\"img\" aria-label=\"change over standard error, {} gear\">", map.gear);
    for (i, row) in map.rows.iter().enumerate() {
        for (j, column) in map.columns.iter().enumerate() {
            // the first row at the bottom, as on a graph
            let (x, y) = (left + w * j as f64, top + h * (rows - 1 - i) as f64);
            let cell = map.change[i][j].zip(map.std_err[i][j]).zip(map.z[i][j]);
            let significant = map.largest.iter().any(|c| c.row == *row && c.column == *column);
            let (fill, title) = match cell {
                Some(((change, error), z)) => (colour(z), format!("{change:+.4} ± {error:.4} {unit}, z {z:+.1}")),
                None => ("var(--none)".to_owned(), "not compared".to_owned()),
            };
            let stroke = if significant { " stroke=\"var(--fg)\" stroke-width=\"1\"" } else { "" };
            let _ = writeln!(
                page,
                "<rect x=\"{x:.1}\" y=\"{y:.1}\" width=\"{:.1}\" height=\"{:.1}\" fill=\"{fill}\"{stroke}><title>{rows_name} {row}, {columns_name} {column}: {title}</title></rect>",
                w - 0.5,
                h - 0.5
            );
        }
    }
    for k in ticks(rows) {
        let y = top + h * (rows - 1 - k) as f64 + 0.5 * h + 4.0;
        let _ = writeln!(page, "<text x=\"{:.0}\" y=\"{y:.1}\" text-anchor=\"end\">{}</text>", left - 6.0, map.rows[k]);
    }
    for k in ticks(columns) {
        let x = left + w * (k as f64 + 0.5);
        let _ = writeln!(page, "<text x=\"{x:.1}\" y=\"{:.0}\" text-anchor=\"middle\">{}</text>", top + height + 18.0, map.columns[k]);
    }
    let _ = writeln!(
        page,
        "<text x=\"{:.0}\" y=\"{:.0}\" text-anchor=\"middle\">{columns_name}</text>",
        left + 0.5 * width,
        top + height + 40.0
    );
    let (x, y) = (14.0, top + 0.5 * height);
    let _ = writeln!(page, "<text x=\"{x}\" y=\"{y}\" text-anchor=\"middle\" transform=\"rotate(-90 {x} {y})\">{rows_name}</text>\n</svg>");
    let _ = writeln!(
        page,
        "<figcaption>Change over its standard error: blue where b is lower, red where b is higher, full colour from ±{FULL_Z}; outlined \
         where significant; grey where not compared. Values on hover.</figcaption>\n</figure>"
    );
    if map.largest.is_empty() {
        return;
    }
    let _ = writeln!(
        page,
        "<table>\n<tr><th>{rows_name}</th><th>{columns_name}</th><th>a</th><th>b</th><th>change [{unit}]</th><th>± [{unit}]</th><th>z</th><th>worth [m/s²]</th></tr>"
    );
    map.largest.iter().take(LISTED).for_each(|cell| table_row(page, cell));
    page.push_str("</table>\n");
    if map.largest.len() > LISTED {
        let _ = writeln!(page, "<p class=\"soft\">and {} more</p>", map.largest.len() - LISTED);
    }
}

fn table_row(page: &mut String, cell: &Significant) {
    let _ = writeln!(
        page,
        "<tr><td>{}</td><td>{}</td><td>{:.4}</td><td>{:.4}</td><td>{:+.4}</td><td>{:.4}</td><td>{:+.1}</td><td>{:+.3}</td></tr>",
        cell.row, cell.column, cell.a, cell.b, cell.change, cell.std_err, cell.z, cell.accel_mps2
    );
}

/// About ten of `count` places, the first among them.
fn ticks(count: usize) -> impl Iterator<Item = usize> {
    (0..count).step_by(count.div_ceil(10).max(1))
}

/// Blue below 0, red above, over the page's neutral colour.
fn colour(z: f64) -> String {
    let share = (100.0 * (z.abs() / FULL_Z).min(1.0)).round();
    let end = if z < 0.0 { "#2166ac" } else { "#b2182b" };
    format!("color-mix(in oklab,{end} {share}%,var(--zero))")
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
