//! Logs → Table 1.

use crate::calibrate::error::About as _;
use crate::calibrate::wheel_angles::{AngleChoice, choose_angles};
use crate::calibrate::{FitStage, Listener, LogSource, Result, read_logs, survey};
use crate::campaign::{Census, SurveySettings};
use crate::fit::{Fit, fit_angles, fit_traced};
use crate::log::{Recording, VehicleOverrides};
use crate::map::{FitTraces, FolderWriter};
use crate::signal::Track;
use std::path::{Path, PathBuf};

/// Table 1, fitted and written.
#[derive(Debug)]
pub struct FittedLogs {
    /// Table 1 with its files.
    pub fit: Fit,
    /// Whether a log was damaged.
    pub is_damaged: bool,
}

/// Fits Table 1 to `logs` and writes it into `folder`: `table1.json`, its CSV files, and `fit_traces.json`.
///
/// # Errors
/// Logs that cannot be read, no usable log, wheel angles at which no run was driven, a fit that is impossible, a folder that cannot be written
/// or that another process is writing into.
pub fn fit_logs(logs: &[PathBuf], folder: &Path, stage: &FitStage, listen: &Listener) -> Result<FittedLogs> {
    let mut folder = FolderWriter::open(folder)?;
    let fitted = fit_into(&mut folder, logs, stage, listen)?;
    folder.commit()?;
    Ok(fitted)
}

/// The same, into a folder that is committed later.
pub(crate) fn fit_into(folder: &mut FolderWriter, logs: &[PathBuf], stage: &FitStage, listen: &Listener) -> Result<FittedLogs> {
    let recordings = read_logs(logs, &source(stage), listen)?;
    let census = census(&recordings)?;
    let several = choose_angles(&recordings, &census, &stage.wheel_angles_deg, listen)?;
    let (fit, traces) = if let Some(AngleChoice { grouped, test_angle_deg }) = several {
        fit_angles(grouped, !stage.wheel_angles_deg.is_empty(), test_angle_deg, &stage.settings)?
    } else {
        let surveys = survey(&recordings, listen).about(|| format!("wheel angles of the runs: {}", census.text()))?;
        fit_traced(surveys, &stage.settings)?
    };
    put(&fit, &traces, folder)?;
    Ok(FittedLogs { fit, is_damaged: recordings.iter().any(|r| r.loss.is_damaged()) })
}

/// A single requested wheel angle is the test angle of the fit.
fn source(stage: &FitStage) -> LogSource {
    let mut source = stage.source.clone();
    if let [angle_deg] = stage.wheel_angles_deg[..] {
        source.vehicle = VehicleOverrides { test_angle_deg: Some(angle_deg), ..source.vehicle };
    }
    source
}

/// The wheel angles at which the runs were driven.
fn census(recordings: &[Recording]) -> Result<Census> {
    let tracks: Vec<Track> = recordings.iter().map(|r| Track::new(r).in_file(&r.path)).collect::<Result<_>>()?;
    Ok(Census::new(&tracks, &SurveySettings::default()))
}

fn put(fit: &Fit, traces: &FitTraces, folder: &mut FolderWriter) -> Result<()> {
    folder.replaces_csvs_of("table1");
    for (name, text) in &fit.csvs {
        folder.put(name, text.as_str());
    }
    folder.put("table1.json", fit.file.to_json()?);
    folder.put("fit_traces.json", traces.to_json()?);
    Ok(())
}
