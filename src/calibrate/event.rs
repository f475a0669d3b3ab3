//! What a stage says while it works.

/// What a stage says while it works.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub enum StageEvent {
    /// Something that the user should know although the work goes on.
    Warning(String),
    /// Something worth reading.
    Note(String),
    /// Something for those who ask for more.
    Detail(String),
    /// So many more bytes of the logs, of `total`, were read.
    Read {
        /// Bytes since the last event.
        bytes: u64,
        /// Bytes of all logs.
        total: u64,
    },
    /// One more simulated run of `total` has ended.
    Simulated {
        /// Runs in all.
        total: usize,
    },
    /// What was read or simulated is complete.
    Complete,
}

/// Who listens; called from any thread.
pub type Listener<'a> = dyn Fn(StageEvent) + Sync + 'a;
