//! `verify`: judges the map in a folder, prints the verdict and writes `verify.json`.

use crate::calibrate::put_verdict;
use crate::cli::logs::{LogArguments, preset};
use crate::cli::one_of::OneOf;
use crate::cli::outcome::Outcome;
use crate::cli::text_file::read_file;
use crate::cli::verify_text::{new_table, show};
use crate::cli::{Ui, controller_file, points};
use crate::import::{FullScale, read_map};
use crate::log::Preset;
use crate::manoeuvre::{Manoeuvre, ManoeuvreSettings, judge_manoeuvres};
use crate::map::{FolderWriter, sha256_hex, write_whole};
use crate::scene::SceneFile;
use crate::sim::VehicleFile;
use crate::spelling::edits;
use crate::text::shown;
use crate::verify::{
    Class, ControllerCommand, Error, Gate, MapVerdict, Maps, RecordedPivots, ReplayedRun, Scenario, Verified, VerifySettings, Wanted,
    at_angles, recorded_pivots, replayed, verify_with,
};
use anyhow::{Context, bail};
use std::path::{Path, PathBuf};

/// Smallest turn of `--turn-deg` [°]: twice the threshold at which a turn ends.
const SMALLEST_TURN_DEG: f64 = 2.0;

/// Arguments of `verify`.
#[derive(Debug, clap::Args)]
#[command(group = clap::ArgGroup::new("recorded").multiple(true))]
#[command(after_help = "\
Examples:
  pivot-cal verify                            all pivots on the map in ./maps
  pivot-cal verify --scenario left-90 -v      one scenario, every metric
  pivot-cal verify --turn-deg 5               small turns, added to what was judged before
  pivot-cal verify --angle 80                 also the pivots of the map for the wheel at 80°
  pivot-cal verify --scenario polyline-lqr -v one manoeuvre (all of them: manoeuvres)
  pivot-cal verify --scenario polyline-mpc --points yard.csv   the same along your own points
  pivot-cal verify --scene dock.toml          a manoeuvre in your own scene: slot, field, polyline or route (docs/manoeuvres.md)
  pivot-cal verify --gate strict.toml         your own limits, over the built-in ones
  pivot-cal verify --controller-settings data/controllers/plain.toml   another controller, here the published law with nothing added
  pivot-cal verify --controller 'python3 examples/controller.py'   your own controller as a process (docs/controller.md)
  pivot-cal verify --table tuned.dcm          a map that came back from a tool, on the measured plant
  pivot-cal verify --replay held_out.mcap     also recorded runs replayed with the plant
  pivot-cal verify --pivots shift.mcap --signals deployed.toml   also pivots in operation, desired against actual acceleration

  pivot-cal verify --accept coverage          the objection of a check overruled by hand

