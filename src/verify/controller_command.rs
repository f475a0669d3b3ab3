//! The command line of a controller that is a process of the user's.

use crate::map::sha256_hex;
use crate::text::shown;
use crate::verify::{Error, Result};
use serde::{Deserialize, Serialize};
use std::path::Path;
use std::process::Command;
use std::time::Duration;

/// A controller under test: a program with its arguments, and the time that it has for each answer.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct ControllerCommand {
    /// The command line, as it was given.
    pub command: String,
    /// Time for each answer [ms].
    pub timeout_ms: u64,
    /// SHA-256 of the file, if it is a shared library.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sha256: Option<String>,
}

/// Extensions of shared libraries.
const LIBRARIES: [&str; 3] = ["so", "dylib", "dll"];

impl ControllerCommand {
    /// From a command line: words between spaces; quotes, single or double, keep spaces in a word. No shell reads it.
    ///
    /// # Errors
    /// No word, a quote that is not closed, a time of 0, or a shared library that cannot be read.
    pub fn new(command: &str, timeout_ms: u64) -> Result<Self> {
        let mut parsed = Self { command: command.to_owned(), timeout_ms, sha256: None };
        let fault = match words(command) {
            None => "a quote is not closed",
            Some(words) if words.first().is_none_or(String::is_empty) => "it names no program",
            Some(_) if timeout_ms == 0 => "no answer can come within 0 ms",
            Some(_) => {
                if parsed.is_library() {
                    let path = parsed.program();
                    let bytes = std::fs::read(&path).map_err(|source| Error::ControllerStart { command: shown(&path), source })?;
                    parsed.sha256 = Some(sha256_hex(&bytes));
                }
                return Ok(parsed);
            }
        };
        Err(Error::ControllerCommand { command: shown(command), fault })
    }

    /// The command as it is shown.
    pub(crate) fn label(&self) -> String {
        let kind = if self.is_library() { "library" } else { "process" };
        format!("the {kind} `{}`", shown(&self.command))
    }

    /// Whether it is a shared library: one word that ends as such.
    pub(crate) fn is_library(&self) -> bool {
        let words = words(&self.command).unwrap_or_default();
        let extension = words.first().and_then(|word| Path::new(word).extension());
        words.len() == 1 && extension.is_some_and(|extension| LIBRARIES.iter().any(|known| extension.eq_ignore_ascii_case(known)))
    }

    /// The program or library. A library in the current folder gets that folder, so that it is not searched for elsewhere.
    pub(crate) fn program(&self) -> String {
        let program = words(&self.command).unwrap_or_default().into_iter().next().unwrap_or_default();
        let bare = self.is_library() && Path::new(&program).components().count() == 1;
        if bare { format!("./{program}") } else { program }
    }

    /// Time for each answer.
    pub(crate) fn timeout(&self) -> Duration {
        Duration::from_millis(self.timeout_ms)
    }

    /// The process, not yet started.
    pub(crate) fn process(&self) -> Command {
        let mut words = words(&self.command).unwrap_or_default().into_iter();
        let mut process = Command::new(words.next().unwrap_or_default());
        process.args(words);
        process
    }
}

/// The words of a command line; `None` if a quote is not closed.
fn words(line: &str) -> Option<Vec<String>> {
    let (mut words, mut word, mut quote): (Vec<String>, Option<String>, Option<char>) = (Vec::new(), None, None);
    for character in line.chars() {
        match (quote, character) {
            (Some(open), _) if open == character => quote = None,
            (None, '\'' | '"') => {
                quote = Some(character);
                word.get_or_insert_default();
            }
            (None, _) if character.is_whitespace() => words.extend(word.take()),
            _ => word.get_or_insert_default().push(character),
        }
    }
    words.extend(word);
    quote.is_none().then_some(words)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn quotes_keep_spaces_and_nothing_else_is_read_into_a_command() {
        assert_eq!(
            words("python3  'my law.py' --gain \"3 4\" a\\b $HOME"),
            Some(["python3", "my law.py", "--gain", "3 4", "a\\b", "$HOME"].map(str::to_owned).to_vec())
        );
        assert_eq!(words("x ''"), Some(vec!["x".to_owned(), String::new()]));
    }

    #[test]
    fn a_command_without_a_program_an_open_quote_and_no_time_are_refused() {
        for (command, timeout_ms, fault) in [(" ", 1, "names no program"), ("a 'b", 1, "quote is not closed"), ("a", 0, "0 ms")] {
            let error = ControllerCommand::new(command, timeout_ms).unwrap_err().to_string();
            assert!(error.contains(fault), "{error}");
        }
    }
}
