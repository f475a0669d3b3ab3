//! The page put together, and the figures as files.

use crate::report::scale::Colours;
use crate::report::section::Section;
use crate::report::svg::{PATTERNS, STYLE};
use crate::report::{ReportFiles, Result};
use crate::report::{closed_loop, coverage, delay, friction, manoeuvres, next, provenance, residuals, round_trip, runs, summary, tables};
use maud::{DOCTYPE, Markup, PreEscaped, html};
use serde_json::json;

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
/// A table that is not sound; what was read by [`ReportFiles::read`] is.
pub fn report(inputs: &ReportFiles) -> Result<Report> {
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
    let pictures = sections.iter().flat_map(|s| &s.figures.pictures).map(|svg| (svg.id().to_owned(), svg.file())).collect();
    Ok(Report { html: page(inputs, &sections)?.into_string(), pictures })
}

fn page(inputs: &ReportFiles, sections: &[Section]) -> Result<Markup> {
    let logs = logs(inputs);
    let data = data(inputs, sections)?;
    Ok(html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta name="color-scheme" content="light dark";
                link rel="icon" href="data:,";
                title { "Torque map: " (logs) }
                style { (PreEscaped(PAGE_STYLE)) (PreEscaped(STYLE)) }
            }
            body {
                svg width="0" height="0" style="position:absolute" aria-hidden="true" { (PreEscaped(PATTERNS)) }
                (header(inputs, &logs))
                (contents(sections))
                main {
                    (summary::summary(inputs))
                    @for section in sections {
                        section id=(section.id) { h2 { (section.title) } (section.body) }
                    }
                }
                footer { "pivot-cal " (env!("CARGO_PKG_VERSION")) }
                div id="tip" role="status" hidden {}
                script type="application/json" id="data" { (data) }
                script { (PreEscaped(SCRIPT)) }
            }
        }
    })
}

/// The log by its name, or how many there are.
fn logs(inputs: &ReportFiles) -> String {
    match &inputs.table1.logs[..] {
        [one] => one.file.clone(),
        many => format!("{} logs", many.len()),
    }
}

fn header(inputs: &ReportFiles, logs: &str) -> Markup {
    let vehicle = &inputs.table1.vehicle;
    let gears: Vec<String> = inputs.table1.maps.iter().map(|m| m.gear.to_string()).collect();
    html! {
        header {
            h1 { "Torque map for turning on the spot" }
            p { (logs) " · wheelbase " (vehicle.wheelbase_m) " m, wheel at " (vehicle.test_angle_deg) "°, " (gears.join(" and ")) }
        }
    }
}

/// Links to the sections.
fn contents(sections: &[Section]) -> Markup {
    html! {
        nav aria-label="Sections" {
            a href="#verdict" { "Verdict" }
            @for section in sections { a href={ "#" (section.id) } { (short_title(section)) } }
        }
    }
}

fn short_title(section: &Section) -> &'static str {
    match section.id {
        "coverage" => "Coverage",
        "delay" => "Delays",
        "friction" => "Friction",
        "next" => "Drive next",
        _ => section.title.split(':').next().unwrap_or(section.title),
    }
}

/// What the script reads, as the text of its element.
fn data(inputs: &ReportFiles, sections: &[Section]) -> Result<Markup> {
    let heats: serde_json::Map<String, serde_json::Value> = sections.iter().flat_map(|s| s.figures.heats.iter().cloned()).collect();
    let data = json!({ "heats": heats, "traces": runs::data(inputs), "viridis": Colours::Viridis.all() });
    Ok(script_text(&serde_json::to_string(&data)?))
}

/// JSON as the text of a script element, where HTML knows no escapes: "</script" would end it, and "<!--" with "<script" would hide its end.
fn script_text(json: &str) -> Markup {
    // in JSON that is only found within strings
    PreEscaped(json.replace('<', "\\u003c"))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::report::section::Figures;

    #[test]
    fn no_text_of_the_data_ends_the_script_and_all_of_it_comes_back() {
        let data = json!({ "log": "<!--<script></script>& \\" });
        let text = script_text(&data.to_string()).into_string();
        assert!(!text.contains('<'), "{text}");
        assert_eq!(serde_json::from_str::<serde_json::Value>(&text).unwrap(), data);
    }

    #[test]
    fn a_link_shows_the_title_up_to_its_colon() {
        let section = |id, title| Section { id, title, body: html! {}, figures: Figures::default() };
        assert_eq!(short_title(&section("table1", "Table 1: acceleration")), "Table 1");
        assert_eq!(short_title(&section("next", "What to drive next")), "Drive next");
    }
}
