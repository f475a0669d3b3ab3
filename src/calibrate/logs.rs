//! Logs of one vehicle, read and surveyed.

use crate::calibrate::error::About as _;
use crate::calibrate::{Error, Listener, LogSource, Result, StageEvent};
use crate::campaign::{Survey, SurveySettings};
use crate::log::{MOST_VALUES, Recording, SignalName, Source, find_logs, read_split};
use crate::signal::Track;
use crate::text::shown;
use rayon::prelude::*;
use std::path::{Path, PathBuf};

/// Reads every log; the same log given twice is read once. Losses, and the places of the signals, are reported to `listen`.
///
/// # Errors
/// A log that is missing or cannot be read.
pub fn read_logs(logs: &[PathBuf], source: &LogSource, listen: &Listener) -> Result<Vec<Recording>> {
    read_signals_of(logs, &SignalName::ALL, source, listen)
}

/// Like [`read_logs`], with the desired acceleration of pivots in operation.
///
/// # Errors
/// As [`read_logs`].
pub(crate) fn read_operation_logs(logs: &[PathBuf], source: &LogSource, listen: &Listener) -> Result<Vec<Recording>> {
    read_signals_of(logs, &SignalName::OPERATION, source, listen)
}

fn read_signals_of(logs: &[PathBuf], wanted: &[SignalName], source: &LogSource, listen: &Listener) -> Result<Vec<Recording>> {
    let mut found = Vec::new();
    for named in logs {
        found.extend(find_logs(named).in_file(named)?);
    }
    let total = found.iter().flatten().filter_map(|p| std::fs::metadata(p).ok()).map(|m| m.len()).sum();
    let read_one = |files: &Vec<PathBuf>| {
        read_split(files, wanted, &source.signals, &source.vehicle, &|bytes| listen(StageEvent::Read { bytes, total }))
    };
    // in parallel: the hash of a log takes longer than its messages, and uses only one thread
    let read: Vec<_> = found.par_iter().map(read_one).collect();
    listen(StageEvent::Complete);
    let mut recordings: Vec<Recording> = Vec::new();
    let mut values = 0;
    for (files, recording) in found.iter().zip(read) {
        let path = place(files);
        let recording = recording.in_file(path)?;
        if let Some(same) = recordings.iter().find(|r| r.source.sha256 == recording.source.sha256) {
            listen(StageEvent::Warning(format!("{}: the same log as {}; read once", shown(path), shown(&same.path))));
            continue;
        }
        values += recording.values();
        if values > MOST_VALUES {
            return Err(crate::log::Error::TooManyValues { allowed: MOST_VALUES }).about(|| "all logs together".to_owned());
        }
        report(&recording, matches!(source.signals, Source::Map(_)), path, listen);
        recordings.push(recording);
    }
    Ok(recordings)
}

/// Surveys recordings at their vehicles' test angle. A log without usable data is skipped with a warning, unless it is the only one.
///
/// # Errors
/// Signals from which no track can be made; no usable log.
pub fn survey(recordings: &[Recording], listen: &Listener) -> Result<Vec<Survey>> {
    let alone = recordings.len() == 1;
    let mut surveys = Vec::new();
    let mut reasons = Vec::new();
    for recording in recordings {
        let path = &recording.path;
        let track = Track::new(recording).in_file(path)?;
        match Survey::new(track, &SurveySettings::default()) {
            Ok(survey) => surveys.push(survey),
            Err(error) if alone => return Err(error).in_file(path),
            Err(error) => {
                listen(StageEvent::Warning(format!("{} is skipped: {error}", shown(path))));
                reasons.push(format!("{}: {error}", shown(path)));
            }
        }
    }
    if surveys.is_empty() {
        return Err(Error::NoUsableLog { reasons: reasons.join("; ") });
    }
    Ok(surveys)
}

/// Path of a recording: its file, or the folder of its files.
fn place(files: &[PathBuf]) -> &Path {
    match files {
        [file] => file,
        files => files.first().and_then(|file| file.parent()).unwrap_or(Path::new("")),
    }
}

/// Reports losses, and the places of the signals if no signal map gave them.
fn report(recording: &Recording, mapped: bool, path: &Path, listen: &Listener) {
    if let Some(loss) = recording.loss.summary() {
        listen(StageEvent::Warning(format!("{}: {loss}", shown(path))));
    }
    for note in &recording.notes {
        listen(StageEvent::Detail(format!("{}: {note}", shown(path))));
    }
    for origin in &recording.origins {
        let line = format!("{}: {} = {} [{}] ({})", shown(path), origin.signal.key(), origin.path, origin.unit, origin.reason);
        listen(if mapped { StageEvent::Detail(line) } else { StageEvent::Note(line) });
    }
}
