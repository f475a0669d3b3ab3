//! `lateral`: runs of the lateral calibration on a simulated vehicle, and the compensation table from logs.

use crate::cli::Ui;
use crate::cli::logs::LogArguments;
use crate::cli::outcome::Outcome;
use crate::cli::text_file::read_file;
use crate::guidance::route::follower::DriveStage;
use crate::guidance::route::tracking::LawName;
use crate::lateral::{LateralFitSettings, Weighting, fit};
use crate::log::{Recording, SignalName, find_logs, read_lateral};
use crate::manoeuvre::{CalibrationDrive, LoggedReference, Mounting, lateral_log};
use crate::map::{FolderWriter, LateralTableFile, write_whole};
use crate::sim::VehicleFile;
use crate::text::shown;
use crate::units::RAD_PER_DEG;
use anyhow::{Context, bail};
use comfy_table::{ContentArrangement, Table, presets};
use std::path::PathBuf;

/// Arguments of `lateral`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Example: the compensation table of a simulated vehicle with small mounting errors of navigation and steering
  pivot-cal lateral record --vehicle data/vehicles/scrubber.toml -o lateral_logs
  pivot-cal lateral fit lateral_logs
  pivot-cal verify --scenario lateral-forward -v")]
pub(crate) struct Arguments {
    #[command(subcommand)]
    action: Action,
}

#[derive(Debug, clap::Subcommand)]
enum Action {
    /// Fit the compensation table to logs: one without compensation, the others with one known angle each
    Fit(FitArguments),
    /// Drive the task with known compensation angles on a simulated vehicle and write one log per angle
    Record(RecordArguments),
}

