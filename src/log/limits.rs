//! How much of a log is kept in memory. What needs more is refused with the number; `fit --help` names them.

/// Values of all signals together: 128 million, 32 bytes each while a log is read and 16 afterwards. Five signals at 100 Hz give as many in
/// three days.
pub(crate) const MOST_VALUES: u64 = 128 << 20;

/// Schemas and metadata of a log, and one message of each topic [bytes]. Those of robots have less than a megabyte.
pub(crate) const MOST_DESCRIPTION: u64 = 256 << 20;
