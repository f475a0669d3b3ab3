//! The last resort: what a person reads when the program itself is wrong.

use crate::log::columns::foreign_panics::is_caught;
use crate::text::{for_terminal, shown};
use std::panic::PanicHookInfo;

/// Makes a panic ask for a report in place of a message for programmers. The process then ends with exit status 101.
pub(crate) fn report_panics() {
    std::panic::set_hook(Box::new(|fault| {
        if is_caught() {
            return; // of a parser that is not ours, on a damaged file: it becomes an error
        }
        let message = fault.payload_as_str().unwrap_or("no message");
        let report = report(message, place(fault).as_deref(), std::env::args_os());
        let _ = std::io::Write::write_all(&mut anstream::stderr(), report.as_bytes());
    }));
}

fn place(fault: &PanicHookInfo<'_>) -> Option<String> {
    fault.location().map(|at| format!("{}:{}", at.file(), at.line()))
}

/// The request for a report: what happened, where, in which version and by which command.
fn report(message: &str, place: Option<&str>, arguments: impl Iterator<Item = std::ffi::OsString>) -> String {
    let command: Vec<String> = arguments.map(shown).collect();
    let text = format!(
        "error: this is a fault of pivot-cal, not of your data. Please report it with the lines below and, if you can, with the input.\n\
         \x20 fault    {message}, at {}\n  version  {} ({} {})\n  command  {}\n",
        place.unwrap_or("an unknown place"),
        env!("CARGO_PKG_VERSION"),
        std::env::consts::OS,
        std::env::consts::ARCH,
        command.join(" ")
    );
    for_terminal(&text).into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_report_names_fault_place_version_and_command() {
        let text = report("index out of bounds", Some("src/fit.rs:7"), ["pivot-cal", "fit", "a\u{1b}[2J.mcap"].into_iter().map(Into::into));
        for part in ["Please report", "index out of bounds, at src/fit.rs:7", env!("CARGO_PKG_VERSION"), "pivot-cal fit a\\u{1b}[2J.mcap"] {
            assert!(text.contains(part), "{part}: {text}");
        }
    }
}
