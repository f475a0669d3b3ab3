//! Logs on the command line: where they are, where their signals are, and what is said of the vehicle.

use crate::campaign;
use crate::campaign::{Census, Survey};
use crate::cli::Ui;
use crate::log::{Preset, Recording, SignalMap, Source, VehicleOverrides, find_logs, read_split};
use crate::map::Vehicle;
use crate::signal::Track;
use anyhow::{Context, bail};
use rayon::prelude::*;
use std::path::{Path, PathBuf};

/// Arguments of every command that reads logs.
#[derive(Debug, Clone, clap::Args)]
pub(crate) struct LogArguments {
    /// Logs (MCAP) of one vehicle, in any order: files, folders of logs, rosbag2 folders, or patterns
    #[arg(required = true, value_name = "LOG")]
    pub(crate) logs: Vec<PathBuf>,
    /// Signal map: which message path is which signal
    #[arg(long, value_name = "FILE", conflicts_with = "preset")]
    pub(crate) signals: Option<PathBuf>,
    /// Signal map that comes with the program: pivot-cal, autoware, joint-state
    #[arg(long, value_name = "NAME")]
    pub(crate) preset: Option<Preset>,
    /// Wheelbase [m], over any signal map
    #[arg(long, value_name = "M")]
    wheelbase_m: Option<f64>,
    /// Rolling radius of the front wheel [m], over any signal map
    #[arg(long, value_name = "M")]
    wheel_radius_m: Option<f64>,
    /// Wheel angle of the test [°], left positive, over any signal map
    #[arg(long, value_name = "DEG", allow_negative_numbers = true)]
    test_angle_deg: Option<f64>,
    /// Stop with status 3 when a log is damaged
    #[arg(long)]
    pub(crate) strict: bool,
}

impl LogArguments {
    /// Logs of a vehicle whose geometry is known, from its map.
    pub(crate) fn of_vehicle(logs: &[PathBuf], signals: Option<PathBuf>, preset: Option<Preset>, vehicle: &Vehicle) -> Self {
        Self {
            logs: logs.to_vec(),
            signals,
            preset,
            wheelbase_m: Some(vehicle.wheelbase_m),
            wheel_radius_m: Some(vehicle.wheel_radius_m),
            test_angle_deg: Some(vehicle.test_angle_deg),
            strict: false,
        }
    }

    /// Where the signals are, as the arguments say.
    pub(crate) fn source(&self) -> anyhow::Result<Source> {
        source(self.signals.as_deref(), self.preset)
    }

    /// What the arguments say of the vehicle.
    pub(crate) fn overrides(&self) -> VehicleOverrides {
        VehicleOverrides {
            wheelbase_m: self.wheelbase_m,
            wheel_radius_m: self.wheel_radius_m,
            test_angle_deg: self.test_angle_deg,
            torque_limit_nm: None,
        }
    }

    /// Reads every log; the same log given twice is read once.
    pub(crate) fn read(&self, angle_deg: Option<f64>, ui: Ui) -> anyhow::Result<Vec<Recording>> {
        let source = self.source()?;
        let mut overrides = self.overrides();
        overrides.test_angle_deg = angle_deg.or(overrides.test_angle_deg);
        let mut found = Vec::new();
        for named in &self.logs {
            found.extend(find_logs(named).with_context(|| named.display().to_string())?);
        }
        let total = found.iter().flatten().filter_map(|p| std::fs::metadata(p).ok()).map(|m| m.len()).sum();
        let bar = ui.progress(total, "reading");
        // side by side: the hash of a log takes longer than its messages, and only one thread
        let read: Vec<_> = found.par_iter().map(|files| read_split(files, &source, &overrides, &|bytes| bar.inc(bytes))).collect();
        bar.finish_and_clear();
        let mut recordings: Vec<Recording> = Vec::new();
        for (files, recording) in found.iter().zip(read) {
            let path = place(files);
            let recording = recording.with_context(|| path.display().to_string())?;
            if let Some(same) = recordings.iter().find(|r| r.source.sha256 == recording.source.sha256) {
                ui.warn(format!("{}: the same log as {}; read once", path.display(), same.path.display()));
                continue;
            }
            told(&recording, matches!(source, Source::Map(_)), path, ui);
            recordings.push(recording);
        }
        Ok(recordings)
    }

    /// Reads every log, and tells at which wheel angles its runs were driven.
    pub(crate) fn census(&self, angle_deg: Option<f64>, ui: Ui) -> anyhow::Result<(Vec<Recording>, Census)> {
        let recordings = self.read(angle_deg, ui)?;
        let tracks = recordings
            .iter()
            .map(|r| Track::new(r).with_context(|| r.path.display().to_string()))
            .collect::<anyhow::Result<Vec<Track>>>()?;
        let census = Census::new(&tracks, &campaign::SurveySettings::default());
        Ok((recordings, census))
    }

    /// Reads and surveys every log. A log without anything to use is left aside with a warning, unless it is the only one.
    pub(crate) fn survey(&self, angle_deg: Option<f64>, ui: Ui) -> anyhow::Result<Vec<Survey>> {
        survey(&self.read(angle_deg, ui)?, ui)
    }
}

/// Surveys recordings at their vehicles' test angle. A log without anything to use is left aside with a warning, unless it is the only one.
pub(crate) fn survey(recordings: &[Recording], ui: Ui) -> anyhow::Result<Vec<Survey>> {
    let alone = recordings.len() == 1;
    let mut surveys = Vec::new();
    let mut reasons = Vec::new();
    for recording in recordings {
        let name = recording.path.display();
        let track = Track::new(recording).with_context(|| name.to_string())?;
        match Survey::new(track, &campaign::SurveySettings::default()) {
            Ok(survey) => surveys.push(survey),
            Err(error) if alone => return Err(error).with_context(|| name.to_string()),
            Err(error) => {
                ui.warn(format!("{name} is left aside: {error}"));
                reasons.push(format!("{name}: {error}"));
            }
        }
    }
    if surveys.is_empty() {
        bail!("no log holds anything to use: {}", reasons.join("; "));
    }
    Ok(surveys)
}

/// Where the signals are, as the options `--signals` and `--preset` say.
pub(crate) fn source(signals: Option<&Path>, preset: Option<Preset>) -> anyhow::Result<Source> {
    Ok(match (signals, preset) {
        (Some(path), _) => {
            let text = fs_err::read_to_string(path)?;
            Source::Map(SignalMap::from_toml(&text).with_context(|| path.display().to_string())?)
        }
        (None, Some(preset)) => Source::Preset(preset),
        (None, None) => Source::Detect,
    })
}

/// Where a recording lies: its file, or the folder of its files.
fn place(files: &[PathBuf]) -> &Path {
    match files {
        [file] => file,
        files => files.first().and_then(|file| file.parent()).unwrap_or(Path::new("")),
    }
}

/// Says what was lost, and where the signals were found unless a map said so.
fn told(recording: &Recording, mapped: bool, path: &Path, ui: Ui) {
    if let Some(loss) = recording.loss.summary() {
        ui.warn(format!("{}: {loss}", path.display()));
    }
    for note in &recording.notes {
        ui.detail(format!("{}: {note}", path.display()));
    }
    for origin in &recording.origins {
        let line = format!("{}: {} = {} [{}] ({})", path.display(), origin.signal.key(), origin.path, origin.unit, origin.reason);
        if mapped { ui.detail(line) } else { ui.say(line) }
    }
}
