//! The command line: arguments, files opened and saved, printing, exit status. The other modules do not depend on it.
//!
//! Exit status: 0 done, 1 error or nothing judged, 2 usage, 3 finished but rejected (verification failed, a check objects, a finding), 101 a
//! fault of the program.

mod advice;
mod angles;
mod breaks;
mod calibrate;
mod check;
mod completions;
mod controller_file;
mod diff;
mod export;
mod fault;
mod fit;
mod inspect;
mod inspect_runs;
mod invert;
mod lateral;
mod listener;
mod logs;
mod manual;
mod one_of;
pub(crate) mod outcome;
mod plan;
mod points;
mod record;
mod report;
mod text_file;
mod tune;
mod ui;
mod verify;
mod verify_text;

use crate::cli::outcome::Outcome;
use clap::{Args, Command, CommandFactory, FromArgMatches, Parser, Subcommand};
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
    /// Colour the output: auto (on a terminal, unless NO_COLOR is set), always or never
    #[arg(long, global = true, value_name = "WHEN", default_value = "auto", hide_default_value = true, hide_possible_values = true)]
    color: clap::ColorChoice,
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
    /// Judge any map: ours and its exports, Autoware's, Apollo's, long-form CSV
    Check(check::Arguments),
    /// Write the map as C, Rust, Autoware CSV, Apollo text, DCM, CDFX, A2L or JSON
    Export(export::Arguments),
    /// Show the changes between two maps, and whether they are significant
    Diff(diff::Arguments),
    /// Find gains and preview of the controller for a map and its vehicle
    Tune(tune::Arguments),
    /// Plan the next runs: those that reduce the standard errors most, as a campaign file
    Plan(plan::Arguments),
    /// Print a completion script for a shell
    Completions(completions::Arguments),
    /// Write the manual pages, one for each command
    Man(manual::Arguments),
}

/// Runs the program with `args`, the first is its name; returns the process's exit status.
pub fn run(args: impl IntoIterator<Item = OsString>) -> ExitCode {
    fault::report_panics();
    let args: Vec<OsString> = args.into_iter().collect();
    let json = args.iter().any(|argument| argument == "--json");
    let parsed = command().try_get_matches_from(args).and_then(|matches| Cli::from_arg_matches(&matches));
    let cli = match parsed {
        Ok(cli) => cli,
        Err(error) => {
            // help and version are "errors" of status 0; usage errors have status 2
            let status = ExitCode::from(u8::try_from(error.exit_code()).unwrap_or(2));
            if json && error.use_stderr() {
                Ui::error_document(&error.render().to_string(), error.exit_code());
            }
            let printed = error.print();
            return if error.use_stderr() {
                status
            } else {
                ending(Ui::printed(printed).and(Ui::finish()), status, Ui::new(false, false, false))
            };
        }
    };
    match cli.global.color {
        clap::ColorChoice::Auto => anstream::ColorChoice::Auto,
        clap::ColorChoice::Always => anstream::ColorChoice::Always,
        clap::ColorChoice::Never => anstream::ColorChoice::Never,
    }
    .write_global();
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
        CliCommand::Tune(arguments) => tune::run(&arguments, ui),
        CliCommand::Plan(arguments) => plan::run(&arguments, ui),
        CliCommand::Completions(arguments) => completions::run(&arguments, command()),
        CliCommand::Man(arguments) => manual::run(&arguments, command(), ui),
    };
    let status = match outcome {
        Ok(Outcome::Done) => ExitCode::SUCCESS,
        Ok(Outcome::Rejected) => ExitCode::from(3),
        Ok(Outcome::NotJudged) => ExitCode::from(1),
        Err(error) => {
            ui.error(&error);
            return ending(Ui::finish(), ExitCode::from(1), ui);
        }
    };
    ending(Ui::finish(), status, ui)
}

/// The exit status of a command, or 1 if what it printed was lost.
fn ending(printed: anyhow::Result<()>, status: ExitCode, ui: Ui) -> ExitCode {
    match printed {
        Ok(()) => status,
        Err(error) => {
            ui.error(&error);
            ExitCode::from(1)
        }
    }
}

/// The command line. An option's value may begin with a minus: `--wheelbase-m -1` is an error about the value, not about an option `-1`.
fn command() -> Command {
    with_negative_values(Cli::command())
}

fn with_negative_values(command: Command) -> Command {
    let command = command.mut_args(|argument| {
        let takes_value = argument.get_action().takes_values() && !argument.is_positional();
        if takes_value && !argument.is_allow_hyphen_values_set() { argument.allow_negative_numbers(true) } else { argument }
    });
    command.mut_subcommands(with_negative_values)
}

/// Runs one stage under its own program name: `pivot-cal-fit ARGS` is `pivot-cal fit ARGS`.
pub fn run_stage(stage: &str, args: impl IntoIterator<Item = OsString>) -> ExitCode {
    let mut args = args.into_iter();
    let program = args.next().unwrap_or_else(|| "pivot-cal".into());
    run([program, stage.into()].into_iter().chain(args))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    /// Every option with a value of the command and those below it, as the words that lead to it.
    fn options(command: &Command, words: &[String], found: &mut Vec<Vec<String>>) {
        for argument in command.get_arguments().filter(|a| a.get_action().takes_values() && !a.is_positional()) {
            let option = format!("--{}", argument.get_long().unwrap());
            found.push(words.iter().cloned().chain([option]).collect());
        }
        for below in command.get_subcommands() {
            let words: Vec<String> = words.iter().cloned().chain([below.get_name().to_owned()]).collect();
            options(below, &words, found);
        }
    }

    #[test]
    fn a_value_with_a_minus_is_a_value_of_every_option() {
        let mut found = Vec::new();
        options(&command(), &["pivot-cal".to_owned()], &mut found);
        assert!(found.len() > 60, "{}", found.len());
        for words in found {
            let error = command().try_get_matches_from(words.iter().map(String::as_str).chain(["-1"])).err();
            let kind = error.as_ref().map(clap::Error::kind);
            assert_ne!(kind, Some(clap::error::ErrorKind::UnknownArgument), "{words:?}: {}", error.unwrap());
        }
    }
}
