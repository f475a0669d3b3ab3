//! `plan`: the next campaign after Table 1.

use crate::calibrate::{only_angle, read_table1};
use crate::cli::Ui;
use crate::cli::advice::with_advice;
use crate::cli::breaks::Breaks;
use crate::cli::outcome::Outcome;
use crate::map::{FolderWriter, PlanFile, Proposal, WheelAngle, write_whole};
use crate::plan::PlanSettings;
use crate::text::shown;
use anyhow::{Context, bail};
use comfy_table::{CellAlignment, Table, presets};
use std::path::PathBuf;

/// Number of entries that are listed without `-v`.
const SHOWN: usize = 12;

/// Arguments of `plan`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  pivot-cal plan                           the next runs, as a table
  pivot-cal plan --minutes 5 -o next.toml  as a campaign file, which `pivot-cal record` drives
  pivot-cal plan --speed-breaks 0:0.05:0.8 --torque-breaks=-20:4:32   the cells to plan for

Reads table1.json, and writes plan.json beside it, which `pivot-cal report` shows. Each run is the one that reduces the standard
error of the torque most per second of driving, over the cells of the table, by the estimator's own information matrix.")]
pub(crate) struct Arguments {
    /// Folder with table1.json
    #[arg(long, value_name = "DIR", default_value = "maps")]
    maps: PathBuf,
    /// Wheel angle of the map to plan for [°]; by default the test angle
    #[arg(long, value_name = "DEG", allow_negative_numbers = true)]
    angle: Option<f64>,
    /// Time to drive, with spin-ups, stops and pauses [min]
    #[arg(long, value_name = "MIN", default_value_t = 5.0)]
    minutes: f64,
    /// Speeds of the cells to plan for [m/s], as `start:step:stop` or a list; by default the driven ones of Table 1
    #[arg(long, value_name = "BREAKS")]
    speed_breaks: Option<Breaks>,
    /// Torques of the cells to plan for [N·m]; by default those of Table 1
    #[arg(long, value_name = "BREAKS", allow_hyphen_values = true)]
    torque_breaks: Option<Breaks>,
    /// Campaign file to write (TOML); `-` is standard output
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
}

pub(crate) fn run(arguments: &Arguments, ui: Ui) -> anyhow::Result<Outcome> {
    let ui = ui.beside(arguments.output.as_deref())?;
    if !(arguments.minutes > 0.0 && arguments.minutes <= 60.0) {
        bail!("--minutes is {}; allowed: above 0, at most 60", arguments.minutes);
    }
    let path = arguments.maps.join("table1.json");
    let (folder, _) = read_table1(&arguments.maps.as_path().into()).map_err(with_advice)?;
    let file = folder.table1;
    let angle = arguments.angle.map_or(file.vehicle.test_angle(), WheelAngle::from_deg);
    let steered = !angle.is_same(file.vehicle.test_angle());
    let maps = file.maps.len();
    let file = only_angle(file, angle.deg()).map_err(with_advice).with_context(|| shown(&path))?;
    if file.maps.len() < maps {
        ui.say(format!("the map of {}°; table1.json holds those of other wheel angles, too (--angle)", angle.deg()));
    }
    let settings = PlanSettings {
        budget_s: 60.0 * arguments.minutes,
        speed_breaks_mps: arguments.speed_breaks.clone().map(|b| b.0),
        torque_breaks_nm: arguments.torque_breaks.clone().map(|b| b.0),
    };
    let plan = crate::plan::plan(&file, &settings).with_context(|| shown(&path))?;
    // for the report
    let for_page = PlanFile::new(&file, folder.table1_json.sha256, plan.clone());
    let json = for_page.to_json()?;
    let put = FolderWriter::open(&arguments.maps).and_then(|mut folder| {
        folder.put("plan.json", json);
        folder.commit()
    });
    if let Err(error) = put {
        ui.warn(format!("the page will not show the plan: {error}"));
    }
    if let Some(output) = &arguments.output {
        write_whole(output, plan.to_toml(steered.then_some(angle))?.as_bytes())?;
    }
    ui.document(&plan)?;
    show(&plan, ui);
    match &arguments.output {
        Some(output) => ui.say(format!("written: {}", shown(output))),
        None => ui.say("give -o FILE to write it as a campaign file"),
    }
    Ok(Outcome::Done)
}

fn show(plan: &Proposal, ui: Ui) {
    ui.say(format!(
        "{} runs, {:.0} s: standard error of the torque {:.3} → {:.3} N·m (root mean square over the cells)",
        plan.runs, plan.seconds, plan.std_err_nm, plan.std_err_after_nm
    ));
    let shown = if ui.is_verbose() { usize::MAX } else { SHOWN };
    let mut table = Table::new();
    let header = ["run", "gear", "torque [N·m]", "start", "times", "each [s]", "gain [N·m]", "gain [%]"];
    table.load_style(presets::UTF8_FULL_CONDENSED).set_header(header);
    for (k, entry) in plan.entries.iter().take(shown).enumerate() {
        table.add_row([
            (k + 1).to_string(),
            entry.run.gear.to_string(),
            format!("{:.1}", entry.run.torque_nm),
            entry.run.start(),
            entry.repeats.to_string(),
            format!("{:.1}", entry.seconds),
            format!("{:.4}", entry.gain_nm),
            format!("{:.2}", entry.gain_percent),
        ]);
    }
    for (k, column) in table.column_iter_mut().enumerate() {
        if k != 1 && k != 3 {
            column.set_cell_alignment(CellAlignment::Right);
        }
    }
    ui.say(table.to_string());
    if plan.entries.len() > shown {
        ui.say(format!("and {} more (-v shows all)", plan.entries.len() - shown));
    }
    for (k, entry) in plan.entries.iter().take(if ui.is_verbose() { usize::MAX } else { 3 }).enumerate() {
        ui.say(format!("{}: {}", k + 1, entry.reason));
    }
}
