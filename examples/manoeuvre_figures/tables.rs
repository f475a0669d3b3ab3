//! The tables of `docs/manoeuvres.md` from a verdict on all manoeuvres, as `pivot-cal verify --scenario manoeuvres --json` prints it.

use serde_json::Value;

/// A figure of a metric: name of the metric, factor, decimals, unit.
type Figure = (&'static str, f64, usize, &'static str);

/// A table: its name in the document, its header, and the scenarios and figures of its rows.
struct Layout {
    name: &'static str,
    header: &'static [&'static str],
    prefix: &'static str,
    figures: &'static [Figure],
    /// Whether the 99th percentile follows in brackets.
    spread: bool,
}

/// A manoeuvre that is planned to a place, without its name.
const PLANNED: Layout = Layout {
    name: "",
    header: &["scenario", "final position", "heading", "smallest clearance", "clearance lost in the drive", "curvature step"],
    prefix: "",
    figures: &[
        ("final_position_m", 1e3, 1, "mm"),
        ("heading_error_deg", 1.0, 2, "°"),
        ("clearance_m", 1.0, 3, "m"),
        ("clearance_loss_m", 1e3, 1, "mm"),
        ("curvature_step_per_m", 1.0, 3, "m⁻¹"),
    ],
    spread: false,
};

const LAYOUTS: [Layout; 4] = [
    Layout {
        name: "polyline",
        header: &["scenario", "corner", "segment", "segment RMS", "time"],
        prefix: "polyline-",
        figures: &[
            ("corner_error_m", 1e3, 1, "mm"),
            ("segment_error_m", 1e3, 1, "mm"),
            ("segment_rms_m", 1e3, 1, "mm"),
            ("time_s", 1.0, 0, "s"),
        ],
        spread: true,
    },
    Layout {
        name: "compensation",
        header: &["scenario", "before", "after", "after/before (gate ≤ 0.1)", "RMS of heading rate (gate ≤ 1.05)"],
        prefix: "lateral-",
        figures: &[
            ("lateral_before_m", 1e3, 1, "mm"),
            ("lateral_after_m", 1e3, 1, "mm"),
            ("lateral_ratio", 1.0, 3, ""),
            ("heading_rate_ratio", 1.0, 3, ""),
        ],
        spread: true,
    },
    Layout { name: "parking", prefix: "parking", ..PLANNED },
    Layout { name: "u-turn", prefix: "u-turn", ..PLANNED },
];

/// Name and Markdown of every table.
pub(crate) fn tables(verdict: &Value) -> Vec<(&'static str, String)> {
    LAYOUTS.iter().map(|layout| (layout.name, table(verdict, layout))).collect()
}

fn table(verdict: &Value, layout: &Layout) -> String {
    let line = |cells: &[String]| format!("| {} |\n", cells.join(" | "));
    let header: Vec<String> = layout.header.iter().map(|cell| (*cell).to_owned()).collect();
    let mut text = line(&header) + &format!("|{}\n", "---|".repeat(header.len()));
    let none = Vec::new();
    for scenario in verdict["scenarios"].as_array().unwrap_or(&none) {
        let name = scenario["name"].as_str().unwrap_or_default();
        if !name.starts_with(layout.prefix) {
            continue;
        }
        let cells = layout.figures.iter().map(|figure| cell(scenario, figure, layout.spread));
        text.push_str(&line(&std::iter::once(format!("`{name}`")).chain(cells).collect::<Vec<_>>()));
    }
    text
}

fn cell(scenario: &Value, (metric, factor, decimals, unit): &Figure, spread: bool) -> String {
    let none = Vec::new();
    let summary = scenario["metrics"].as_array().unwrap_or(&none).iter().find(|m| m["metric"] == *metric);
    let shown = |statistic: &str| {
        let value = summary.and_then(|s| s[statistic].as_f64());
        value.map_or("none".to_owned(), |v| format!("{:.*}", *decimals, factor * v + 0.0))
    };
    let space = if unit.is_empty() || *unit == "°" { "" } else { " " };
    let nominal = format!("{}{space}{unit}", shown("nominal"));
    if spread { format!("{nominal} ({})", shown("p99")) } else { nominal }
}

/// The document with the tables between its marks `<!-- table NAME -->` and `<!-- end of table -->`.
pub(crate) fn filled(document: &str, tables: &[(&'static str, String)]) -> String {
    tables.iter().fold(document.to_owned(), |text, (name, table)| {
        let mark = format!("<!-- table {name} -->\n");
        let Some(from) = text.find(&mark).map(|at| at + mark.len()) else { return text };
        let Some(to) = text[from..].find("<!-- end of table -->").map(|at| from + at) else { return text };
        format!("{}{table}{}", &text[..from], &text[to..])
    })
}
