//! `tune`: gains and preview for a map and its vehicle, as a controller file.

use crate::cli::one_of::OneOf;
use crate::cli::outcome::Outcome;
use crate::cli::text_file::read_file;
use crate::cli::verify_text::new_table;
use crate::cli::{Ui, controller_file};
use crate::map::write_whole;
use crate::text::shown;
use crate::tune::{LimitMargin, PlanFreedom, SettingChange, TuneSettings, Tuning, tune};
use crate::verify::{Gate, Maps, VerifySettings};
use anyhow::{Context, bail};
use std::path::PathBuf;

/// Arguments of `tune`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  pivot-cal tune                                  for the map in ./maps, into maps/controller.toml
  pivot-cal verify --controller-settings maps/controller.toml
  pivot-cal tune --plan keep                      gains and preview only, never a slower plan
  pivot-cal tune --start data/controllers/plain.toml -o plain_tuned.toml   the published law, nothing added

Every candidate drives the pivots of `verify` on the identified plant and on perturbed ones. Wanted are settings that keep every limit of the
gate with a reserve; of those, the fastest. The result is judged with the draws of `verify`.
Exit status: 0 found and written, 3 no settings keep the gate (nothing is written), 1 error.")]
pub(crate) struct Arguments {
    /// Folder with table1.json, table2.json and table2.csv
    #[arg(long, value_name = "DIR", default_value = "maps")]
    maps: PathBuf,
    /// Controller file to start from, by default the built-in one; what the search does not change is taken from it
    #[arg(long, value_name = "FILE")]
    start: Option<PathBuf>,
    /// Controller file to write (TOML), by default controller.toml in the folder of the map; `-` is standard output
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// What may be done with cruise speed and accelerations of the plan: keep, slower (if no gains keep the gate), any (faster as well)
    #[arg(long, value_name = "FREEDOM", default_value = "slower", value_parser = OneOf::new(PlanFreedom::NAMES.map(|(name, _)| name), plan_freedom),
        hide_possible_values = true)]
    plan: PlanFreedom,
    /// Share of each limit that is to be left
    #[arg(long, value_name = "SHARE", default_value_t = 0.15)]
    reserve: f64,
    /// Perturbed plants per scenario and candidate
    #[arg(long, value_name = "N", default_value_t = 60)]
    draws: usize,
    /// Limits that replace the built-in ones
    #[arg(long, value_name = "FILE")]
    gate: Option<PathBuf>,
    /// Seed of everything random
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
}

fn plan_freedom(text: &str) -> Result<PlanFreedom, String> {
    let known = || PlanFreedom::NAMES.map(|(name, _)| name).join(", ");
    let found = PlanFreedom::NAMES.iter().find(|(name, _)| *name == text);
    found.map(|(_, freedom)| *freedom).ok_or_else(|| format!("{text:?} is not known; allowed: {}", known()))
}

pub(crate) fn run(arguments: &Arguments, ui: Ui) -> anyhow::Result<Outcome> {
    let ui = ui.beside(arguments.output.as_deref())?;
    if !(0.0..=0.9).contains(&arguments.reserve) {
        bail!("--reserve is {}; allowed: 0 to 0.9", arguments.reserve);
    }
    if !(1..=10_000).contains(&arguments.draws) {
        bail!("--draws is {}; allowed: 1 to 10000", arguments.draws);
    }
    let start = controller_file::read(arguments.start.as_deref())?;
    let gate = match &arguments.gate {
        Some(path) => Gate::with(Some(&read_file(path)?)).with_context(|| shown(path))?,
        None => Gate::with(None)?,
    };
    let maps = Maps::read(&arguments.maps, false)?;
    let verify = VerifySettings { gate, seed: arguments.seed, controller: start.clone(), ..VerifySettings::new()? };
    let settings = TuneSettings { start, draws: arguments.draws, reserve: arguments.reserve, plan: arguments.plan, verify };
    let bar = ui.progress_runs("tuning");
    let tuning = tune(&maps, &settings, &|| bar.inc(1))?;
    bar.finish_and_clear();
    ui.document(&tuning)?;
    show(&tuning, ui);
    if !tuning.passes {
        Ui::refuse("no settings keep the gate; nothing is written");
        return Ok(Outcome::Rejected);
    }
    let path = arguments.output.clone().unwrap_or_else(|| arguments.maps.join("controller.toml"));
    write_whole(&path, tuning.to_toml(&maps).as_bytes())?;
    ui.say(format!("written: {}", shown(&path)));
    Ok(Outcome::Done)
}

fn show(tuning: &Tuning, ui: Ui) {
    let seconds = |s: Option<f64>| s.map_or("none".to_owned(), |s| format!("{s:.2} s"));
    let [before, after] = tuning.settling_s.map(seconds);
    let outcome = if tuning.passes { "every limit of the gate is kept" } else { "NO settings keep the gate; the nearest ones are" };
    ui.say(format!("{outcome}; {} candidates, settling time {before} → {after}", tuning.candidates));
    let mut table = new_table(&["setting", "start", "tuned"]);
    for SettingChange { key, from, to } in &tuning.changes {
        table.add_row([key, from, to]);
    }
    if tuning.changes.is_empty() {
        ui.say("nothing is changed: the start is the best that was found");
    } else {
        ui.say(table.to_string());
    }
    let mut table = new_table(&["limit", "", "start", "tuned", "limit", "left", "nearest in"]);
    for margin in &tuning.after {
        let of = |m: &LimitMargin| m.metric.with_unit(m.value);
        let start = tuning.before.iter().find(|before| before.is_of_the_limit(margin));
        table.add_row([
            margin.metric.title().to_owned(),
            margin.statistic.title().to_owned(),
            start.map_or(String::new(), of),
            of(margin),
            margin.metric.with_unit(margin.limit),
            format!("{:.0} %", 100.0 * margin.margin),
            margin.scenario.clone(),
        ]);
    }
    ui.say(table.to_string());
    let margins = &tuning.loop_margins;
    ui.say(format!(
        "speed loop: gain margin {:.1}, phase margin {:.0}°, delay margin {:.0} ms",
        margins.gain,
        margins.phase_deg,
        1e3 * margins.delay_s
    ));
    for limit in &tuning.limits {
        ui.say(format!("limit: {limit}"));
    }
}