Exit status: 0 the map passes, 3 it fails or a check rejects it, 1 it cannot be judged or too little was driven.")]
pub(crate) struct Arguments {
    /// Folder with table1.json, table2.json and table2.csv
    #[arg(long, value_name = "DIR", default_value = "maps")]
    maps: PathBuf,
    /// Run this scenario, manoeuvre or group (pivots, manoeuvres, all) instead of the pivots (may be repeated)
    #[arg(long, value_name = "NAME", value_parser = OneOf::new(scenario_names(), |text| Ok(text.to_owned())), hide_possible_values = true)]
    scenario: Vec<String>,
    /// Also a turn of this size [°] in each direction; with no --scenario these turns alone (may be repeated)
    #[arg(long, value_name = "DEG", value_parser = turn_deg)]
    turn_deg: Vec<f64>,
    /// Also the same pivots with the maps of this wheel angle [°] (may be repeated)
    #[arg(long, value_name = "DEG", allow_negative_numbers = true)]
    angle: Vec<f64>,
    /// Replace the verdict in the folder instead of adding to what it judged of the same map
    #[arg(long)]
    fresh: bool,
    /// List the scenarios and exit
    #[arg(long)]
    list: bool,
    /// Continue if a hash does not match
    #[arg(long)]
    force: bool,
    /// Write a log of each scenario's nominal run into this folder
    #[arg(long, value_name = "DIR")]
    log: Option<PathBuf>,
    /// Beside each manoeuvre's nominal run also log its worst perturbed one, as NAME.worst.mcap
    #[arg(long, requires = "log")]
    log_worst: bool,
    /// Judge the Table 2 of this file instead of the folder's, on the same plant: DCM, CDFX, C, Apollo, matrix or long CSV, as a person changed
    /// it; nothing is written
    #[arg(long, value_name = "FILE")]
    table: Option<PathBuf>,
    /// Torque that is 100 % [N·m], for a --table in % that does not say it
    #[arg(long, value_name = "NM", requires = "table")]
    torque_full_scale: Option<f64>,
    /// Settings of the controller that drives (TOML) instead of the built-in ones; data/controllers has examples
    #[arg(long, value_name = "FILE")]
    controller_settings: Option<PathBuf>,
    /// Judge this process instead of the bundled controller: it is asked one line of JSON per control period and answers one
    /// (docs/controller.md). No shell reads the command; quotes keep spaces. A file that ends in .so, .dylib or .dll is a shared library, built
    /// from the template that export --format controller-c writes
    #[arg(long, value_name = "CMD", conflicts_with_all = ["points", "table"])]
    controller: Option<String>,
    /// Time that process or library has for each answer [ms]
    #[arg(long, value_name = "MS", default_value_t = 1000, requires = "controller")]
    controller_timeout_ms: u64,
    /// Limits that replace the built-in ones
    #[arg(long, value_name = "FILE")]
    gate: Option<PathBuf>,
    /// Also replay the runs of this log with the plant, recorded against simulated speed; best a log that the fit has not used (may be
    /// repeated)
    #[arg(long, value_name = "LOG", group = "recorded")]
    replay: Vec<PathBuf>,
    /// Also compare the pivots of this log of a controller that drives with the map: desired acceleration (`desired_accel` in the signal map)
    /// against the one that the vehicle had (may be repeated)
    #[arg(long, value_name = "LOG", group = "recorded")]
    pivots: Vec<PathBuf>,
    /// Signal map of the logs of --replay and --pivots
    #[arg(long, value_name = "FILE", requires = "recorded", conflicts_with = "preset")]
    signals: Option<PathBuf>,
    /// Signal map of these logs that comes with the program: pivot-cal, verify-log, autoware, joint-state
    #[arg(long, value_name = "NAME", requires = "recorded", value_parser = preset(), hide_possible_values = true)]
    preset: Option<Preset>,
    /// Points of the polyline manoeuvres instead of the built-in ones (CSV: x and y in metres, one point per line, optionally the set speed in m/s of
    /// the segment that begins there)
    #[arg(long, value_name = "FILE")]
    points: Option<PathBuf>,
    /// Drive the manoeuvre of this scene (TOML): a parking slot, the field of a U-turn, a polyline or a route with lateral errors; data/scenes has
    /// examples. With no --scenario the scenes alone (may be repeated)
    #[arg(long, value_name = "FILE", conflicts_with_all = ["controller", "table"])]
    scene: Vec<PathBuf>,
    /// Vehicle (TOML): it drives the manoeuvres instead of the bundled scrubber, and its sensors, steering, torque step, dead band and rate
    /// limit act in the pivots
    #[arg(long, value_name = "FILE")]
    vehicle: Option<PathBuf>,
    /// Perturbed plants per scenario; by default 200, and 20 for manoeuvres
    #[arg(long, value_name = "N")]
    draws: Option<usize>,
    /// Overrule the objection of this check; it is written into verify.json and onto the page (may be repeated)
    #[arg(long, value_name = "NAME")]
    accept: Vec<String>,
    /// Seed of everything random
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
}

