//! From the files of a map to a page with the verdict on it.
//!
//! In: [`ReportFiles`], the files in a folder of maps. Out: [`Report`]: one HTML page that needs no network, and the same figures as SVG
//! files. The page is drawn here; its script only handles the pointer and the drawings that depend on it. The same files give the same
//! bytes.

mod chart;
mod closed_loop;
mod coverage;
mod delay;
mod error;
mod foreign_table;
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
mod slug;
mod summary;
mod svg;
mod tables;

pub(crate) use coverage::coverage_text;
pub use error::Error;
pub(crate) use error::Result;
pub use inputs::ReportFiles;
pub use page::{Report, report};
