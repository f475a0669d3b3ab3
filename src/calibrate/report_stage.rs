//! The files of a map → the page with the verdict on it.

use crate::calibrate::Result;
use crate::map::write_whole;
use crate::report::{ReportFiles, report};
use std::path::Path;

/// A page that was written.
#[derive(Debug)]
pub struct WrittenReport {
    /// Its inputs.
    pub files: ReportFiles,
    /// Its size.
    pub bytes: usize,
    /// Names of its figures.
    pub figures: Vec<String>,
}

/// Writes the page of the map in `folder` to `output`, and its figures as SVG files into the folder `svg`, if there is one.
///
/// # Errors
/// No `table1.json`, an existing file that cannot be read, or a page that cannot be written.
pub fn report_folder(folder: &Path, output: &Path, svg: Option<&Path>) -> Result<WrittenReport> {
    let files = ReportFiles::read(folder)?;
    let page = report(&files)?;
    write_whole(output, page.html.as_bytes())?;
    let mut figures = Vec::new();
    for (name, text) in &page.pictures {
        if let Some(svg) = svg {
            write_whole(&svg.join(format!("{name}.svg")), text.as_bytes())?;
        }
        figures.push(name.clone());
    }
    Ok(WrittenReport { files, bytes: page.html.len(), figures })
}
