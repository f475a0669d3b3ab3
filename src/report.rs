//! From the files of a map to a page that says whether to deploy it.
//!
//! In: [`ReportFiles`], what a folder of maps holds. Out: [`Report`]: one HTML page that needs no network, and the same figures as SVG files. The
//! page is drawn here; its script only answers the pointer and draws what depends on it. The same files give the same bytes.

mod chart;
mod closed_loop;
mod coverage;
mod delay;
mod error;
mod friction;
mod heat;
mod html;
mod inputs;
#[cfg(test)]
mod known;
mod manoeuvres;
mod next;
mod overhead;
mod page;
mod provenance;
mod residuals;
mod round_trip;
mod runs;
mod scale;
mod section;
mod summary;
mod svg;
mod tables;

pub use coverage::coverage_text;
pub use error::{Error, Result};
pub use inputs::{Judgement, ReportFiles};
pub use page::{Report, report};
