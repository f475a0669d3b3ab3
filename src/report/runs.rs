//! Every run as a row; a click shows its traces.

use crate::map::{LedgerRow, RunRow, RunTrace};
use crate::report::ReportFiles;
use crate::report::html::{
    TableColumn::{Number, Text},
    num_or_dash, table,
};
use crate::report::section::{Figures, Section};
use crate::report::svg::num;
use maud::{Markup, html};
use serde_json::{Value, json};

/// Largest number of rows; of more, those with the largest residual are shown.
const MOST_ROWS: usize = 1000;

/// Columns that only some maps need.
#[derive(Debug, Clone, Copy)]
struct Extra {
    /// The log of a run, if there are several.
    log: bool,
    /// Its wheel angle, if there are several.
    angle: bool,
}

/// The runs as a section.
pub(crate) fn runs(inputs: &ReportFiles) -> Section {
    let rows = &inputs.table1.report.runs;
    let shown = shown(rows);
    let body = html! {
        p {
            "One row per held torque. Residual and R² compare the recorded speed with one simulated from the run's start by a surface that was \
             fitted without the run; the offset is the constant acceleration by which the run differs from the rest."
        }
        @if inputs.fit_traces.is_some() {
            p.screen { "Click a row for its traces, a heading to sort." }
        } @else {
            p.absent { "The traces of the runs are not here: fit_traces.json is missing or belongs to another fit." }
        }
        @if let Some(counts) = inputs.table1.report.listed_runs {
            p { "Of " (counts.all) " runs table1.json lists " (counts.listed) ": those with the largest residual, and evenly spaced ones." }
        }
        @if shown.len() < rows.len() {
            p { "Of " (rows.len()) " runs the " (MOST_ROWS) " with the largest residual are listed." }
        }
        (list(inputs, &shown))
        h3 { "Verdicts on the samples" }
        (ledger(&inputs.table1.report.ledger))
    };
    Section { id: "runs", title: "Runs", body, figures: Figures::default() }
}

/// Indices of the rows that are listed.
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

fn list(inputs: &ReportFiles, shown: &[usize]) -> Markup {
    let rows = &inputs.table1.report.runs;
    let extra = Extra { log: inputs.table1.logs.len() > 1, angle: rows.iter().any(|r| r.wheel_angle_deg.is_some()) };
    let traced = |k: usize| inputs.fit_traces.as_ref().is_some_and(|t| t.runs.iter().any(|r| r.row == k));
    html! {
        div.scroll.box tabindex="0" {
            table.runs {
                thead { (headings(extra)) }
                tbody {
                    @for &k in shown { (row(k, &rows[k], extra, traced(k))) }
                }
            }
        }
    }
}

fn headings(extra: Extra) -> Markup {
    let columns = [
        Some(Number("#")),
        extra.log.then_some(Text("log")),
        Some(Number("start s")),
        Some(Text("gear")),
        extra.angle.then_some(Number("angle °")),
        Some(Number("torque N·m")),
        Some(Number("from m/s")),
        Some(Number("to m/s")),
        Some(Number("held s")),
        Some(Number("used s")),
        Some(Number("residual m/s")),
        Some(Number("R²")),
        Some(Number("offset m/s²")),
        Some(Text("left out")),
    ];
    html! {
        tr {
            @for column in columns.into_iter().flatten() { th class=[column.class()] scope="col" { (column.title()) } }
        }
    }
}

