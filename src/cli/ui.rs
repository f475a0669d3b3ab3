//! Output of a command: summaries and JSON on standard output; errors, warnings and progress on standard error.

use crate::cli::advice::flag_for;
use crate::map::Destination;
use crate::text::{for_json, for_terminal, shown};
use anyhow::bail;
use clap::builder::styling::{AnsiColor, Style};
use std::borrow::Cow;
use std::io::{self, ErrorKind, IsTerminal, Write};
use std::path::Path;
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

/// A good outcome.
const GOOD: Style = AnsiColor::Green.on_default().bold();
/// A bad outcome.
const BAD: Style = AnsiColor::Red.on_default().bold();
/// An outcome to look at.
const DOUBTFUL: Style = AnsiColor::Yellow.on_default().bold();

/// The first error of writing to standard output. What is printed after it would be lost as well.
static LOST: Mutex<Option<io::Error>> = Mutex::new(None);

/// The output of a command.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Ui {
    json: bool,
    quiet: bool,
    verbose: bool,
    /// Whether standard output holds a product, so that the summary goes to standard error.
    product_printed: bool,
}

impl Ui {
    /// `json`: one JSON document instead of text. `quiet`: errors only. `verbose`: more detail.
    pub(crate) fn new(json: bool, quiet: bool, verbose: bool) -> Self {
        Self { json, quiet, verbose, product_printed: false }
    }

    /// The output of a command whose product goes to `output`: if that is standard output, the summary goes to standard error.
    ///
    /// # Errors
    /// `--json`, which would mix with the product.
    pub(crate) fn beside(self, output: Option<&Path>) -> anyhow::Result<Self> {
        match output.filter(|output| Destination::is_standard_output(output)) {
            Some(output) if self.json => {
                bail!("{} and --json both print on standard output; give a file for one of them", shown(output))
            }
            Some(_) => Ok(Self { product_printed: true, ..self }),
            None => Ok(self),
        }
    }

    /// Whether more detail is requested.
    pub(crate) fn is_verbose(self) -> bool {
        self.verbose
    }

    /// A line of the text summary; silent with `--json` or `-q`.
    pub(crate) fn say(self, text: impl AsRef<str>) {
        if self.json || self.quiet {
        } else if self.product_printed {
            let _ = writeln!(anstream::stderr(), "{}", coloured(&for_terminal(text.as_ref())));
        } else {
            print(&coloured(&for_terminal(text.as_ref())));
        }
    }

    /// A line of detail, with `-v` only.
    pub(crate) fn detail(self, text: impl AsRef<str>) {
        if self.verbose {
            self.say(text);
        }
    }

    /// A picture in plain characters: on a terminal, or with `-v`.
    pub(crate) fn picture(self, text: impl AsRef<str>) {
        if self.verbose || io::stdout().is_terminal() {
            self.say(text);
        }
    }

    /// Text that is the command's product (a completion script); always printed.
    pub(crate) fn product(text: impl AsRef<str>) {
        print(text.as_ref());
    }

    /// The JSON document of `--json`; silent without it.
    ///
    /// # Errors
    /// A value that cannot be serialised.
    pub(crate) fn document(self, value: &impl serde::Serialize) -> anyhow::Result<()> {
        if self.json {
            Self::product(for_json(serde_json::to_string_pretty(value)?));
        }
        Ok(())
    }

    /// A warning; the command continues.
    pub(crate) fn warn(self, text: impl AsRef<str>) {
        if !self.quiet {
            let _ = writeln!(anstream::stderr(), "{DOUBTFUL}warning:{DOUBTFUL:#} {}", for_terminal(text.as_ref()));
        }
    }

    /// Why a command finished without writing what it was asked for; also with `--quiet`.
    pub(crate) fn refuse(text: impl AsRef<str>) {
        let _ = writeln!(anstream::stderr(), "{BAD}refused:{BAD:#} {}", for_terminal(text.as_ref()));
    }

    /// The error and its causes on one line, with the flag that helps; with `--json` also as a document on standard output.
    pub(crate) fn error(self, error: &anyhow::Error) {
        let flag = flag_for(error).map_or_else(String::new, |flag| format!("; {flag}"));
        let message = format!("{}{flag}", in_one_line(error));
        let _ = writeln!(anstream::stderr(), "{BAD}error:{BAD:#} {}", for_terminal(&message));
        if self.json {
            Self::error_document(&message, 1);
        }
    }

    /// The JSON document of a command that ended with an error.
    pub(crate) fn error_document(message: &str, status: i32) {
        let document = serde_json::json!({ "error": message.trim_end(), "status": status });
        Self::product(for_json(format!("{document:#}")));
    }

