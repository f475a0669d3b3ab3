//! The values of one signal, as they are in the messages.

use crate::log::Signal;
use crate::log::reference_path::Lists;
use crate::units::NS_PER_S;

/// Largest number of messages used to estimate the offset between stamps and log time.
const CLOCK_SAMPLES: usize = 4096;

/// The values of one signal in the order of the log.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Column {
    time_ns: Vec<i64>,
    value: Vec<f64>,
    /// Stamp minus log time of the first messages [ns].
    apart_ns: Vec<i64>,
    /// Values that were NaN or infinite: dropped.
    pub not_finite: u64,
    /// The elements selected by a slice: one list per message, instead of the values.
    pub lists: Lists,
}

impl Column {
    pub(crate) fn push(&mut self, time_ns: i64, log_time_ns: i64, value: f64) {
        self.time_ns.push(time_ns);
        self.value.push(value);
        if self.apart_ns.len() < CLOCK_SAMPLES {
            self.apart_ns.push(time_ns.saturating_sub(log_time_ns));
        }
    }

    /// Adds the list that a slice selected from a message.
    pub(crate) fn push_list(&mut self, time_ns: i64, log_time_ns: i64, list: impl ExactSizeIterator<Item = f64> + Clone) {
        self.lists.push(time_ns, list);
        if self.apart_ns.len() < CLOCK_SAMPLES {
            self.apart_ns.push(time_ns.saturating_sub(log_time_ns));
        }
    }

    /// Adds the values of the next section of the log.
    pub(crate) fn append(&mut self, next: Self) {
        self.time_ns.extend(next.time_ns);
        self.value.extend(next.value);
        let room = CLOCK_SAMPLES - self.apart_ns.len();
        self.apart_ns.extend(next.apart_ns.into_iter().take(room));
        self.not_finite += next.not_finite;
        self.lists.append(next.lists);
    }

    pub(crate) fn len(&self) -> usize {
        self.value.len() + self.lists.len()
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Median offset of the stamps from the log time [s], if it is too large to be a delay.
    pub(crate) fn clock_offset_s(&self) -> Option<f64> {
        let mut apart = self.apart_ns.clone();
        let middle = apart.len() / 2;
        let median = (!apart.is_empty()).then(|| *apart.select_nth_unstable(middle).1)?;
        let seconds = median as f64 / NS_PER_S;
        (seconds.abs() > 60.0).then_some(seconds)
    }

    /// The signal: sorted by time, equal times in the order of the log.
    pub(crate) fn into_signal(self, relative_to_gear: bool, unsigned: bool) -> Signal {
        let mut signal = Signal { time_ns: self.time_ns, value: self.value, relative_to_gear, unsigned };
        signal.sort();
        signal
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn values_are_sorted_by_time_and_equal_times_keep_their_order() {
        let mut column = Column::default();
        for (time_ns, value) in [(30, 1.0), (10, 2.0), (20, 3.0), (10, 4.0)] {
            column.push(time_ns, time_ns, value);
        }
        let signal = column.into_signal(false, false);
        assert_eq!((signal.time_ns, signal.value), (vec![10, 10, 20, 30], vec![2.0, 4.0, 3.0, 1.0]));
    }

    #[test]
    fn stamps_of_another_clock_are_reported_and_delay_is_not() {
        let offset = |apart_s: i64| {
            let mut column = Column::default();
            (0..10_000).for_each(|n| column.push(n + apart_s * 1_000_000_000, n, 0.0));
            column.clock_offset_s()
        };
        assert_eq!(offset(-3600), Some(-3600.0));
        assert_eq!(offset(-30), None);
    }
}
