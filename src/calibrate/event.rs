//! Events of a stage while it works.

/// An event of a stage while it works.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub enum StageEvent {
    /// A warning; the work continues.
    Warning(String),
    /// A note.
    Note(String),
    /// A detail.
    Detail(String),
    /// More bytes of the logs were read, of `total`.
    Read {
        /// Bytes since the last event.
        bytes: u64,
        /// Bytes of all logs.
        total: u64,
    },
    /// One more simulated run of `total` has ended.
    Simulated {
        /// Total number of runs.
        total: usize,
    },
    /// Reading or simulating is complete.
    Complete,
}

/// A listener; called from any thread.
pub(crate) type Listener<'a> = dyn Fn(StageEvent) + Sync + 'a;
