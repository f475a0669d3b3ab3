//! Logs on the command line: their paths, their signals, and the vehicle's data.

use crate::calibrate::{LogSource, read_logs, read_operation_logs, survey};
use crate::campaign::Survey;
use crate::cli::Ui;
use crate::cli::listener::UiListener;
use crate::cli::one_of::OneOf;
use crate::cli::text_file::read_file;
use crate::log::{Preset, Recording, SignalMap, Source, VehicleOverrides};
use crate::map::Vehicle;
use crate::text::shown;
use anyhow::Context;
use std::path::{Path, PathBuf};

/// Arguments of every command that reads logs.
#[derive(Debug, Clone, clap::Args)]
pub(crate) struct LogArguments {
    /// Logs (MCAP, CSV, Parquet) of one vehicle, in any order: files, folders of logs, rosbag2 folders, or patterns
    #[arg(required = true, value_name = "LOG")]
    pub(crate) logs: Vec<PathBuf>,
    /// Signal map: which message path is which signal, and where its time is (docs/signals.md)
    #[arg(long, value_name = "FILE", conflicts_with = "preset")]
    pub(crate) signals: Option<PathBuf>,
    /// Signal map that comes with the program: pivot-cal, verify-log, autoware, joint-state
    #[arg(long, value_name = "NAME", value_parser = preset(), hide_possible_values = true)]
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
    /// Stop with status 3 if a log is damaged
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

    /// Places of the signals, from the arguments.
    pub(crate) fn source(&self) -> anyhow::Result<Source> {
        source(self.signals.as_deref(), self.preset)
    }

    /// Data of the vehicle, from the arguments.
    pub(crate) fn overrides(&self) -> VehicleOverrides {
        VehicleOverrides {
            wheelbase_m: self.wheelbase_m,
            wheel_radius_m: self.wheel_radius_m,
            test_angle_deg: self.test_angle_deg,
            torque_limit_nm: None,
            torque_full_scale_nm: None,
        }
    }

    /// Sources of the signals and of the vehicle's data, from the arguments.
    pub(crate) fn log_source(&self) -> anyhow::Result<LogSource> {
        Ok(LogSource { signals: self.source()?, vehicle: self.overrides() })
    }

    /// Reads and surveys every log. A log without usable data is skipped with a warning, unless it is the only one.
    pub(crate) fn survey(&self, ui: Ui) -> anyhow::Result<Vec<Survey>> {
        let listener = UiListener::new(ui, "reading");
        let recordings = read_logs(&self.logs, &self.log_source()?, &|event| listener.hear(event))?;
        Ok(survey(&recordings, &|event| listener.hear(event))?)
    }

    /// Reads and surveys every log of pivots in operation. A log without usable data is an error.
    pub(crate) fn operation(&self, ui: Ui) -> anyhow::Result<Vec<(Recording, Survey)>> {
        let listener = UiListener::new(ui, "reading");
        let recordings = read_operation_logs(&self.logs, &self.log_source()?, &|event| listener.hear(event))?;
        let mut found = Vec::new();
        for recording in recordings {
            let surveys = survey(std::slice::from_ref(&recording), &|event| listener.hear(event))?;
            found.extend(surveys.into_iter().map(|survey| (recording.clone(), survey)));
        }
        Ok(found)
    }
}

/// Parser of the names of the signal maps that come with the program.
pub(crate) fn preset() -> OneOf<Preset> {
    OneOf::new(Preset::ALL.map(Preset::name), |text| text.parse::<Preset>().map_err(|error| error.to_string()))
}

/// Places of the signals, from the options `--signals` and `--preset`.
pub(crate) fn source(signals: Option<&Path>, preset: Option<Preset>) -> anyhow::Result<Source> {
    Ok(match (signals, preset) {
        (Some(path), _) => {
            let text = read_file(path)?;
            Source::Map(SignalMap::from_toml(&text).with_context(|| shown(path))?)
        }
        (None, Some(preset)) => Source::Preset(preset),
        (None, None) => Source::Detect,
    })
}
