//! Outcome of a command, as its exit status.

/// Outcome of a command that did not fail.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Outcome {
    /// Finished, and good.
    Done,
    /// Finished and written, but rejected: the exit status is 3.
    Rejected,
}