pub(crate) fn run(arguments: &Arguments, ui: Ui) -> anyhow::Result<Outcome> {
    if arguments.list {
        list(ui)?;
        return Ok(Outcome::Done);
    }
    let gate = arguments.gate.as_deref().map(read_file).transpose()?;
    let (mut scenarios, mut manoeuvres) = chosen(&arguments.scenario)?;
    if arguments.scenario.is_empty() && !(arguments.turn_deg.is_empty() && arguments.scene.is_empty()) {
        scenarios.clear();
    }
    for turn in arguments.turn_deg.iter().flat_map(|size_deg| Scenario::turns(*size_deg)) {
        if scenarios.iter().all(|s| s.name != turn.name) {
            scenarios.push(turn);
        }
    }
    if let Some(path) = &arguments.points {
        if manoeuvres.iter().all(|m| m.class != Class::Polyline) {
            bail!("--points needs a polyline to drive them, as --scenario polyline-lqr");
        }
        let points = points::read(path)?;
        manoeuvres = manoeuvres.into_iter().map(|m| m.along(&points)).collect::<Result<_, _>>().with_context(|| shown(path))?;
    }
    let gate = match &arguments.gate {
        Some(path) => Gate::with(gate.as_deref()).with_context(|| shown(path))?,
        None => Gate::with(None)?,
    };
    let controller = controller_file::read(arguments.controller_settings.as_deref())?;
    let controller_command = match &arguments.controller {
        Some(command) => Some(ControllerCommand::new(command, arguments.controller_timeout_ms)?),
        None => None,
    };
    if let Some(manoeuvre) = manoeuvres.first().filter(|_| controller_command.is_some()) {
        bail!("--controller drives pivots only, and {} is a manoeuvre; leave it out of --scenario and --scene", manoeuvre.name);
    }
    let defaults = ManoeuvreSettings::new()?;
    let given = match &arguments.vehicle {
        Some(path) => Some(VehicleFile::from_toml(&read_file(path)?).with_context(|| shown(path))?.settings()),
        None => None,
    };
    let wheelbase_m = given.as_ref().unwrap_or(&defaults.vehicle).vehicle.wheelbase_m;
    for path in &arguments.scene {
        let manoeuvre = scene(path, wheelbase_m)?;
        if let Some(taken) = manoeuvres.iter().find(|m| m.name == manoeuvre.name) {
            bail!("{}: two scenes are named {}; give each a name of its own", shown(path), taken.name);
        }
        manoeuvres.push(manoeuvre);
    }
    let driven = ManoeuvreSettings {
        manoeuvres,
        draws: arguments.draws.unwrap_or(defaults.draws),
        vehicle: given.clone().unwrap_or_else(|| defaults.vehicle.clone()),
        seed: arguments.seed,
        gate: gate.clone(),
        controller: controller.settings().clone(),
        ..defaults
    };
    let accept = arguments.accept.clone();
    let usual = VerifySettings::new()?;
    let draws = arguments.draws.unwrap_or(usual.draws);
    let mut settings = VerifySettings { scenarios, draws, seed: arguments.seed, gate, accept, controller, ..usual };
    if !arguments.maps.exists() {
        Maps::read(&arguments.maps, arguments.force)?; // the error
    }
    let mut folder = FolderWriter::open(&arguments.maps)?;
    let maps = Maps::read_from(&folder.view(), arguments.force)?;
    settings.given_vehicle = given;
    if controller_command.is_some() {
        // laws that share its plan, but not its process, are no measure of it
        settings.comparison_draws = 0;
    }
    settings.controller_command = controller_command;
    for forced in &maps.forced {
        ui.warn(format!("{forced}; continued, since --force was given"));
    }
    let maps = match &arguments.table {
        Some(path) => {
            let vehicle = &maps.table2.vehicle;
            let torque_nm = arguments.torque_full_scale.or(vehicle.torque_full_scale_nm);
            let imported = read_map(path, FullScale { torque_nm, wheel_radius_m: vehicle.wheel_radius_m })?;
            ui.say(format!("{}: {}, {} table(s)", shown(path), imported.format, imported.tables.len()));
            maps.with_tables(&imported).with_context(|| shown(path))?
        }
        None => maps,
    };
    // a log that cannot be read is an error before the driving
    let (replayed_runs, pivots) = (replay_logs(arguments, &maps, ui)?, pivot_logs(arguments, &maps, ui)?);
    let logs_wanted = arguments.log.is_some();
    let Verified { mut verdict, traces, mut logs } = with_progress("verifying", ui, |progress| {
        Ok(verify_with(&maps, &settings, Wanted { traces: true, logs: logs_wanted, progress: Some(progress), ..Wanted::default() })?)
    })?;
    let at_other_angles = at_angles(&maps, &settings, &arguments.angle)?;
    let judged = with_progress("driving manoeuvres", ui, |progress| {
        let wanted = Wanted { traces: true, logs: logs_wanted, worst_logs: arguments.log_worst, progress: Some(progress) };
        Ok(judge_manoeuvres(&maps, &driven, wanted)?)
    })?;
    logs.extend(judged.logs);
    let scenarios = at_other_angles.into_iter().chain(judged.verdicts).collect();
    verdict.lateral_sha256 = maps.lateral_sha256();
    if !driven.manoeuvres.is_empty() {
        verdict.manoeuvre_vehicle_sha256 = Some(sha256_hex(format!("{:?}", driven.vehicle).as_bytes()));
    }
    verdict = verdict
        .with_scenarios(scenarios, judged.note)
        .with_replayed(replayed_runs, &arguments.accept)
        .with_pivots(pivots, &arguments.accept);
    // the verdict on a file is none on the map of the folder
    if arguments.table.is_none() {
        if let Some(earlier) = earlier(arguments, &folder) {
            verdict = verdict.added_to(&earlier);
        }
        put_verdict(&verdict, traces.as_ref(), &mut folder)?;
        // those of an earlier verdict stay: they name their Table 2
        if let Some(traces) = judged.traces {
            folder.put("manoeuvre_traces.json", traces.to_json()?);
        }
        folder.commit()?;
    }
    ui.document(&verdict)?;
    show(&verdict, ui);
    if arguments.table.is_none() {
        ui.say(format!("written: {}", shown(arguments.maps.join("verify.json"))));
    }
    if let Some(folder) = &arguments.log {
        for log in &logs {
            let path = folder.join(format!("{}.mcap", log.name));
            write_whole(&path, &log.bytes)?;
            ui.detail(format!("written: {}", shown(&path)));
        }
    }
    Ok(verdict.status.into())
}

