//! The times that a log holds for one message, and for those of one signal.

use crate::log::signal_map::SignalName;
use crate::units::NS_PER_S;

/// The times of a message [ns since 1970]; 0 where there is none.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct MessageTimes {
    /// The stamp inside the message.
    pub stamp_ns: i64,
    /// When it was published.
    pub publish_ns: i64,
    /// When it was recorded.
    pub log_ns: i64,
}

/// Which of them a signal uses.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum TimeSource {
    Stamp,
    Publish,
    Log,
}

impl TimeSource {
    /// The name in a note.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Stamp => "stamps",
            Self::Publish => "publish times",
            Self::Log => "log times",
        }
    }

    /// The time of a message by this source, if it has one [ns].
    pub(crate) fn of(self, times: &MessageTimes) -> Option<i64> {
        let time = match self {
            Self::Stamp => times.stamp_ns,
            Self::Publish => times.publish_ns,
            Self::Log => times.log_ns,
        };
        (time != 0 || self == Self::Log).then_some(time)
    }
}

/// The time of a message when nothing is wrong: its stamp, otherwise the time of publication, otherwise that of the log [ns].
pub(crate) fn usual(times: &MessageTimes) -> i64 {
    [TimeSource::Stamp, TimeSource::Publish].iter().find_map(|source| source.of(times)).unwrap_or(times.log_ns)
}

/// The times of one signal, in the order of the log.
#[derive(Debug, Clone)]
pub(crate) struct SignalTimes<'a> {
    pub signal: SignalName,
    pub times: &'a [MessageTimes],
}

/// Fewest messages from which a clock is examined.
pub(crate) const FEWEST: usize = 10;

/// Seconds since `base_ns`.
pub(crate) fn to_s(time_ns: i64, base_ns: i64) -> f64 {
    time_ns.saturating_sub(base_ns) as f64 / NS_PER_S
}

/// The reverse.
pub(crate) fn to_ns(time_s: f64, base_ns: i64) -> i64 {
    base_ns.saturating_add((time_s * NS_PER_S).round() as i64)
}
