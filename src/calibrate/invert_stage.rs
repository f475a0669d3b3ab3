//! Table 1 → Table 2.

use crate::calibrate::error::{About as _, edited_csv};
use crate::calibrate::folder::read_table1;
use crate::calibrate::{Error, InvertStage, Listener, Result, StageEvent, keep_angles};
use crate::invert::{Inversion, invert};
use crate::map::{CsvRef, FolderWriter, Mismatch};
use std::path::Path;

/// Inverts the `table1.json` in `folder`, and writes `table2.json` and its CSV files beside it.
///
/// # Errors
/// No `table1.json`, wheel angles that it does not hold, a CSV that was edited (unless the stage is forced), a table without an inverse, or
/// a folder that cannot be written.
pub fn invert_folder(folder: &Path, stage: &InvertStage, listen: &Listener) -> Result<Inversion> {
    if !folder.join("table1.json").exists() {
        read_table1(&folder.into())?; // the error
    }
    let mut folder = FolderWriter::open(folder)?;
    let inversion = invert_into(&mut folder, stage, listen)?;
    folder.commit()?;
    Ok(inversion)
}

/// The same, into a folder that is committed later.
pub(crate) fn invert_into(folder: &mut FolderWriter, stage: &InvertStage, listen: &Listener) -> Result<Inversion> {
    let view = folder.view();
    let path = view.path.join("table1.json");
    let (read, mismatches) = read_table1(&view)?;
    let mut file = read.table1;
    if !stage.wheel_angles_deg.is_empty() {
        keep_angles(&mut file, &stage.wheel_angles_deg).in_file(&path)?;
    }
    // the JSON is inverted: a CSV edited by hand differs from it, a missing one is ignored
    let inverted = |csv: &str| file.maps.iter().any(|map| map.csv.file == csv);
    for edited in mismatches.iter().filter(|m| matches!(m, Mismatch::Hash { .. }) && inverted(m.file())) {
        let path = view.path.join(edited.file());
        if !stage.force {
            return Err(Error::EditedCsv { path });
        }
        listen(StageEvent::Warning(format!("{}; the numbers of table1.json are inverted all the same", edited_csv(&path))));
    }
    let table1 = CsvRef { file: "table1.json".to_owned(), sha256: read.table1_json.sha256 };
    let inversion = invert(&file, table1, &stage.settings).in_file(&path)?;
    folder.replaces_csvs_of("table2");
    for (name, text) in &inversion.csvs {
        folder.put(name, text.as_str());
    }
    folder.put("table2.json", inversion.file.to_json()?);
    Ok(inversion)
}
