//! `man`: the manual pages, one for each command.

use crate::cli::Ui;
use crate::cli::outcome::Outcome;
use crate::map::write_whole;
use crate::text::shown;
use anyhow::Context as _;
use std::path::PathBuf;

/// Arguments of `man`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  pivot-cal man
  man ./man/pivot-cal-fit.1
  pivot-cal man --output ~/.local/share/man/man1    then: man pivot-cal-fit")]
pub(crate) struct Arguments {
    /// Folder to write into; made if it is not there
    #[arg(short, long, value_name = "DIR", default_value = "man")]
    output: PathBuf,
}

/// Writes the page of `command`, the whole command line, and of every command below it.
pub(crate) fn run(arguments: &Arguments, mut command: clap::Command, ui: Ui) -> anyhow::Result<Outcome> {
    command.build();
    std::fs::create_dir_all(&arguments.output).with_context(|| shown(&arguments.output))?;
    let mut written = Vec::new();
    write(&command, "pivot-cal", arguments, &mut written)?;
    ui.say(format!("written: {} pages into {}", written.len(), shown(&arguments.output)));
    ui.document(&written)?;
    Ok(Outcome::Done)
}

/// The page of a command under its full name, such as `pivot-cal-fit`, and those below it.
fn write(command: &clap::Command, name: &str, arguments: &Arguments, written: &mut Vec<String>) -> anyhow::Result<()> {
    let mut page = Vec::new();
    clap_mangen::Man::new(command.clone().name(name.to_owned())).render(&mut page)?;
    let path = arguments.output.join(format!("{name}.1"));
    write_whole(&path, &page)?;
    written.push(shown(&path));
    // `help COMMAND` prints what the page of the command says
    for below in command.get_subcommands().filter(|below| below.get_name() != "help") {
        write(below, &format!("{name}-{}", below.get_name()), arguments, written)?;
    }
    Ok(())
}