    /// Writes out what is still held back. A reader that has closed the pipe wants no more: that is no error.
    ///
    /// # Errors
    /// Standard output that could not be written to, now or before.
    pub(crate) fn finish() -> anyhow::Result<()> {
        let flushed = io::stdout().flush();
        Self::printed(LOST.lock().unwrap_or_else(PoisonError::into_inner).take().map_or(flushed, Err))
    }

    /// The outcome of printing on standard output, where a closed pipe is no error.
    ///
    /// # Errors
    /// Any other error.
    pub(crate) fn printed(outcome: io::Result<()>) -> anyhow::Result<()> {
        match outcome {
            Err(error) if error.kind() != ErrorKind::BrokenPipe => Err(anyhow::Error::from(error).context("standard output")),
            _ => Ok(()),
        }
    }

    /// A bar that counts up to `total` bytes: drawn on a terminal, silent in a pipe.
    pub(crate) fn progress(self, total: u64, what: &str) -> indicatif::ProgressBar {
        self.bar(total, what, "{msg:14} {bar:32} {bytes}/{total_bytes} {bytes_per_sec} {eta}")
    }

    /// A bar that counts runs: drawn on a terminal, silent in a pipe.
    pub(crate) fn progress_runs(self, what: &str) -> indicatif::ProgressBar {
        self.bar(0, what, "{msg:14} {bar:32} {pos}/{len} runs {eta}")
    }

    fn bar(self, total: u64, what: &str, template: &str) -> indicatif::ProgressBar {
        if self.quiet || self.json || !std::io::stderr().is_terminal() {
            return indicatif::ProgressBar::hidden();
        }
        let bar = indicatif::ProgressBar::new(total);
        if let Ok(style) = indicatif::ProgressStyle::with_template(template) {
            bar.set_style(style);
        }
        bar.set_message(what.to_owned());
        bar.enable_steady_tick(Duration::from_millis(100));
        bar
    }
}

/// Text with its outcomes coloured. The words say the same: no colour is needed to read them.
fn coloured(text: &str) -> Cow<'_, str> {
    const OUTCOMES: [(&str, Style); 6] = [
        ("verdict: pass", GOOD),
        ("verdict: FAIL", BAD),
        ("verdict: rejected", BAD),
        ("verdict: not judged", DOUBTFUL),
        ("objection: ", BAD),
        (" FAIL ", BAD),
    ];
    let mut text = Cow::Borrowed(text);
    for (words, style) in OUTCOMES {
        if text.contains(words) {
            text = Cow::Owned(text.replace(words, &format!("{style}{words}{style:#}")));
        }
    }
    text
}

/// Prints a line on standard output, unless it is broken.
fn print(line: &str) {
    let mut lost = LOST.lock().unwrap_or_else(PoisonError::into_inner);
    if lost.is_none() {
        *lost = writeln!(anstream::stdout(), "{line}").err();
    }
}

/// An error and its causes, each once: some messages end with their cause, and some causes begin with what was said before.
fn in_one_line(error: &anyhow::Error) -> String {
    let mut line = String::new();
    let mut last = 0; // where the last cause begins in the line
    for cause in error.chain().map(ToString::to_string) {
        if line.contains(&cause) {
            continue;
        }
        if cause.starts_with(&line[last..]) {
            line.truncate(last);
        } else {
            line.push_str(": ");
            last = line.len();
        }
        line.push_str(&cause);
    }
    line
}

#[cfg(test)]
mod tests {
    use super::*;
    use anyhow::anyhow;

    #[derive(Debug, thiserror::Error)]
    #[error("table1.json: {source}")]
    struct WithItsCause {
        source: io::Error,
    }

    #[test]
    fn outcomes_are_coloured_and_nothing_else() {
        assert_eq!(coloured("verdict: pass: 90° only"), format!("{GOOD}verdict: pass{GOOD:#}: 90° only"));
        assert_eq!(coloured("│ 61° ┆ FAIL │"), format!("│ 61° ┆{BAD} FAIL {BAD:#}│"));
        assert!(matches!(coloured("a passage"), Cow::Borrowed("a passage")));
    }

    #[test]
    fn each_cause_is_printed_once() {
        let inner = || WithItsCause { source: io::Error::other("the disk is full") };
        assert_eq!(in_one_line(&anyhow!(inner())), "table1.json: the disk is full");
        assert_eq!(in_one_line(&anyhow!(inner()).context("table1.json")), "table1.json: the disk is full");
        assert_eq!(in_one_line(&anyhow!(inner()).context("maps")), "maps: table1.json: the disk is full");
        assert_eq!(in_one_line(&anyhow!("alone")), "alone");
    }
}