/// The manoeuvre of a scene file, planned for a vehicle of this wheelbase [m].
fn scene(path: &Path, wheelbase_m: f64) -> anyhow::Result<Manoeuvre> {
    let file = SceneFile::from_toml_for(&read_file(path)?, wheelbase_m).with_context(|| shown(path))?;
    let name = file.scene().name();
    if Scenario::all().iter().any(|s| s.name == name) || Manoeuvre::all().iter().any(|m| m.name == name) {
        bail!("{}: the name {name:?} is that of a scenario of the program (verify --list); give the scene another", shown(path));
    }
    Ok(Manoeuvre::of_scene(file))
}

/// The size of a turn on the command line [°].
fn turn_deg(text: &str) -> Result<f64, String> {
    let allowed = SMALLEST_TURN_DEG..=360.0;
    let size_deg: f64 = text.parse().map_err(|_| "not a number".to_owned())?;
    let is_allowed = allowed.contains(&size_deg);
    is_allowed.then_some(size_deg).ok_or_else(|| format!("allowed: {SMALLEST_TURN_DEG} to 360, both directions are driven"))
}

/// The verdict that the folder holds, to be added to. One that cannot be read is replaced.
fn earlier(arguments: &Arguments, folder: &FolderWriter) -> Option<MapVerdict> {
    if arguments.fresh {
        return None;
    }
    let bytes = folder.view().read("verify.json").ok()?;
    MapVerdict::from_json(std::str::from_utf8(&bytes).ok()?).ok()
}

/// Does `work` with a progress bar on a terminal. `work` calls its argument after every run, with the total number of runs.
fn with_progress<T>(what: &'static str, ui: Ui, work: impl FnOnce(&(dyn Fn(usize) + Sync)) -> anyhow::Result<T>) -> anyhow::Result<T> {
    let bar = ui.progress_runs(what);
    let done = work(&|total| {
        bar.set_length(total as u64);
        bar.inc(1);
    })?;
    bar.finish_and_clear();
    Ok(done)
}

