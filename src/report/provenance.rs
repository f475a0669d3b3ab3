//! Provenance: logs, files, settings and versions behind the page.

use crate::report::Inputs;
use crate::report::section::Section;
use crate::report::svg::{escaped, num};

/// Provenance as a section.
pub(crate) fn provenance(inputs: &Inputs) -> crate::report::Result<Section> {
    let mut section = Section::new("provenance", "Provenance");
    let file = &inputs.table1;
    let code = |text: &str| format!("<code>{}</code>", escaped(text));
    section.heading("Logs");
    let rows: Vec<Vec<String>> = file.logs.iter().map(|l| vec![escaped(&l.file), l.bytes.to_string(), code(&l.sha256)]).collect();
    section.table("", &["log|", "bytes", "SHA-256|"], &rows);
    section.heading("Files of the map");
    let rows: Vec<Vec<String>> = inputs.files.iter().map(|(name, sha256)| vec![escaped(name), code(sha256)]).collect();
    section.table("", &["file|", "SHA-256|"], &rows);
    let vehicle = &file.vehicle;
    let limit = vehicle.torque_limit_nm.map_or("unknown".to_owned(), |l| format!("{} N·m", num(l, 1)));
    let versions: Vec<String> =
        [Some(&file.tool_version), inputs.table2.as_ref().map(|t| &t.tool_version), inputs.verdict.as_ref().map(|v| &v.tool_version)]
            .into_iter()
            .flatten()
            .map(|v| escaped(v))
            .collect();
    let others: Vec<String> = inputs.other_angles_deg.iter().map(|a| format!("{}°", num(*a, 1))).collect();
    let others = if others.is_empty() { String::new() } else { format!("; the files hold maps of {}, too", others.join(", ")) };
    let mut rows = vec![
        vec!["wheelbase".to_owned(), format!("{} m", num(vehicle.wheelbase_m, 3))],
        vec!["wheel radius".to_owned(), format!("{} m", num(vehicle.wheel_radius_m, 4))],
        vec!["wheel angle".to_owned(), format!("{}°, left positive{others}", num(vehicle.test_angle_deg, 1))],
        vec!["torque limit".to_owned(), limit],
    ];
    for witness in &file.witnesses {
        let error = witness.scale_std_err.map_or(String::new(), |e| format!(" ± {}", num(e, 4)));
        rows.push(vec![
            format!("speed by {}", witness.name),
            format!(
                "scale {}{error}, {} ms late, noise {} m/s",
                num(witness.scale, 4),
                num(1e3 * witness.delay_s, 1),
                num(witness.noise_mps, 4)
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
    section.heading("Vehicle and signals");
    section.table("", &["what|", "value|"], &rows);
    let mut settings = serde_json::Map::new();
    settings.insert("fit".to_owned(), file.settings.clone());
    if let Some(table2) = &inputs.table2 {
        settings.insert("invert".to_owned(), table2.settings.clone());
    }
    if let Some(verdict) = &inputs.verdict {
        settings.insert(
            "verify".to_owned(),
            serde_json::json!({ "draws": verdict.draws, "seed": verdict.seed, "spread": verdict.spread, "plant": verdict.plant, "limits": verdict.limits, "controller": verdict.controller }),
        );
    }
    settings.insert("diagnostics".to_owned(), file.report.diagnostics.clone());
    let text = serde_json::to_string_pretty(&settings)?;
    section.body.push_str("<details><summary>Settings and diagnostics, as used</summary><pre>");
    section.body.push_str(&escaped(&text));
    section.body.push_str("</pre></details>\n");
    Ok(section)
}
