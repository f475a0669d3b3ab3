//! Outcome of a command, as its exit status.

use crate::verify::Status;

/// Outcome of a command that did not fail.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Outcome {
    /// Finished, and good.
    Done,
    /// Finished and written, but rejected: the exit status is 3.
    Rejected,
    /// Finished and written, but too little was driven to judge: the exit status is 1.
    NotJudged,
}

impl From<Status> for Outcome {
    fn from(status: Status) -> Self {
        match status {
            Status::Pass => Self::Done,
            Status::Fail | Status::Rejected => Self::Rejected,
            Status::NotJudged | Status::NotTested => Self::NotJudged,
        }
    }
}
