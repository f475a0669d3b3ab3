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
    Ui::product(String::from_utf8(script)?);
    Ok(Outcome::Done)
}
