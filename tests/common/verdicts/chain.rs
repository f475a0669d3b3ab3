//! A case through the chain of `calibrate`: files of logs → fit → invert → verify, with all checks, on fewer pivots.

use crate::verdicts::Fallible;
use crate::verdicts::case::Case;
use pivot_cal::calibrate::{FitStage, InvertStage, LogSource, fit_logs, invert_folder};
use pivot_cal::log::{SignalMap, Source};
use pivot_cal::map::{Table1File, Table2File};
use pivot_cal::verify::{MapVerdict, Maps, Scenario, VerifySettings, verify};
use std::path::{Path, PathBuf};

/// The pivots that are driven: a turn in each direction.
const PIVOTS: [&str; 2] = ["left-90", "right-90"];

/// A map and its verdict.
pub(crate) struct Made {
    pub(crate) table1: Table1File,
    pub(crate) table2: Table2File,
    pub(crate) verdict: MapVerdict,
}

/// Makes the map of a case and judges it as the program does.
///
/// # Errors
/// Where the program ends with an error: the case is refused. The error is one line, with its causes and without the folder's name.
pub(crate) fn calibrated(case: Case) -> Fallible<Made> {
    let folder = tempfile::tempdir()?;
    let place = format!("{}/", folder.path().display());
    made_in(folder.path(), case).map_err(|error| with_causes(&*error).replace(&place, "").into())
}

fn made_in(folder: &Path, case: Case) -> Fallible<Made> {
    let (maps, mut paths) = (folder.join("maps"), Vec::<PathBuf>::new());
    for (k, log) in case.logs.into_iter().enumerate() {
        let path = folder.join(format!("log{}.mcap", k + 1));
        std::fs::write(&path, log.write()?)?;
        paths.push(path);
    }
    let signals = case.signals.as_deref().map(SignalMap::from_toml).transpose()?.map_or(Source::Detect, Source::Map);
    let source = LogSource { signals, vehicle: case.given };
    let fitted = fit_logs(&paths, &maps, &FitStage { source, settings: case.fit, ..FitStage::default() }, &|_| {})?;
    let inversion = invert_folder(&maps, &InvertStage::default(), &|_| {})?;
    let mut table1 = fitted.fit.file;
    if let Some(name) = case.forced_table1_of {
        let other = folder.join("other");
        let log = folder.join("other.mcap");
        std::fs::write(&log, Case::good(name, case.seed)?.logs.remove(0).write()?)?;
        table1 = fit_logs(&[log], &other, &FitStage::default(), &|_| {})?.fit.file;
        std::fs::copy(other.join("table1.json"), maps.join("table1.json"))?;
    }
    let scenarios = Scenario::all().into_iter().filter(|s| PIVOTS.contains(&s.name.as_str())).collect();
    let settings = VerifySettings { scenarios, draws: case.draws, comparison_draws: 0, ..VerifySettings::new()? };
    let verdict = verify(&Maps::read(&maps, case.forced_table1_of.is_some())?, &settings)?;
    Ok(Made { table1, table2: inversion.file, verdict })
}

/// An error with its causes, in one line.
fn with_causes(error: &(dyn std::error::Error + 'static)) -> String {
    let causes = std::iter::successors(Some(error), |e| e.source());
    let mut lines: Vec<String> = causes.map(|e| e.to_string().lines().next().unwrap_or_default().to_owned()).collect();
    // some errors are worded with their cause
    lines.dedup_by(|cause, error| error.ends_with(cause.as_str()));
    lines.join(": ")
}
