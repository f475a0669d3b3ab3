//! The command line: arguments, files opened and saved, printing, exit status. The other modules do not depend on it.
//!
//! Exit status: 0 done, 1 error or nothing judged, 2 usage, 3 finished but rejected (verification failed, a check objects, a finding).

mod advice;
mod angles;
mod breaks;
mod calibrate;
mod check;
mod completions;
mod diff;
mod export;
mod fit;
mod inspect;
mod inspect_runs;
mod invert;
mod lateral;
mod listener;
mod logs;
pub(crate) mod outcome;
mod plan;
mod points;
mod record;
mod report;
mod ui;
mod verify;
mod verify_text;

use crate::cli::outcome::Outcome;
use clap::{Args, CommandFactory, Parser, Subcommand};
use std::ffi::OsString;
use std::process::ExitCode;

pub(crate) use ui::Ui;

/// Calibrate the torque map of a vehicle that pivots on its driven front wheel.
#[derive(Debug, Parser)]
#[command(
    name = "pivot-cal",
    version,
    about,
    max_term_width = 120,
    after_help = "\
Example: from logs to a verified map in ./maps
  pivot-cal fit logs.mcap
  pivot-cal invert
  pivot-cal verify"
)]
struct Cli {
    #[command(flatten)]
    global: Global,
    #[command(subcommand)]
    command: CliCommand,
}

/// Options of every command.
#[derive(Debug, Clone, Args)]
struct Global {
    /// Print one JSON document instead of a text summary
    #[arg(long, global = true)]
    json: bool,
    /// Print errors only
    #[arg(short, long, global = true, conflicts_with = "verbose")]
    quiet: bool,
    /// Print more detail
    #[arg(short, long, global = true)]
    verbose: bool,
}

#[derive(Debug, Subcommand)]
enum CliCommand {
    /// Drive a torque-step campaign on a simulated vehicle and write its log
    Record(record::Arguments),
    /// Show the content of logs: topics, time span, and the signals found
    Inspect(inspect::Arguments),
    /// Fit Table 1, acceleration over speed and torque, to logs
    Fit(fit::Arguments),
    /// Invert Table 1 into Table 2, torque over speed and desired acceleration
    Invert(invert::Arguments),
    /// Judge a map in closed loop: pivots, failures, perturbed plants, comparison with other laws
    Verify(verify::Arguments),
    /// Calibrate out a constant lateral error: record runs, fit the compensation table
    Lateral(lateral::Arguments),
    /// Write the page with the verdict on a map
    Report(report::Arguments),
    /// Fit, invert, verify and report in one go
    Calibrate(calibrate::Arguments),
    /// Judge any map: ours, Autoware's, Apollo's, long-form CSV
    Check(check::Arguments),
    /// Write the map as C, Rust, Autoware CSV, Apollo text, DCM, CDFX or JSON
    Export(export::Arguments),
    /// Show the changes between two maps, and whether they are significant
    Diff(diff::Arguments),
    /// Plan the next runs: those that reduce the standard errors most, as a campaign file
    Plan(plan::Arguments),
    /// Print a completion script for a shell
    Completions(completions::Arguments),
}

/// Runs the program with `args`, the first is its name; returns the process's exit status.
pub fn run(args: impl IntoIterator<Item = OsString>) -> ExitCode {
    let cli = match Cli::try_parse_from(args) {
        Ok(cli) => cli,
        Err(error) => {
            // help and version are "errors" of status 0; usage errors have status 2
            let _ = error.print();
            return ExitCode::from(u8::try_from(error.exit_code()).unwrap_or(2));
        }
    };
    let ui = Ui::new(cli.global.json, cli.global.quiet, cli.global.verbose);
    let outcome = match cli.command {
        CliCommand::Record(arguments) => record::run(&arguments, ui),
        CliCommand::Fit(arguments) => fit::run(&arguments, ui),
        CliCommand::Invert(arguments) => invert::run(&arguments, ui),
        CliCommand::Verify(arguments) => verify::run(&arguments, ui),
        CliCommand::Lateral(arguments) => lateral::run(&arguments, ui),
        CliCommand::Report(arguments) => report::run(&arguments, ui),
        CliCommand::Calibrate(arguments) => calibrate::run(&arguments, ui),
        CliCommand::Inspect(arguments) => inspect::run(&arguments, ui),
        CliCommand::Check(arguments) => check::run(&arguments, ui),
        CliCommand::Export(arguments) => export::run(&arguments, ui),
        CliCommand::Diff(arguments) => diff::run(&arguments, ui),
        CliCommand::Plan(arguments) => plan::run(&arguments, ui),
        CliCommand::Completions(arguments) => completions::run(&arguments, Cli::command()),
    };
    match outcome {
        Ok(Outcome::Done) => ExitCode::SUCCESS,
        Ok(Outcome::Rejected) => ExitCode::from(3),
        Ok(Outcome::NotJudged) => ExitCode::from(1),
        Err(error) => {
            Ui::error(&error);
            ExitCode::from(1)
        }
    }
}

/// Runs one stage under its own program name: `pivot-cal-fit ARGS` is `pivot-cal fit ARGS`.
pub fn run_stage(stage: &str, args: impl IntoIterator<Item = OsString>) -> ExitCode {
    let mut args = args.into_iter();
    let program = args.next().unwrap_or_else(|| "pivot-cal".into());
    run([program, stage.into()].into_iter().chain(args))
}
