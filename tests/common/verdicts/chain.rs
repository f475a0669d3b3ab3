//! A case through the chain of `calibrate`: files of logs → fit → invert → verify, with all checks, on fewer pivots.

use crate::verdicts::Fallible;
use crate::verdicts::case::Case;
use pivot_cal::calibrate::{FitStage, InvertStage, LogSource, fit_logs, invert_folder};
use pivot_cal::log::{SignalMap, Source};
use pivot_cal::map::{Table1File, Table2File};
use pivot_cal::verify::{MapVerdict, Maps, Scenario, VerifySettings, verify};
use std::path::PathBuf;

/// The pivots that are driven: two turns in each direction, one on a slope.
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
/// Where the program ends with an error: the case is refused.
pub(crate) fn calibrated(case: Case) -> Fallible<Made> {
    let folder = tempfile::tempdir()?;
    let (maps, mut paths) = (folder.path().join("maps"), Vec::<PathBuf>::new());
    for (k, log) in case.logs.into_iter().enumerate() {
        let path = folder.path().join(format!("log{}.mcap", k + 1));
        std::fs::write(&path, log.write()?)?;
        paths.push(path);
    }
    let signals = case.signals.as_deref().map(SignalMap::from_toml).transpose()?.map_or(Source::Detect, Source::Map);
    let source = LogSource { signals, vehicle: case.given };
    let fitted = fit_logs(&paths, &maps, &FitStage { source, settings: case.fit, ..FitStage::default() }, &|_| {})?;
    let inversion = invert_folder(&maps, &InvertStage::default(), &|_| {})?;
    let mut table1 = fitted.fit.file;
    if let Some(name) = case.forced_table1_of {
        let other = folder.path().join("other");
        let log = folder.path().join("other.mcap");
        std::fs::write(&log, Case::good(name, case.seed)?.logs.remove(0).write()?)?;
        table1 = fit_logs(&[log], &other, &FitStage::default(), &|_| {})?.fit.file;
        std::fs::copy(other.join("table1.json"), maps.join("table1.json"))?;
    }
    let scenarios = Scenario::all().into_iter().filter(|s| PIVOTS.contains(&s.name.as_str())).collect();
    let settings = VerifySettings { scenarios, draws: case.draws, comparison_draws: 0, ..VerifySettings::new()? };
    let verdict = verify(&Maps::read(&maps, case.forced_table1_of.is_some())?, &settings)?;
    Ok(Made { table1, table2: inversion.file, verdict })
}