/// A run. The script shows its traces below it, if it has any.
fn row(k: usize, run: &RunRow, extra: Extra, traced: bool) -> Markup {
    let class = match (traced, run.used_s > 0.0) {
        (true, true) => "click",
        (true, false) => "click unused",
        (false, true) => "",
        (false, false) => "unused",
    };
    html! {
        tr data-row=(k) class=(class) tabindex=[traced.then_some("0")] aria-expanded=[traced.then_some("false")] {
            td { (k + 1) }
            @if extra.log { td.l { (run.log) } }
            td { (num(run.start_s, 2)) }
            td.l { (run.gear) }
            @if extra.angle { td { (num_or_dash(run.wheel_angle_deg, 1)) } }
            td { (num(run.torque_nm, 1)) }
            td { (num(run.start_speed_mps, 3)) }
            td { (num(run.end_speed_mps, 3)) }
            td { (num(run.duration_s, 2)) }
            td { (num(run.used_s, 2)) }
            td { (num_or_dash(run.speed_rmse_mps, 4)) }
            td { (num_or_dash(run.r_squared, 4)) }
            td { (num_or_dash(run.offset_mps2, 3)) }
            td.l.why { (left_out(&run.rejected)) }
        }
    }
}

/// Why samples of a run were not used, with their seconds.
fn left_out(rejected: &[LedgerRow]) -> String {
    rejected.iter().map(|r| format!("{}\u{a0}{}\u{a0}s", r.verdict, num(r.seconds, 2))).collect::<Vec<String>>().join(", ")
}

fn ledger(ledger: &[LedgerRow]) -> Markup {
    let rows: Vec<_> = ledger.iter().map(|r| vec![r.verdict.to_string(), r.samples.to_string(), num(r.seconds, 2)]).collect();
    table("narrow", &[Text("verdict"), Number("samples"), Number("seconds")], &rows)
}

/// The traces for the page's script.
pub(crate) fn data(inputs: &ReportFiles) -> Value {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::Gear;

    fn run(used_s: f64, speed_rmse_mps: Option<f64>) -> RunRow {
        RunRow {
            log: "<a>.mcap".to_owned(),
            wheel_angle_deg: Some(80.0),
            start_s: 1.0,
            duration_s: 2.0,
            gear: Gear::Reverse,
            torque_nm: -20.0,
            start_speed_mps: 0.5,
            end_speed_mps: 0.25,
            used_s,
            speed_rmse_mps,
            r_squared: None,
            offset_mps2: None,
            rejected: vec![LedgerRow { verdict: crate::map::SampleVerdict::Slip, samples: 3, seconds: 0.5 }],
        }
    }

    #[test]
    fn of_too_many_runs_those_with_the_largest_residual_stay_in_their_order() {
        let mut all: Vec<RunRow> = (0..MOST_ROWS + 3).map(|_| run(1.0, Some(0.1))).collect();
        all[0].speed_rmse_mps = Some(0.01);
        all[7].speed_rmse_mps = None;
        all[9].speed_rmse_mps = Some(0.02);
        let found = shown(&all);
        assert_eq!(found.len(), MOST_ROWS);
        assert!(found.is_sorted() && ![0, 7, 9].iter().any(|k| found.contains(k)));
        assert_eq!(shown(&all[..3]), [0, 1, 2]);
    }

    #[test]
    fn a_row_can_be_opened_if_it_has_traces_and_has_as_many_cells_as_headings() {
        let every = Extra { log: true, angle: true };
        let opened = row(4, &run(0.0, None), every, true).into_string();
        assert!(
            opened.starts_with("<tr data-row=\"4\" class=\"click unused\" tabindex=\"0\" aria-expanded=\"false\"><td>5</td>"),
            "{opened}"
        );
        assert!(opened.contains(">&lt;a&gt;.mcap<") && opened.contains("slip\u{a0}0.50\u{a0}s"), "{opened}");
        let closed = row(4, &run(1.0, None), every, false).into_string();
        assert!(closed.starts_with("<tr data-row=\"4\" class=\"\"><td>"), "{closed}");
        for extra in [every, Extra { log: false, angle: true }, Extra { log: true, angle: false }] {
            let cells = row(0, &run(1.0, None), extra, false).into_string().matches("<td").count();
            assert_eq!(cells, headings(extra).into_string().matches("<th").count(), "{extra:?}");
        }
    }
}
