//! The files of a map → the page with the verdict on it.

use crate::calibrate::Result;
use crate::import::ImportedMap;
use crate::map::{FolderLock, FolderWriter, write_whole};
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
/// No `table1.json`, an existing file that cannot be read, a page that cannot be written, or another process that writes into the folder
/// while the page is to be there.
pub fn report_folder(folder: &Path, output: &Path, svg: Option<&Path>) -> Result<WrittenReport> {
    report_with(folder, output, svg, None)
}

/// The same with the tables of a file that came back in place of Table 2: its path and what was read of it.
///
/// # Errors
/// As [`report_folder`]; tables that Table 1 cannot describe.
pub(crate) fn report_with(folder: &Path, output: &Path, svg: Option<&Path>, table: Option<(&Path, &ImportedMap)>) -> Result<WrittenReport> {
    // a page among the files of the map must not be of other files than those there
    let is_inside = output.parent() == Some(folder) && folder.is_dir();
    let _lock = is_inside.then(|| FolderLock::take(folder)).transpose()?;
    let files = if is_inside { ReportFiles::read_own(folder)? } else { ReportFiles::read(folder)? };
    let files = match table {
        Some((path, imported)) => files.with_table(path, imported)?,
        None => files,
    };
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

/// The page among the files of a folder that is committed later.
pub(crate) fn report_into(folder: &mut FolderWriter) -> Result<()> {
    let page = report(&ReportFiles::read_from(&folder.view())?)?;
    folder.put("report.html", page.html);
    Ok(())
}
