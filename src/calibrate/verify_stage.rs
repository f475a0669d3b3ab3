//! Table 2 → verdict.

use crate::calibrate::{Listener, Result, StageEvent};
use crate::map::write_whole;
use crate::verify::{ClosedLoop, MapVerdict, Maps, Verified, VerifySettings, Wanted, verify_with};
use std::path::Path;

/// Judges the map in `folder` with the defaults, and writes `verify.json` and `verify_traces.json` there.
///
/// # Errors
/// Files that are missing or do not belong together, a plant that cannot be simulated, a folder that cannot be written.
pub fn verify_folder(folder: &Path, listen: &Listener) -> Result<MapVerdict> {
    verify_accepting(folder, &[], listen)
}

/// As [`verify_folder`]; the objections of the checks named in `accept` are overruled.
///
/// # Errors
/// As [`verify_folder`], and a name that no check has.
pub(crate) fn verify_accepting(folder: &Path, accept: &[String], listen: &Listener) -> Result<MapVerdict> {
    let maps = Maps::read(folder, false)?;
    let settings = VerifySettings { accept: accept.to_vec(), ..VerifySettings::new()? };
    let progress = |total| listen(StageEvent::Simulated { total });
    let wanted = Wanted { traces: true, logs: false, worst_logs: false, progress: Some(&progress) };
    let Verified { verdict, traces, .. } = verify_with(&maps, &settings, wanted)?;
    listen(StageEvent::Complete);
    save_verdict(&verdict, traces.as_ref(), folder)?;
    Ok(verdict)
}

/// Writes `verify.json`, and the traces of the comparison beside it for the report.
///
/// # Errors
/// A folder that cannot be written.
pub(crate) fn save_verdict(verdict: &MapVerdict, traces: Option<&ClosedLoop>, folder: &Path) -> Result<()> {
    write_whole(&folder.join("verify.json"), verdict.to_json()?.as_bytes())?;
    let path = folder.join("verify_traces.json");
    match traces {
        Some(traces) => write_whole(&path, traces.to_json()?.as_bytes())?,
        // those of an earlier verdict would be taken for its own
        None if path.exists() => fs_err::remove_file(path)?,
        None => {}
    }
    Ok(())
}
