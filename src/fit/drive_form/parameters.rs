//! Numbers of the parameters of a drive.

/// Most parameters of a drive: three times, and the logarithm of its limit.
pub(crate) const PARAMETERS: usize = 4;
/// Number of the limit's parameter.
pub(crate) const LIMIT: usize = 3;
