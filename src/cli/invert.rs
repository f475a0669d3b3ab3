//! `invert`: Table 2 from Table 1.

use crate::calibrate::{InvertStage, invert_folder};
use crate::cli::Ui;
use crate::cli::advice::with_advice;
use crate::cli::breaks::Breaks;
use crate::cli::listener::UiListener;
use crate::cli::outcome::Outcome;
use crate::invert::{InvertSettings, ZeroRow};
use crate::map::{FixedText as _, Table2File};
use std::path::PathBuf;

/// Arguments of `invert`.
#[derive(Debug, Clone, clap::Args)]
#[command(after_help = "\
Examples:
  pivot-cal invert
  pivot-cal invert --speed-breaks 0:0.1:1.1 --accel-breaks=-2,-1,-0.5,0,0.5,1
  pivot-cal invert --place 12 --zero-row hold

Reads table1.json and writes table2.csv and table2.json (and table2.reverse.csv, table2.angle30.csv, …) into the same folder.")]
pub(crate) struct Arguments {
    /// Folder with table1.json
    #[arg(long, value_name = "DIR", default_value = "maps")]
    pub(crate) maps: PathBuf,
    /// Speed breaks [m/s]: start:step:stop or a list
    #[arg(long, value_name = "BREAKS")]
    pub(crate) speed_breaks: Option<Breaks>,
    /// Breaks of the desired acceleration [m/s²]: start:step:stop or a list
    #[arg(long, value_name = "BREAKS", allow_hyphen_values = true)]
    pub(crate) accel_breaks: Option<Breaks>,
    /// Place this many breaks on each axis at the best places
    #[arg(long, value_name = "N")]
    pub(crate) place: Option<usize>,
    /// The row at speed 0: torque of a wheel just moving, or 0 for a ≤ 0
    #[arg(long, value_name = "ROW", value_parser = zero_row, default_value = "moving")]
    pub(crate) zero_row: ZeroRow,
    /// Exact at the nodes instead of best over the whole
    #[arg(long)]
    pub(crate) node_exact: bool,
    /// Wheel angles whose maps are inverted [°]; by default all of table1.json
    #[arg(long, value_name = "DEG,…", value_delimiter = ',', allow_hyphen_values = true)]
    pub(crate) angle: Vec<f64>,
    /// Continue if a hash does not match
    #[arg(long)]
    pub(crate) force: bool,
}

fn zero_row(text: &str) -> Result<ZeroRow, String> {
    ZeroRow::from_name(text).map_err(|_| format!("{text:?} is not known; allowed: moving, hold"))
}

pub(crate) fn run(arguments: &Arguments, ui: Ui) -> anyhow::Result<Outcome> {
    let stage = InvertStage {
        wheel_angles_deg: arguments.angle.clone(),
        settings: InvertSettings {
            speed_breaks_mps: arguments.speed_breaks.clone().map(|b| b.0),
            accel_breaks_mps2: arguments.accel_breaks.clone().map(|b| b.0),
            place: arguments.place,
            zero_row: arguments.zero_row,
            node_exact: arguments.node_exact,
        },
        force: arguments.force,
    };
    let listener = UiListener::new(ui, "inverting");
    let inversion = invert_folder(&arguments.maps, &stage, &|event| listener.hear(event)).map_err(with_advice)?;
    ui.document(&inversion.file)?;
    show(&inversion.file, ui);
    Ok(Outcome::Done)
}

/// The text summary.
pub(crate) fn show(file: &Table2File, ui: Ui) {
    let several = file.has_several_angles();
    for map in &file.maps {
        let trip = &map.round_trip;
        ui.say(format!(
            "{}{} gear: {} speeds × {} accelerations, {:.1} to {:.1} m/s²; dead band {:.2} to {:.2} N·m",
            if several { format!("{}°, ", map.wheel_angle_deg) } else { String::new() },
            map.gear,
            map.speed_mps.len(),
            map.accel_mps2.len(),
            map.accel_mps2[0],
            map.accel_mps2[map.accel_mps2.len() - 1],
            map.dead_band.low_nm,
            map.dead_band.high_nm
        ));
        ui.say(format!(
            "  round trip at nodes {:.4} m/s² rms, {:.4} at most; between nodes {:.4} rms, {:.4} at most (at {:.2} m/s, {:.2} m/s²)",
            trip.node_rms_mps2,
            trip.node_max_mps2,
            trip.between_rms_mps2,
            trip.between_max_mps2,
            trip.between_max_at.speed_mps,
            trip.between_max_at.accel_mps2
        ));
        ui.say(format!("written: {}", map.csv.file));
    }
    ui.say("written: table2.json");
}
