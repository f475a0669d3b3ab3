//! Provenance: logs, files, settings and versions of the page.

use crate::map::LogRef;
use crate::report::ReportFiles;
use crate::report::html::{
    TableColumn::{Number, Text},
    table,
};
use crate::report::section::{Figures, Section};
use crate::report::svg::num;
use maud::{Markup, html};
use serde_json::{Map, Value, json};

/// Provenance as a section.
pub(crate) fn provenance(inputs: &ReportFiles) -> super::Result<Section> {
    let settings = serde_json::to_string_pretty(&settings(inputs))?;
    let body = html! {
        h3 { "Logs" }
        (logs(inputs))
        h3 { "Files of the map" }
        (files(inputs))
        h3 { "Vehicle and signals" }
        (table("", &[Text("what"), Text("value")], &vehicle_and_signals(inputs)))
        details {
            summary { "Settings and diagnostics, as used" }
            pre { (settings) }
        }
    };
    Ok(Section { id: "provenance", title: "Provenance", body, figures: Figures::default() })
}

fn logs(inputs: &ReportFiles) -> Markup {
    let logs = inputs.table1.logs.iter();
    let lost = |log: &LogRef| log.loss.as_ref().map_or("nothing".to_owned(), ToString::to_string);
    let rows: Vec<_> =
        logs.map(|l| vec![html! { (l.file) }, html! { (l.bytes) }, html! { (lost(l)) }, html! { code { (l.sha256) } }]).collect();
    table("", &[Text("log"), Number("bytes"), Text("lost"), Text("SHA-256")], &rows)
}

fn files(inputs: &ReportFiles) -> Markup {
    let rows: Vec<_> = inputs.files.iter().map(|(name, sha256)| vec![html! { (name) }, html! { code { (sha256) } }]).collect();
    table("", &[Text("file"), Text("SHA-256")], &rows)
}

fn vehicle_and_signals(inputs: &ReportFiles) -> Vec<Vec<String>> {
    let file = &inputs.table1;
    let vehicle = &file.vehicle;
    let others: Vec<String> = inputs.other_angles_deg.iter().map(|a| format!("{}°", num(*a, 1))).collect();
    let others = if others.is_empty() { String::new() } else { format!("; the files hold maps of {}, too", others.join(", ")) };
    let versions: Vec<&str> =
        [Some(&file.tool_version), inputs.table2.as_ref().map(|t| &t.tool_version), inputs.verdict.as_ref().map(|v| &v.tool_version)]
            .into_iter()
            .flatten()
            .map(String::as_str)
            .collect();
    let generation = if file.generation.is_empty() { "not given".to_owned() } else { file.generation.clone() };
    let mut rows = vec![
        vec!["generation".to_owned(), generation],
        vec!["wheelbase".to_owned(), format!("{} m", num(vehicle.wheelbase_m, 3))],
        vec!["wheel radius".to_owned(), format!("{} m", num(vehicle.wheel_radius_m, 4))],
        vec!["wheel angle".to_owned(), format!("{}°, left positive{others}", num(vehicle.test_angle_deg, 1))],
        vec!["torque limit".to_owned(), vehicle.torque_limit_nm.map_or("unknown".to_owned(), |l| format!("{} N·m", num(l, 1)))],
    ];
    for source in &file.witnesses {
        let error = source.scale_std_err.map_or(String::new(), |e| format!(" ± {}", num(e, 4)));
        rows.push(vec![
            format!("speed by {}", source.name),
            format!(
                "scale {}{error}, {} ms late, noise {} m/s",
                num(source.scale, 4),
                num(1e3 * source.delay_s, 1),
                num(source.noise_mps, 4)
            ),
        ]);
    }
    rows.push(vec![
        "disturbance".to_owned(),
        format!(
            "{} m/s² over {} s, {} m/s² from run to run",
            num(file.noise.disturbance_mps2, 4),
            num(file.noise.disturbance_time_s, 2),
            num(file.noise.run_offset_mps2, 4)
        ),
    ]);
    rows.push(vec![
        "written by".to_owned(),
        format!("pivot-cal {} (fit, invert, verify), page by {}", versions.join(", "), env!("CARGO_PKG_VERSION")),
    ]);
    rows
}

/// Settings of every step, and diagnostics of the fit.
fn settings(inputs: &ReportFiles) -> Map<String, Value> {
    let mut settings = Map::new();
    settings.insert("fit".to_owned(), inputs.table1.settings.clone());
    if let Some(table2) = &inputs.table2 {
        settings.insert("invert".to_owned(), table2.settings.clone());
    }
    if let Some(verdict) = &inputs.verdict {
        let verify = json!({
            "draws": verdict.draws, "seed": verdict.seed, "spread": verdict.spread, "plant": verdict.plant, "limits": verdict.limits,
            "controller": verdict.controller
        });
        settings.insert("verify".to_owned(), verify);
    }
    settings.insert("diagnostics".to_owned(), inputs.table1.report.diagnostics.clone());
    settings
}
