//! `diff A B`: the changes between two maps.

use crate::cli::Ui;
use crate::cli::outcome::Outcome;
use crate::diff::{DiffSettings, DiffSide, DiffVerdict, EditedMap, MapComparison, MapDiff, compare, edited, html};
use crate::import::{FullScale, read_map};
use crate::map::{Gear, write_whole};
use crate::text::shown;
use comfy_table::{CellAlignment, Table, presets};
use std::path::{Path, PathBuf};

/// Number of changes that are listed without `-v`.
const SHOWN: usize = 10;

/// Arguments of `diff`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  pivot-cal diff maps-march maps-june                 their table2.json
  pivot-cal diff maps-march/table1.json maps-june/table1.json --html change.html
  pivot-cal diff --edited maps tuned.dcm              the cells that a person changed, by how many reported errors

Changes are b - a at the breaks of a, each compared with the standard errors of both. Of many cells some are large by chance; the
Benjamini-Hochberg procedure takes this into account. Extrapolated and unreachable cells are skipped.
Exit status: 0 the same, 3 changed or incompatible, 1 a file cannot be read.")]
pub(crate) struct Arguments {
    /// The first map: table1.json, table2.json, or a folder
    a: PathBuf,
    /// The second map; with --edited a file that came back: DCM, CDFX, C, Rust, Autoware, Apollo, matrix or long CSV, JSON
    b: PathBuf,
    /// List the cells of b that a person changed
    #[arg(long, conflicts_with = "html")]
    edited: bool,
    /// Torque that is 100 % [N·m], for a file in % that does not say it
    #[arg(long, value_name = "NM", requires = "edited")]
    torque_full_scale: Option<f64>,
    /// Write a heat map of the changes; `-` is standard output
    #[arg(long, value_name = "FILE")]
    html: Option<PathBuf>,
    /// Expected share of false ones among the cells called significant
    #[arg(long, value_name = "SHARE", default_value_t = DiffSettings::default().false_discovery_rate)]
    false_discovery_rate: f64,
    /// Acceleration [m/s²] from which a significant change matters
    #[arg(long, value_name = "MPS2", default_value_t = DiffSettings::default().matters_mps2)]
    matters_mps2: f64,
}

pub(crate) fn run(arguments: &Arguments, ui: Ui) -> anyhow::Result<Outcome> {
    let ui = ui.beside(arguments.html.as_deref())?;
    let settings = DiffSettings { false_discovery_rate: arguments.false_discovery_rate, matters_mps2: arguments.matters_mps2 };
    if !(settings.false_discovery_rate > 0.0 && settings.false_discovery_rate < 1.0) {
        anyhow::bail!("--false-discovery-rate is {}; allowed: above 0, below 1", settings.false_discovery_rate);
    }
    if !(settings.matters_mps2.is_finite() && settings.matters_mps2 >= 0.0) {
        anyhow::bail!("--matters-mps2 is {}; allowed: 0 or more", settings.matters_mps2);
    }
    if arguments.edited {
        return run_edited(arguments, ui);
    }
    let comparison = compare(&DiffSide::read(&arguments.a)?, &DiffSide::read(&arguments.b)?, &settings);
    if let Some(path) = &arguments.html {
        write_whole(path, html(&comparison).as_bytes())?;
    }
    ui.document(&comparison)?;
    show(&comparison, ui);
    if let Some(path) = &arguments.html {
        ui.say(format!("written: {}", shown(path)));
    }
    Ok(if comparison.verdict == DiffVerdict::Same { Outcome::Done } else { Outcome::Rejected })
}

/// The cells that a person changed.
fn run_edited(arguments: &Arguments, ui: Ui) -> anyhow::Result<Outcome> {
    let mut map = DiffSide::read(&arguments.a)?;
    let vehicle = &map.vehicle;
    let full =
        FullScale { torque_nm: arguments.torque_full_scale.or(vehicle.torque_full_scale_nm), wheel_radius_m: vehicle.wheel_radius_m };
    let imported = read_map(&arguments.b, full)?;
    let is_table1 = !imported.accel_tables.is_empty();
    if is_table1 && map.table == crate::diff::Table::Table2 {
        let folder = if arguments.a.is_dir() { arguments.a.clone() } else { arguments.a.parent().unwrap_or(Path::new("")).to_owned() };
        map = DiffSide::read(&folder.join("table1.json"))?;
    } else if !is_table1 && map.table != crate::diff::Table::Table2 {
        anyhow::bail!("{}: --edited compares with a Table 2; give its folder or its table2.json", shown(&arguments.a));
    }
    let found = edited(&map, &shown(&arguments.b), &imported);
    ui.document(&found)?;
    let (count, compared) = (found.cells.len() + found.accel_cells.len(), found.compared);
    ui.say(format!("{} ({}): {count} of {compared} cells were changed{}", found.file, found.format, outside(found.outside)));
    found.notes.iter().for_each(|note| ui.say(format!("  note: {note}")));
    if count > 0 {
        ui.say(edited_cells(&found, if ui.is_verbose() { usize::MAX } else { SHOWN }));
        ui.say(format!("`pivot-cal verify --table {}` judges the file on the measured plant", found.file));
    }
    Ok(if count == 0 { Outcome::Done } else { Outcome::Rejected })
}

