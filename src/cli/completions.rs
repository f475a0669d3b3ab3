//! `completions SHELL`: a script that completes commands and flags.

use crate::cli::{Cli, Outcome, Ui};
use clap::CommandFactory;

/// Arguments of `completions`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  pivot-cal completions bash > ~/.local/share/bash-completion/completions/pivot-cal")]
pub(crate) struct Arguments {
    /// The shell to complete in
    shell: clap_complete::Shell,
}

pub(crate) fn run(arguments: &Arguments, ui: Ui) -> anyhow::Result<Outcome> {
    let mut script = Vec::new();
    clap_complete::generate(arguments.shell, &mut Cli::command(), "pivot-cal", &mut script);
    ui.product(String::from_utf8(script)?);
    Ok(Outcome::Done)
}
