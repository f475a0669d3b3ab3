//! `invert`: Table 2 from Table 1.

use crate::calibrate::{InvertStage, invert_folder};
use crate::cli::Ui;
use crate::cli::advice::with_advice;
use crate::cli::breaks::Breaks;
use crate::cli::listener::UiListener;
use crate::cli::one_of::OneOf;
use crate::cli::outcome::Outcome;
use crate::invert::{InvertSettings, RawSettings, ZeroRow};
use crate::map::{FixedText as _, RawUnit, RawUnits, Table2File};
use std::path::PathBuf;

/// Arguments of `invert`.
#[derive(Debug, Clone, clap::Args)]
#[command(after_help = "\
Examples:
  pivot-cal invert
  pivot-cal invert --speed-breaks 0:0.1:1.1 --accel-breaks=-2,-1,-0.5,0,0.5,1
  pivot-cal invert --place 12 --zero-row hold
  pivot-cal invert --place 6x10 --int16             6 speeds, 10 accelerations, whole counts of 16 bits
  pivot-cal invert --speed-raw 0.0078125 --torque-raw 0.01,-100

With raw units, value = scale * count + offset, and the table holds these values: the round trip and the verdict count the rounding.
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
    /// BreakCounts this many breaks at the best places: speeds x accelerations, as 6x10, or one number for both axes
    #[arg(long, value_name = "NxM", value_parser = place)]
    pub(crate) place: Option<BreakCounts>,
    /// Whole counts of 16 bits for breaks and torques, with the finest decimal scales that hold them; `export --int16` writes them
    #[arg(long)]
    pub(crate) int16: bool,
    /// Speed breaks at whole counts of this many m/s: SCALE, or SCALE,OFFSET with the speed of count 0
    #[arg(long, value_name = "SCALE[,OFFSET]", allow_hyphen_values = true, value_parser = raw_unit)]
    pub(crate) speed_raw: Option<RawUnit>,
    /// The same for the desired acceleration [m/s²]
    #[arg(long, value_name = "SCALE[,OFFSET]", allow_hyphen_values = true, value_parser = raw_unit)]
    pub(crate) accel_raw: Option<RawUnit>,
    /// The same for the torques [N·m]
    #[arg(long, value_name = "SCALE[,OFFSET]", allow_hyphen_values = true, value_parser = raw_unit)]
    pub(crate) torque_raw: Option<RawUnit>,
    /// The row at speed 0: torque of a wheel just moving, or 0 for a ≤ 0
    #[arg(long, value_name = "ROW", value_parser = OneOf::new(["moving", "hold"], zero_row), default_value = "moving",
        hide_possible_values = true)]
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

/// Numbers of speeds and accelerations.
type BreakCounts = [usize; 2];

fn place(text: &str) -> Result<BreakCounts, String> {
    let number =
        |part: &str| part.trim().parse::<usize>().map_err(|_| format!("{text:?} is not a number such as 12, nor two such as 6x10"));
    match text.split_once(['x', '×']) {
        Some((rows, columns)) => Ok([number(rows)?, number(columns)?]),
        None => number(text).map(|both| [both; 2]),
    }
}

fn raw_unit(text: &str) -> Result<RawUnit, String> {
    let number = |part: &str| part.trim().parse::<f64>().map_err(|_| format!("{:?} is not a number", part.trim()));
    let (scale, offset) = text.split_once(',').unwrap_or((text, "0"));
    let unit = RawUnit { scale: number(scale)?, offset: number(offset)? };
    if unit.is_valid() { Ok(unit) } else { Err("a scale is above 0".to_owned()) }
}

pub(crate) fn run(arguments: &Arguments, ui: Ui) -> anyhow::Result<Outcome> {
    let stage = InvertStage {
        wheel_angles_deg: arguments.angle.clone(),
        settings: InvertSettings {
            speed_breaks_mps: arguments.speed_breaks.clone().map(|b| b.0),
            accel_breaks_mps2: arguments.accel_breaks.clone().map(|b| b.0),
            place: arguments.place,
            raw: RawSettings {
                int16: arguments.int16,
                units: RawUnits { speed_mps: arguments.speed_raw, accel_mps2: arguments.accel_raw, torque_nm: arguments.torque_raw },
            },
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
        let bytes = |size: usize| size * (map.speed_mps.len() + map.accel_mps2.len() + map.speed_mps.len() * map.accel_mps2.len());
        let [double, float, int16] = [8, 4, 2].map(bytes);
        ui.say(format!("  ROM of its numbers: {double} bytes as double, {float} as float, {int16} as int16"));
        ui.say(format!("written: {}", map.csv.file));
    }
    if let Some(raw) = file.raw {
        for (axis, unit, name) in
            [("speed", raw.speed_mps, "m/s"), ("acceleration", raw.accel_mps2, "m/s²"), ("torque", raw.torque_nm, "N·m")]
        {
            if let Some(RawUnit { scale, offset }) = unit {
                ui.say(format!("raw {axis}: {scale} {name} a count, {offset} {name} at count 0, rounded by up to {} {name}", 0.5 * scale));
            }
        }
    }
    ui.say("written: table2.json");
}