/// The changed cells as a table.
fn edited_cells(found: &EditedMap, shown: usize) -> String {
    let mut table = Table::new();
    table.load_style(presets::UTF8_FULL_CONDENSED);
    let mut add = |gear: Gear, places: [f64; 2], [map, file]: [f64; 2], errors: Option<f64>| {
        let errors = errors.map_or("not known here".to_owned(), |errors| format!("{errors:+.1}"));
        let [row, column] = places.map(|place| place.to_string());
        table.add_row([gear.to_string(), row, column, format!("{map:.4}"), format!("{file:.4}"), format!("{:+.4}", file - map), errors]);
    };
    for cell in found.cells.iter().take(shown) {
        add(cell.gear, [cell.speed_mps, cell.accel_mps2], [cell.measured_nm, cell.edited_nm], cell.errors);
    }
    for cell in found.accel_cells.iter().take(shown) {
        add(cell.gear, [cell.torque_nm, cell.speed_mps], [cell.measured_mps2, cell.edited_mps2], cell.errors);
    }
    table.set_header(if found.accel_cells.is_empty() {
        ["gear", "speed [m/s]", "acceleration [m/s²]", "map [N·m]", "file [N·m]", "change [N·m]", "reported errors"]
    } else {
        ["gear", "torque [N·m]", "speed [m/s]", "map [m/s²]", "file [m/s²]", "change [m/s²]", "reported errors"]
    });
    table.to_string()
}

fn outside(count: usize) -> String {
    if count > 0 { format!(", {count} lie outside the axes of the map") } else { String::new() }
}

fn show(comparison: &MapComparison, ui: Ui) {
    ui.say(comparison.sentence());
    comparison.reasons.iter().for_each(|reason| ui.say(format!("  {reason}")));
    comparison.notes.iter().for_each(|note| ui.say(format!("  note: {note}")));
    for map in &comparison.maps {
        ui.say(format!(
            "{} gear at {}°: {} cells compared{}, {} left out; {} significant, {} of them matter; change {:.4} {} rms, z {:.2} rms",
            map.gear,
            map.wheel_angle_deg,
            map.compared,
            if map.interpolated { " (b interpolated)" } else { "" },
            map.left_out,
            map.significant,
            map.matters,
            map.rms_change,
            comparison.table.unit(),
            map.rms_z
        ));
        if !map.largest.is_empty() {
            ui.say(largest(comparison, map, if ui.is_verbose() { usize::MAX } else { SHOWN }));
        }
    }
}

fn largest(comparison: &MapComparison, map: &MapDiff, shown: usize) -> String {
    let [rows, columns] = comparison.table.axes();
    let unit = comparison.table.unit();
    let mut table = Table::new();
    let header = [
        rows.to_owned(),
        columns.to_owned(),
        "a".into(),
        "b".into(),
        format!("change [{unit}]"),
        "±".into(),
        "z".into(),
        "worth [m/s²]".into(),
    ];
    table.load_style(presets::UTF8_FULL_CONDENSED).set_header(header);
    for cell in map.largest.iter().take(shown) {
        table.add_row([
            cell.row.to_string(),
            cell.column.to_string(),
            format!("{:.4}", cell.a),
            format!("{:.4}", cell.b),
            format!("{:+.4}", cell.change),
            format!("{:.4}", cell.std_err),
            format!("{:+.1}", cell.z),
            format!("{:+.3}", cell.accel_mps2),
        ]);
    }
    for column in table.column_iter_mut() {
        column.set_cell_alignment(CellAlignment::Right);
    }
    table.to_string()
}
