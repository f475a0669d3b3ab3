//! Output of a command: summaries and JSON on standard output; errors, warnings and progress on standard error.

use crate::cli::advice::flag_for;
use std::io::{IsTerminal, Write};
use std::time::Duration;

/// The output of a command.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Ui {
    json: bool,
    quiet: bool,
    verbose: bool,
}

impl Ui {
    /// `json`: one JSON document instead of text. `quiet`: errors only. `verbose`: more detail.
    pub(crate) fn new(json: bool, quiet: bool, verbose: bool) -> Self {
        Self { json, quiet, verbose }
    }

    /// Whether more detail is requested.
    pub(crate) fn is_verbose(self) -> bool {
        self.verbose
    }

    /// A line of the text summary; silent with `--json` or `-q`.
    pub(crate) fn say(self, text: impl AsRef<str>) {
        if !self.json && !self.quiet {
            let _ = writeln!(anstream::stdout(), "{}", text.as_ref());
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
        if self.verbose || std::io::stdout().is_terminal() {
            self.say(text);
        }
    }

    /// Text that is the command's product (a completion script); always printed.
    pub(crate) fn product(text: impl AsRef<str>) {
        let _ = writeln!(anstream::stdout(), "{}", text.as_ref());
    }

    /// The JSON document of `--json`; silent without it.
    ///
    /// # Errors
    /// A value that cannot be serialised.
    pub(crate) fn document(self, value: &impl serde::Serialize) -> anyhow::Result<()> {
        if self.json {
            Self::product(serde_json::to_string_pretty(value)?);
        }
        Ok(())
    }

    /// A warning; the command continues.
    pub(crate) fn warn(self, text: impl AsRef<str>) {
        if !self.quiet {
            let _ = writeln!(anstream::stderr(), "warning: {}", text.as_ref());
        }
    }

    /// The error and its causes on one line, with the flag that helps.
    pub(crate) fn error(error: &anyhow::Error) {
        let flag = flag_for(error).map_or_else(String::new, |flag| format!("; {flag}"));
        let _ = writeln!(anstream::stderr(), "error: {error:#}{flag}");
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
