//! From logs to a verified map in a folder: all stages in one call, and each stage alone.
//!
//! In: logs (MCAP) of one vehicle, and a folder. Out: the files of the map in that folder, as `pivot-cal` writes them. [`calibrate`] does
//! the same as `pivot-cal calibrate`. Its stages are [`fit_logs`], [`invert_folder`], [`verify_folder`] and [`report_folder`]; each reads
//! the files that the previous one has written. A stage reports to a listener by [`StageEvent`]s.

mod error;
mod event;
mod fit_stage;
mod folder;
mod invert_stage;
mod logs;
mod report_stage;
mod settings;
mod verify_stage;
mod wheel_angles;

pub use error::{Error, Result};
pub(crate) use event::Listener;
pub use event::StageEvent;
pub use fit_stage::{FittedLogs, fit_logs};
pub(crate) use folder::read_table1;
pub use invert_stage::invert_folder;
pub(crate) use logs::read_operation_logs;
pub use logs::{read_logs, survey};
pub(crate) use report_stage::report_with;
pub use report_stage::{WrittenReport, report_folder};
pub use settings::{CalibrateSettings, FitStage, InvertStage, LogSource};
pub(crate) use verify_stage::put_verdict;
pub use verify_stage::verify_folder;
pub(crate) use wheel_angles::{keep_angles, only_angle};

use crate::calibrate::fit_stage::fit_into;
use crate::calibrate::invert_stage::invert_into;
use crate::calibrate::report_stage::report_into;
use crate::calibrate::verify_stage::verify_into;
use crate::invert::Inversion;
use crate::map::FolderWriter;
use crate::verify::MapVerdict;
use std::path::{Path, PathBuf};

/// A map that was made, judged and written.
#[derive(Debug)]
pub struct Calibrated {
    /// Table 1, and whether it is sound.
    pub fitted: FittedLogs,
    /// Table 2.
    pub inversion: Inversion,
    /// The verdict in closed loop.
    pub verdict: MapVerdict,
}

impl Calibrated {
    /// Whether the map passed. An objection to Table 1 that nobody has overruled rejects it.
    pub fn passes(&self) -> bool {
        self.verdict.passes()
    }
}

/// Makes a map from `logs` and judges it: fits, inverts, verifies, and writes the report. Everything goes into `folder`, together at the end: until
/// then, and after an error, the folder holds what it held.
///
/// A log may be a file, a folder of logs, a rosbag2 folder, or a pattern. A log without usable data is skipped and reported to `listen`.
///
/// # Errors
/// Logs that cannot be read, no usable log, a fit that is impossible, a folder that cannot be written or that another process is writing into. A map that fails its verification is
/// not an error: see [`Calibrated::passes`].
pub fn calibrate_with(logs: &[PathBuf], folder: &Path, settings: &CalibrateSettings, listen: &Listener) -> Result<Calibrated> {
    let mut folder = FolderWriter::open(folder)?;
    let fitted = fit_into(&mut folder, logs, &settings.fit, listen)?;
    let inversion = invert_into(&mut folder, &settings.invert, listen)?;
    let verdict = verify_into(&mut folder, &settings.accept, settings.controller.as_ref(), listen)?;
    report_into(&mut folder)?;
    folder.commit()?;
    Ok(Calibrated { fitted, inversion, verdict })
}

/// [`calibrate_with`] without a listener.
///
/// # Errors
/// As [`calibrate_with`].
pub fn calibrate(logs: &[PathBuf], folder: &Path, settings: &CalibrateSettings) -> Result<Calibrated> {
    calibrate_with(logs, folder, settings, &|_| {})
}