#[derive(Debug, clap::Args)]
#[command(after_help = "\
Example: signals.toml names pose, reference and compensation
  [signals]
  pose_x       = { path = \"/odom.pose.pose.position.x\" }
  pose_y       = { path = \"/odom.pose.pose.position.y\" }
  yaw          = { path = \"/navigation/yaw.data\", unit = \"rad\" }   # or yaw_z and yaw_w of a quaternion
  reference_x  = { path = \"/reference/matched_point.point.x\" }
  reference_y  = { path = \"/reference/matched_point.point.y\" }
  compensation = { path = \"/steering/compensation.data\", unit = \"rad\" }

The reference may also be a whole path (nav_msgs/Path, or arrays of another message); its nearest point is then computed:
  reference_x  = { path = \"/reference/path.poses[:].pose.position.x\" }
  reference_y  = { path = \"/reference/path.poses[:].pose.position.y\" }

  pivot-cal lateral fit base.mcap plus_1deg.mcap minus_1deg.mcap --signals signals.toml

Exit status: 0 done, 1 error, 3 a log is damaged and --strict was given.")]
struct FitArguments {
    #[command(flatten)]
    logs: LogArguments,
    /// Folder for lateral_table.csv and lateral_table.json
    #[arg(long, value_name = "DIR", default_value = "maps")]
    maps: PathBuf,
    /// Entries at or beyond this mean error are dropped [m]
    #[arg(long, value_name = "M", default_value_t = 0.3)]
    threshold_m: f64,
    /// Distance after every start that is skipped [m]
    #[arg(long, value_name = "M", default_value_t = 4.0)]
    settle_m: f64,
    /// Take means over control periods instead of distance
    #[arg(long)]
    over_periods: bool,
}

#[derive(Debug, clap::Args)]
#[command(after_help = "\
Example: seven logs, from −3° to 3°
  pivot-cal lateral record --vehicle data/vehicles/scrubber.toml -o lateral_logs")]
struct RecordArguments {
    /// Vehicle to simulate (TOML)
    #[arg(long, value_name = "FILE")]
    vehicle: PathBuf,
    /// Folder for the logs
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// Compensation angles [°], separated by commas; 0, the base, is always driven
    #[arg(long, value_name = "LIST", value_delimiter = ',', default_value = "-3,-2,-1,1,2,3", allow_hyphen_values = true)]
    angles_deg: Vec<f64>,
    /// Tracking law: pure-pursuit, front-axle, rear-axle, lqr, mpc
    #[arg(long, value_name = "NAME", default_value = "lqr")]
    law: LawName,
    /// Heading of the navigation minus that of the vehicle [°]
    #[arg(long, value_name = "DEG", default_value_t = 1.0, allow_negative_numbers = true)]
    yaw_deg: f64,
    /// True wheel angle minus the one that the steering reports [°]
    #[arg(long, value_name = "DEG", default_value_t = -0.8, allow_negative_numbers = true)]
    steering_zero_deg: f64,
    /// Form of the reference in the log: its matched point every period, the whole path once, or both
    #[arg(long, value_enum, value_name = "FORM", default_value_t = Reference::Both)]
    reference: Reference,
    /// Seed of everything random
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
}

#[derive(Debug, Clone, Copy, clap::ValueEnum)]
enum Reference {
    Point,
    Path,
    Both,
}

pub(crate) fn run(arguments: &Arguments, ui: Ui) -> anyhow::Result<Outcome> {
    match &arguments.action {
        Action::Fit(arguments) => fit_table(arguments, ui),
        Action::Record(arguments) => record(arguments, ui),
    }
}

fn fit_table(arguments: &FitArguments, ui: Ui) -> anyhow::Result<Outcome> {
    let recordings = read(&arguments.logs, ui)?;
    let damaged = recordings.iter().any(|r| r.loss.is_damaged());
    let settings = LateralFitSettings {
        threshold_m: arguments.threshold_m,
        settle_m: arguments.settle_m,
        weighting: if arguments.over_periods { Weighting::Periods } else { Weighting::Distance },
        ..LateralFitSettings::default()
    };
    let (file, report) = fit(&recordings, &settings)?;
    let (csv, json) = (arguments.maps.join("lateral_table.csv"), arguments.maps.join("lateral_table.json"));
    let mut folder = FolderWriter::open(&arguments.maps)?;
    folder.put("lateral_table.csv", file.to_csv());
    folder.put("lateral_table.json", file.to_json()?);
    folder.commit()?;
    ui.document(&file)?;
    show(&file, ui);
    ui.detail(format!("largest correction to make the curve monotone: {:.1} standard errors", report.largest_correction));
    ui.say(format!("slope: {:.3}° per 10 mm", 0.01 * report.slope_rad_per_m / RAD_PER_DEG));
    ui.say(format!("written: {}, {}", shown(&csv), shown(&json)));
    Ok(if damaged && arguments.logs.strict { Outcome::Rejected } else { Outcome::Done })
}

fn read(arguments: &LogArguments, ui: Ui) -> anyhow::Result<Vec<Recording>> {
    let (source, overrides) = (arguments.source()?, arguments.overrides());
    let mut recordings: Vec<Recording> = Vec::new();
    for named in &arguments.logs {
        for path in find_logs(named).with_context(|| shown(named))?.into_iter().flatten() {
            let recording = read_lateral(&path, &source, &overrides, &|_| {}).with_context(|| shown(&path))?;
            if let Some(same) = recordings.iter().find(|r| r.source.sha256 == recording.source.sha256) {
                ui.warn(format!("{}: the same log as {}; read once", shown(&path), shown(&same.path)));
                continue;
            }
            if let Some(loss) = recording.loss.summary() {
                ui.warn(format!("{}: {loss}", shown(&path)));
            }
            for origin in &recording.origins {
                let place = format!("{} = {} [{}] ({})", origin.signal.key(), origin.path, origin.unit, origin.reason);
                ui.detail(format!("{}: {place}", shown(&path)));
            }
            if !recording.signals.lateral.contains_key(&SignalName::Compensation) {
                ui.warn(format!("{}: no compensation signal: taken as the run without compensation", shown(&path)));
            }
            recordings.push(recording);
        }
    }
    Ok(recordings)
}

fn show(file: &LateralTableFile, ui: Ui) {
    ui.say(format!(
        "without compensation: mean lateral error {:.2} ± {:.2} mm over {} m",
        1e3 * file.base.mean_error_m,
        1e3 * file.base.std_err_m,
        file.base.way_m
    ));
    let mut table = Table::new();
    table.load_style(presets::UTF8_FULL_CONDENSED).set_content_arrangement(ContentArrangement::Disabled);
    table.set_header(vec!["compensation", "adds", "± (1 std. err.)", "log", ""]);
    for entry in file.entries.iter().chain(&file.dropped) {
        table.add_row([
            format!("{:.3}°", entry.angle_rad / RAD_PER_DEG),
            format!("{:.2} mm", 1e3 * entry.error_m),
            format!("{:.2} mm", 1e3 * entry.std_err_m),
            entry.log.clone(),
            if entry.reason.is_empty() { String::new() } else { format!("dropped: {}", entry.reason) },
        ]);
    }
    ui.say(table.to_string());
}

fn record(arguments: &RecordArguments, ui: Ui) -> anyhow::Result<Outcome> {
    let text = read_file(&arguments.vehicle)?;
    let vehicle = VehicleFile::from_toml(&text).with_context(|| shown(&arguments.vehicle))?.settings();
    if let Some(angle) = arguments.angles_deg.iter().find(|a| !(a.is_finite() && a.abs() <= 20.0)) {
        bail!("--angles-deg: {angle}° is not a compensation; allowed: −20° to 20°");
    }
    for (name, value) in [("--yaw-deg", arguments.yaw_deg), ("--steering-zero-deg", arguments.steering_zero_deg)] {
        if !(value.is_finite() && value.abs() <= 20.0) {
            bail!("{name} is {value}°; allowed: −20° to 20°");
        }
    }
    let mut angles_deg: Vec<f64> = std::iter::once(0.0).chain(arguments.angles_deg.iter().copied()).collect();
    angles_deg.sort_by(f64::total_cmp);
    angles_deg.dedup();
    let mounting = Mounting { yaw_rad: arguments.yaw_deg * RAD_PER_DEG, steering_zero_rad: arguments.steering_zero_deg * RAD_PER_DEG };
    let reference = match arguments.reference {
        Reference::Point => LoggedReference::Point,
        Reference::Path => LoggedReference::Path,
        Reference::Both => LoggedReference::Both,
    };
    let mut written = Vec::new();
    if arguments.output.as_os_str() == "-" {
        bail!("-o - is standard output, and there are several logs; give a folder");
    }
    for (k, angle_deg) in angles_deg.iter().enumerate() {
        let run = CalibrationDrive {
            law: arguments.law,
            compensation_rad: angle_deg * RAD_PER_DEG,
            mounting,
            seed: arguments.seed.wrapping_mul(1000).wrapping_add(k as u64),
        };
        let (bytes, stage) = lateral_log(&vehicle, &run, reference)?;
        if stage != DriveStage::Arrived {
            bail!("with a compensation of {angle_deg}° the vehicle does not reach the end of the task ({stage:?}); drive smaller angles");
        }
        let name = if *angle_deg == 0.0 { "base.mcap".to_owned() } else { format!("compensation_{angle_deg:+}deg.mcap") };
        let path = arguments.output.join(name);
        write_whole(&path, &bytes)?;
        ui.say(format!("written: {} ({} bytes)", shown(&path), bytes.len()));
        written.push(serde_json::json!({ "file": shown(&path), "angle_deg": angle_deg, "bytes": bytes.len() }));
    }
    ui.document(&written)?;
    Ok(Outcome::Done)
}
