//! The values of one signal, as they are in the messages.

use crate::log::reference_path::Lists;
use crate::log::timing::message_times::{MessageTimes, usual};

/// The values of one signal in the order of the log.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Column {
    pub times: Vec<MessageTimes>,
    pub value: Vec<f64>,
    /// Values that were NaN or infinite: dropped.
    pub not_finite: u64,
    /// The elements selected by a slice: one list per message, instead of the values.
    pub lists: Lists,
}

impl Column {
    pub(crate) fn push(&mut self, times: MessageTimes, value: f64) {
        self.times.push(times);
        self.value.push(value);
    }

    /// Adds the list that a slice selected from a message.
    pub(crate) fn push_list(&mut self, times: MessageTimes, list: impl ExactSizeIterator<Item = f64> + Clone) {
        self.lists.push(usual(&times), list);
    }

    /// Adds the values of the next section of the log.
    pub(crate) fn append(&mut self, next: Self) {
        self.times.extend(next.times);
        self.value.extend(next.value);
        self.not_finite += next.not_finite;
        self.lists.append(next.lists);
    }

    pub(crate) fn len(&self) -> usize {
        self.value.len() + self.lists.len()
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.len() == 0
    }
}
