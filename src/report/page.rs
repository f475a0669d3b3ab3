//! The page put together, and the figures as files.

use crate::report::scale::Colours;
use crate::report::section::Section;
use crate::report::svg::{PATTERNS, STYLE, escaped};
use crate::report::{
    Inputs, Result, closed_loop, coverage, delay, friction, manoeuvres, next, provenance, residuals, round_trip, runs, summary, tables,
};
use serde_json::json;
use std::fmt::Write as _;

const PAGE_STYLE: &str = include_str!("page.css");
const SCRIPT: &str = include_str!("page.js");

/// A report.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Report {
    /// The page: HTML, one file, nothing is fetched.
    pub html: String,
    /// Name without extension and text of every figure as an SVG file of its own.
    pub pictures: Vec<(String, String)>,
}

/// Makes the report.
///
/// # Errors
/// A table that is not sound; what was read by [`Inputs::read`] is.
pub fn report(inputs: &Inputs) -> Result<Report> {
    let sections = [
        tables::table1(inputs),
        tables::table2(inputs),
        coverage::coverage(inputs),
        runs::runs(inputs),
        delay::delay(inputs),
        residuals::residuals(inputs),
        friction::friction(inputs),
        round_trip::round_trip(inputs)?,
        closed_loop::closed_loop(inputs),
        manoeuvres::manoeuvres(inputs),
        next::next(inputs),
        provenance::provenance(inputs)?,
    ];
    let pictures = sections.iter().flat_map(|s| &s.pictures).map(|svg| (svg.id().to_owned(), svg.file())).collect();
    Ok(Report { html: html(inputs, &sections)?, pictures })
}

fn html(inputs: &Inputs, sections: &[Section]) -> Result<String> {
    let vehicle = &inputs.table1.vehicle;
    let logs = match &inputs.table1.logs[..] {
        [one] => one.file.clone(),
        many => format!("{} logs", many.len()),
    };
    let heats: serde_json::Map<String, serde_json::Value> = sections.iter().flat_map(|s| s.heats.iter().cloned()).collect();
    let data = json!({ "heats": heats, "traces": runs::data(inputs), "viridis": Colours::Viridis.all() });
    // "</" would end the script
    let data = serde_json::to_string(&data)?.replace("</", "<\\/");
    let mut html = format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <meta name=\"color-scheme\" content=\"light dark\">\n<link rel=\"icon\" href=\"data:,\">\n<title>Torque map: {title}</title>\n\
         <style>\n{PAGE_STYLE}{STYLE}</style>\n</head>\n<body>\n\
         <svg width=\"0\" height=\"0\" style=\"position:absolute\" aria-hidden=\"true\">{PATTERNS}</svg>\n\
         <header><h1>Torque map for turning on the spot</h1><p>{title} · wheelbase {wheelbase} m, wheel at {angle}°, {gears}</p></header>\n",
        title = escaped(&logs),
        wheelbase = vehicle.wheelbase_m,
        angle = vehicle.test_angle_deg,
        gears = inputs.table1.maps.iter().map(|m| m.gear.to_string()).collect::<Vec<_>>().join(" and ")
    );
    html.push_str("<nav aria-label=\"Sections\">");
    let _ = write!(html, "<a href=\"#verdict\">Verdict</a>");
    for section in sections {
        let name = match section.id {
            "coverage" => "Coverage",
            "delay" => "Delays",
            "friction" => "Friction",
            "next" => "Drive next",
            _ => section.title.split(':').next().unwrap_or(section.title),
        };
        let _ = write!(html, "<a href=\"#{}\">{}</a>", section.id, escaped(name));
    }
    html.push_str("</nav>\n<main>\n");
    html.push_str(&summary::summary(inputs));
    for section in sections {
        let _ = write!(html, "<section id=\"{}\"><h2>{}</h2>\n{}</section>\n", section.id, escaped(section.title), section.body);
    }
    let _ = write!(
        html,
        "</main>\n<footer>pivot-cal {}</footer>\n<div id=\"tip\" role=\"status\" hidden></div>\n\
         <script type=\"application/json\" id=\"data\">{data}</script>\n<script>\n{SCRIPT}</script>\n</body>\n</html>\n",
        env!("CARGO_PKG_VERSION")
    );
    Ok(html)
}
