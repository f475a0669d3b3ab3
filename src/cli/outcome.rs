//! How a command ended, as its exit status.

/// How a command that did not fail ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Outcome {
    /// Finished, and good.
    Done,
    /// Finished and written, but rejected: the exit status is 3.
    Rejected,
}
