//! Table 2 → verdict.

use crate::calibrate::{Listener, Result, StageEvent};
use crate::controller::ControllerFile;
use crate::map::FolderWriter;
use crate::verify::{ClosedLoop, MapVerdict, Maps, Verified, VerifySettings, Wanted, verify_with};
use std::path::Path;

/// Judges the map in `folder` with the defaults, and writes `verify.json` and `verify_traces.json` there.
///
/// # Errors
/// Files that are missing or do not belong together, a plant that cannot be simulated, a folder that cannot be written.
pub fn verify_folder(folder: &Path, listen: &Listener) -> Result<MapVerdict> {
    if !folder.exists() {
        Maps::read(folder, false)?; // the error
    }
    let mut folder = FolderWriter::open(folder)?;
    let verdict = verify_into(&mut folder, &[], None, listen)?;
    folder.commit()?;
    Ok(verdict)
}

/// The same, into a folder that is committed later; the objections of the checks named in `accept` are overruled, and
/// `controller` drives instead of the default.
///
/// # Errors
/// As [`verify_folder`], and a name that no check has.
pub(crate) fn verify_into(
    folder: &mut FolderWriter,
    accept: &[String],
    controller: Option<&ControllerFile>,
    listen: &Listener,
) -> Result<MapVerdict> {
    let maps = Maps::read_from(&folder.view(), false)?;
    let usual = VerifySettings::new()?;
    let controller = controller.cloned().unwrap_or_else(|| usual.controller.clone());
    let settings = VerifySettings { accept: accept.to_vec(), controller, ..usual };
    let progress = |total| listen(StageEvent::Simulated { total });
    let wanted = Wanted { traces: true, logs: false, worst_logs: false, progress: Some(&progress) };
    let Verified { verdict, traces, .. } = verify_with(&maps, &settings, wanted)?;
    listen(StageEvent::Complete);
    put_verdict(&verdict, traces.as_ref(), folder)?;
    Ok(verdict)
}

/// `verify.json`, and the traces of the comparison beside it for the report.
///
/// # Errors
/// None in practice; serialisation is fallible by its signature.
pub(crate) fn put_verdict(verdict: &MapVerdict, traces: Option<&ClosedLoop>, folder: &mut FolderWriter) -> Result<()> {
    folder.put("verify.json", verdict.to_json()?);
    match traces {
        Some(traces) => folder.put("verify_traces.json", traces.to_json()?),
        // those of an earlier verdict would be taken for its own
        None => folder.removes("verify_traces.json"),
    }
    Ok(())
}