/// The runs of the logs of `--replay`, replayed with the plant of Table 1.
fn replay_logs(arguments: &Arguments, maps: &Maps, ui: Ui) -> anyhow::Result<Vec<ReplayedRun>> {
    if arguments.replay.is_empty() {
        return Ok(Vec::new());
    }
    let logs = LogArguments::of_vehicle(&arguments.replay, arguments.signals.clone(), arguments.preset, &maps.table1.vehicle);
    let mut runs = Vec::new();
    for survey in logs.survey(ui)? {
        runs.extend(replayed(&maps.table1, &survey)?);
    }
    Ok(runs)
}

/// The pivots in the logs of `--pivots`, desired against actual acceleration.
fn pivot_logs(arguments: &Arguments, maps: &Maps, ui: Ui) -> anyhow::Result<Vec<RecordedPivots>> {
    if arguments.pivots.is_empty() {
        return Ok(Vec::new());
    }
    let logs = LogArguments::of_vehicle(&arguments.pivots, arguments.signals.clone(), arguments.preset, &maps.table1.vehicle);
    let mut pivots = Vec::new();
    for (recording, survey) in logs.operation(ui)? {
        pivots.extend(recorded_pivots(&maps.table1, &recording, &survey)?);
    }
    Ok(pivots)
}

/// Groups of scenarios.
const GROUPS: [&str; 3] = ["pivots", "manoeuvres", "all"];

/// The names of all scenarios and manoeuvres, and of the groups.
fn scenario_names() -> Vec<String> {
    let scenarios = Scenario::all().into_iter().map(|s| s.name);
    GROUPS.into_iter().map(str::to_owned).chain(scenarios).chain(Manoeuvre::all().into_iter().map(|m| m.name)).collect()
}

/// The named scenarios and manoeuvres, in the order of the command line; without a name all pivots. Groups: `pivots`, `manoeuvres`, `all`.
fn chosen(names: &[String]) -> Result<(Vec<Scenario>, Vec<Manoeuvre>), Error> {
    let (all, all_manoeuvres) = (Scenario::all(), Manoeuvre::all());
    if names.is_empty() {
        return Ok((all, Vec::new()));
    }
    let known = scenario_names();
    if let Some(name) = names.iter().find(|name| !known.contains(name)) {
        let nearest = known.iter().min_by_key(|known| apart(known, name)).cloned().unwrap_or_default();
        return Err(Error::NoScenario { found: name.clone(), nearest });
    }
    let (mut scenarios, mut manoeuvres): (Vec<Scenario>, Vec<Manoeuvre>) = (Vec::new(), Vec::new());
    for name in names {
        let is = |group: &str, own: &str| name == own || name == group || name == "all";
        for scenario in all.iter().filter(|s| is("pivots", &s.name)) {
            if !scenarios.contains(scenario) {
                scenarios.push(scenario.clone());
            }
        }
        for manoeuvre in all_manoeuvres.iter().filter(|m| is("manoeuvres", &m.name)) {
            if manoeuvres.iter().all(|m| m.name != manoeuvre.name) {
                manoeuvres.push(manoeuvre.clone());
            }
        }
    }
    Ok((scenarios, manoeuvres))
}

/// Distance of a known name from a given one: 0 if it begins with it, otherwise the number of letters to change.
fn apart(known: &str, given: &str) -> usize {
    if !given.is_empty() && known.starts_with(given) { 0 } else { edits(known, given) }
}

fn list(ui: Ui) -> anyhow::Result<()> {
    let (all, manoeuvres) = (Scenario::all(), Manoeuvre::all());
    let documents: Result<Vec<_>, _> = all.iter().map(serde_json::to_value).chain(manoeuvres.iter().map(serde_json::to_value)).collect();
    ui.document(&documents?)?;
    let mut table = new_table(&["scenario", "what"]);
    for (name, what) in all.into_iter().map(|s| (s.name, s.what)).chain(manoeuvres.into_iter().map(|m| (m.name, m.what))) {
        table.add_row([name, what]);
    }
    ui.say(table.to_string());
    Ok(())
}
