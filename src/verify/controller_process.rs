//! A process that is asked one line and answers one line, within a time.
//!
//! A thread reads the answers, so that a process that keeps silent, floods or never ends a line holds nobody up; another one keeps
//! the end of its standard error.

use crate::text::name_from_outside;
use crate::verify::controller_command::ControllerCommand;
use crate::verify::{Error, Result};
use std::io::{BufRead, BufReader, Read, Write};
use std::process::{Child, ChildStdin, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, sync_channel};
use std::time::{Duration, Instant};

/// Longest answer [bytes].
const LONGEST_ANSWER: usize = 65_536;
/// What is kept of standard error [bytes].
const KEPT_ERRORS: usize = 4096;
/// Time in which a process ends by itself after the end of its input.
const GRACE: Duration = Duration::from_millis(500);

/// An answer as it was read.
enum AnswerLine {
    Line(String),
    /// The beginning of a line that is longer than allowed.
    TooLong(String),
}

/// Why a process gave no answer.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub(crate) enum ProcessFault {
    #[error("no answer within {0} ms")]
    Late(u128),
    #[error("it answered `{0}` before it was asked")]
    Unasked(String),
    #[error("an answer is longer than {LONGEST_ANSWER} bytes; it begins with `{0}`")]
    TooLong(String),
    #[error("it ended ({how}) instead of answering{last_words}")]
    Ended { how: String, last_words: String },
}

/// A running process.
pub(crate) struct ControllerProcess {
    child: Child,
    /// `None` once it is to end.
    questions: Option<ChildStdin>,
    answers: Receiver<AnswerLine>,
    errors: Receiver<Vec<u8>>,
    timeout: Duration,
}

impl ControllerProcess {
    /// Starts the process.
    ///
    /// # Errors
    /// A program that cannot be started.
    pub(crate) fn start(command: &ControllerCommand) -> Result<Self> {
        let failed = |source| Error::ControllerStart { command: command.label(), source };
        let mut process = command.process();
        process.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut child = process.spawn().map_err(failed)?;
        let (questions, output, errors) = (child.stdin.take(), child.stdout.take(), child.stderr.take());
        let (put_answer, answers) = sync_channel(1);
        let (put_errors, kept_errors) = sync_channel(1);
        // both end with the process's ends of the pipes
        std::thread::spawn(move || {
            let mut output = output.map(BufReader::new);
            while let Some(answer) = output.as_mut().and_then(next_answer) {
                let is_last = matches!(answer, AnswerLine::TooLong(_));
                if put_answer.send(answer).is_err() || is_last {
                    break;
                }
            }
        });
        std::thread::spawn(move || put_errors.send(errors.map(end_of).unwrap_or_default()));
        Ok(Self { child, questions, answers, errors: kept_errors, timeout: command.timeout() })
    }

    /// Writes a line that needs no answer. That the process has ended is found with the next question.
    pub(crate) fn say(&mut self, line: &str) {
        if let Some(questions) = &mut self.questions {
            _ = questions.write_all(format!("{line}\n").as_bytes());
        }
    }

    /// Writes a line and waits for the answer.
    ///
    /// # Errors
    /// No answer in time, one that was not asked for, one without end, or the end of the process.
    pub(crate) fn ask(&mut self, line: &str) -> std::result::Result<String, ProcessFault> {
        match self.answers.try_recv() {
            Ok(AnswerLine::Line(answer)) => return Err(ProcessFault::Unasked(name_from_outside(&answer).into_owned())),
            Ok(AnswerLine::TooLong(start)) => return Err(ProcessFault::TooLong(name_from_outside(&start).into_owned())),
            Err(_) => {}
        }
        self.say(line);
        match self.answers.recv_timeout(self.timeout) {
            Ok(AnswerLine::Line(answer)) => Ok(answer),
            Ok(AnswerLine::TooLong(start)) => Err(ProcessFault::TooLong(name_from_outside(&start).into_owned())),
            Err(RecvTimeoutError::Timeout) => {
                self.end_now();
                Err(ProcessFault::Late(self.timeout.as_millis()))
            }
            Err(RecvTimeoutError::Disconnected) => Err(self.ended()),
        }
    }

    /// How the process ended, with its last line on standard error.
    fn ended(&mut self) -> ProcessFault {
        let how = match self.wait(GRACE) {
            Some(status) => status.to_string(),
            None => "its standard output is closed".to_owned(),
        };
        let errors = self.errors.recv_timeout(GRACE).unwrap_or_default();
        let errors = String::from_utf8_lossy(&errors);
        let last = errors.lines().rfind(|line| !line.trim().is_empty());
        let last_words = last.map_or(String::new(), |line| format!("; its last line on standard error: `{}`", name_from_outside(line)));
        ProcessFault::Ended { how, last_words }
    }

    /// Waits for the end of the process.
    fn wait(&mut self, at_most: Duration) -> Option<std::process::ExitStatus> {
        let begun = Instant::now();
        loop {
            if let Ok(Some(status)) = self.child.try_wait() {
                return Some(status);
            }
            if begun.elapsed() >= at_most {
                return None;
            }
            std::thread::sleep(Duration::from_millis(1));
        }
    }

    /// Ends the process without waiting for it to do so by itself.
    fn end_now(&mut self) {
        self.questions = None;
        _ = self.child.kill();
        _ = self.child.wait();
    }
}

impl Drop for ControllerProcess {
    fn drop(&mut self) {
        if self.questions.take().is_some() && self.wait(GRACE).is_some() {
            return;
        }
        self.end_now();
    }
}

/// The next line; `None` at the end.
fn next_answer(output: &mut impl BufRead) -> Option<AnswerLine> {
    let mut line = Vec::new();
    // one byte more than allowed shows that it is too long
    output.take(LONGEST_ANSWER as u64 + 1).read_until(b'\n', &mut line).ok()?;
    if line.is_empty() {
        return None;
    }
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).trim_end().to_owned();
    Some(if line.len() > LONGEST_ANSWER { AnswerLine::TooLong(text(&line[..200])) } else { AnswerLine::Line(text(&line)) })
}

/// The end of what a stream holds.
fn end_of(mut stream: impl Read) -> Vec<u8> {
    let (mut kept, mut chunk) = (Vec::new(), [0; KEPT_ERRORS]);
    while let Ok(count @ 1..) = stream.read(&mut chunk) {
        kept.extend_from_slice(&chunk[..count]);
        kept.drain(..kept.len().saturating_sub(KEPT_ERRORS));
    }
    kept
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn a_line_ends_at_its_line_end_or_at_the_end_of_the_output_and_is_never_longer_than_allowed() {
        let mut output = BufReader::new(&b"one\r\ntwo"[..]);
        for expected in ["one", "two"] {
            assert!(matches!(next_answer(&mut output), Some(AnswerLine::Line(line)) if line == expected));
        }
        assert!(next_answer(&mut output).is_none());
        let long = vec![b'7'; 3 * LONGEST_ANSWER];
        assert!(matches!(next_answer(&mut BufReader::new(&long[..])), Some(AnswerLine::TooLong(start)) if start.len() == 200));
    }

    #[test]
    fn of_standard_error_the_end_is_kept() {
        let text = [vec![b'a'; 3 * KEPT_ERRORS], b"\nthe cause\n".to_vec()].concat();
        let kept = end_of(&text[..]);
        assert!(kept.len() <= KEPT_ERRORS && kept.ends_with(b"\nthe cause\n"));
    }
}
