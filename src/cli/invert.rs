//! `invert`: Table 2 from Table 1.

use crate::cli::Ui;
use crate::cli::breaks::Breaks;
use crate::cli::outcome::Outcome;
use crate::cli::table1;
use crate::invert::{Inversion, InvertSettings, ZeroRow, invert};
use crate::map::{CsvRef, FixedText, Mismatch, Table1File, Table2File, write_whole};
use anyhow::{Context, bail};
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
    /// Place this many breaks on each axis where they serve best
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
    /// Go on when a hash does not match
    #[arg(long)]
    pub(crate) force: bool,
}

fn zero_row(text: &str) -> Result<ZeroRow, String> {
    ZeroRow::from_name(text).map_err(|_| format!("{text:?} is not known; allowed: moving, hold"))
}

pub(crate) fn run(arguments: &Arguments, ui: Ui) -> anyhow::Result<Outcome> {
    let inversion = make(arguments, ui)?;
    ui.document(&inversion.file)?;
    show(&inversion.file, ui);
    Ok(Outcome::Done)
}

/// Inverts and writes.
pub(crate) fn make(arguments: &Arguments, ui: Ui) -> anyhow::Result<Inversion> {
    let path = arguments.maps.join("table1.json");
    let (folder, mismatches) = table1::read(&arguments.maps)?;
    let mut file = folder.table1;
    if !arguments.angle.is_empty() {
        crate::cli::angles::keep(&mut file, &arguments.angle).with_context(|| path.display().to_string())?;
    }
    check_csvs(&file, &mismatches, arguments, ui)?;
    let settings = InvertSettings {
        speed_breaks_mps: arguments.speed_breaks.clone().map(|b| b.0),
        accel_breaks_mps2: arguments.accel_breaks.clone().map(|b| b.0),
        place: arguments.place,
        zero_row: arguments.zero_row,
        node_exact: arguments.node_exact,
    };
    let table1 = CsvRef { file: "table1.json".to_owned(), sha256: folder.table1_json.sha256 };
    let inversion = invert(&file, table1, &settings).with_context(|| path.display().to_string())?;
    crate::cli::angles::remove_stale(&arguments.maps, "table2", inversion.csvs.iter().map(|(name, _)| name.as_str()))?;
    for (name, text) in &inversion.csvs {
        write_whole(&arguments.maps.join(name), text.as_bytes())?;
    }
    write_whole(&arguments.maps.join("table2.json"), inversion.file.to_json()?.as_bytes())?;
    Ok(inversion)
}

/// A `table1.csv` that was edited by hand is not what `table1.json` holds, and what is inverted is the JSON.
/// A CSV that is not there says nothing else.
fn check_csvs(file: &Table1File, mismatches: &[Mismatch], arguments: &Arguments, ui: Ui) -> anyhow::Result<()> {
    let inverted = |csv: &str| file.maps.iter().any(|map| map.csv.file == csv);
    for edited in mismatches.iter().filter(|m| matches!(m, Mismatch::Hash { .. }) && inverted(m.file())) {
        let path = arguments.maps.join(edited.file());
        let what = format!("{} is not the file that table1.json describes: its hash differs", path.display());
        if arguments.force {
            ui.warn(format!("{what}; the numbers of table1.json are inverted, since --force was given"));
        } else {
            bail!("{what}. The numbers of table1.json would be inverted, not those of the CSV: fit again, or go on with --force");
        }
    }
    Ok(())
}

/// The summary for people.
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
