//! Every run as a row; its traces appear when it is clicked.

use crate::map::{RunRow, RunTrace};
use crate::report::Inputs;
use crate::report::section::Section;
use crate::report::svg::{escaped, num};
use serde_json::{Value, json};
use std::fmt::Write as _;

/// Most rows: beyond that those with the largest residual are shown.
const MOST_ROWS: usize = 1000;

/// The runs as a section.
pub(crate) fn runs(inputs: &Inputs) -> Section {
    let mut section = Section::new("runs", "Runs");
    let rows = &inputs.table1.report.runs;
    let traces = inputs.fit_traces.as_ref();
    section.paragraph(
        "One row per held torque. Residual and R² compare the recorded speed with one simulated from the run's start by a surface that was \
         fitted without the run; the offset is the constant acceleration by which the run differs from the rest.",
    );
    if traces.is_some() {
        section.body.push_str("<p class=\"screen\">Click a row for its traces, a heading to sort.</p>\n");
    } else {
        section.absent("The traces of the runs are not here: fit_traces.json is missing or belongs to another fit.");
    }
    let shown = shown(rows);
    if shown.len() < rows.len() {
        section.paragraph(&format!("Of {} runs the {MOST_ROWS} with the largest residual are listed.", rows.len()));
    }
    let (several, angles) = (inputs.table1.logs.len() > 1, rows.iter().any(|r| r.wheel_angle_deg.is_some()));
    let mut header =
        vec!["#", "start s", "gear|", "torque N·m", "from m/s", "to m/s", "held s", "used s", "residual m/s", "R²", "offset m/s²"];
    if angles {
        header.insert(3, "angle °");
    }
    if several {
        header.insert(1, "log|");
    }
    header.push("left out|");
    let mut html = "<div class=\"scroll box\" tabindex=\"0\"><table class=\"runs\"><thead><tr>".to_owned();
    for name in &header {
        let class = if name.ends_with('|') { " class=\"l\"" } else { "" };
        let _ = write!(html, "<th{class} scope=\"col\">{}</th>", name.trim_end_matches('|'));
    }
    html.push_str("</tr></thead><tbody>\n");
    for k in shown {
        html.push_str(&row(k, &rows[k], (several, angles), traces.is_some_and(|t| t.runs.iter().any(|r| r.row == k))));
    }
    html.push_str("</tbody></table></div>\n");
    section.body.push_str(&html);
    let ledger: Vec<Vec<String>> =
        inputs.table1.report.ledger.iter().map(|r| vec![r.verdict.to_string(), r.samples.to_string(), num(r.seconds, 2)]).collect();
    section.heading("What became of the samples");
    section.table("narrow", &["verdict|", "samples", "seconds"], &ledger);
    section
}

fn shown(rows: &[RunRow]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..rows.len()).collect();
    if rows.len() > MOST_ROWS {
        let size = |k: usize| rows[k].speed_rmse_mps.unwrap_or(-1.0);
        order.sort_by(|a, b| size(*b).total_cmp(&size(*a)).then(a.cmp(b)));
        order.truncate(MOST_ROWS);
        order.sort_unstable();
    }
    order
}

/// A run; with its log and its wheel angle where there are several.
fn row(k: usize, run: &RunRow, (several, angles): (bool, bool), traced: bool) -> String {
    let told = |value: Option<f64>, digits| value.map_or("–".to_owned(), |v| num(v, digits));
    let reasons: Vec<String> = run.rejected.iter().map(|r| format!("{}\u{a0}{}\u{a0}s", r.verdict, num(r.seconds, 2))).collect();
    let unused = if run.used_s > 0.0 { "" } else { " unused" };
    let click = if traced {
        format!(" class=\"click{unused}\" tabindex=\"0\" aria-expanded=\"false\"")
    } else {
        format!(" class=\"{}\"", unused.trim())
    };
    let log = if several { format!("<td class=\"l\">{}</td>", escaped(&run.log)) } else { String::new() };
    let angle = if angles { format!("<td>{}</td>", told(run.wheel_angle_deg, 1)) } else { String::new() };
    format!(
        "<tr data-row=\"{k}\"{click}><td>{}</td>{log}<td>{}</td><td class=\"l\">{}</td>{angle}<td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td>\
         <td>{}</td><td>{}</td><td>{}</td><td class=\"l why\">{}</td></tr>\n",
        k + 1,
        num(run.start_s, 2),
        run.gear,
        num(run.torque_nm, 1),
        num(run.start_speed_mps, 3),
        num(run.end_speed_mps, 3),
        num(run.duration_s, 2),
        num(run.used_s, 2),
        told(run.speed_rmse_mps, 4),
        told(run.r_squared, 4),
        told(run.offset_mps2, 3),
        reasons.join(", ")
    )
}

/// The traces as the page's script reads them.
pub(crate) fn data(inputs: &Inputs) -> Value {
    let Some(traces) = &inputs.fit_traces else { return Value::Null };
    let rows = &inputs.table1.report.runs;
    let one = |r: &RunTrace| {
        let span = rows.get(r.row).map(|row| [row.start_s, row.start_s + row.duration_s]);
        (
            r.row.to_string(),
            json!({
                "t": r.t_s, "v": r.speed_mps, "s": r.simulated_mps, "u": r.effective_nm, "a": r.angle_deg, "c": r.command, "w": r.verdicts, "h": span
            }),
        )
    };
    json!({ "verdicts": traces.verdicts, "runs": traces.runs.iter().map(one).collect::<serde_json::Map<String, Value>>() })
}
