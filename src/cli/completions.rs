//! `completions SHELL`: a script that completes commands and flags.

use crate::cli::Ui;
use crate::cli::outcome::Outcome;

/// Arguments of `completions`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  pivot-cal completions bash > ~/.local/share/bash-completion/completions/pivot-cal")]
pub(crate) struct Arguments {
    /// The shell to complete in
    shell: clap_complete::Shell,
}

/// Writes the script for `command`, the whole command line.
pub(crate) fn run(arguments: &Arguments, mut command: clap::Command) -> anyhow::Result<Outcome> {
    let mut script = Vec::new();
    clap_complete::generate(arguments.shell, &mut command, "pivot-cal", &mut script);
    // for bash, the generator calls a command below one with a hyphen in its name by two names (clap_complete 4.6)
    let script = String::from_utf8(script)?.replace("pivot__subcmd__cal", "pivot__cal");
    Ui::product(script);
    Ok(Outcome::Done)
}
