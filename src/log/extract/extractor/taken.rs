//! The values of one message: a slot for each path.

use crate::log::value::Raw;

/// The slots that a plan fills, kept from message to message of one channel.
#[derive(Debug, Default)]
pub(crate) struct Taken<'a> {
    pub(crate) slots: Vec<Raw<'a>>,
    /// The numbers that the elements of slices have for each slot; NaN where an element has none.
    pub(crate) lists: Vec<Vec<f64>>,
    /// The positions of the values in the last message, for plans of CDR or ROS 1.
    pub(crate) shortcut: crate::log::extract::extractor::cdr::shortcut::Shortcut<'a>,
    /// A value was skipped because its sibling array was not read yet.
    pub(crate) again: bool,
}

impl<'a> Taken<'a> {
    pub(crate) fn get(&self, slot: usize) -> &Raw<'a> {
        &self.slots[slot]
    }

    /// The numbers that a slice selected for `slot`, in the array's order.
    pub(crate) fn list(&self, slot: usize) -> &[f64] {
        self.lists.get(slot).map_or(&[], Vec::as_slice)
    }

    /// Moves the values of a slice's element from `slots` to their lists.
    pub(crate) fn keep(&mut self, slots: &[usize]) {
        for &slot in slots {
            if self.lists.len() <= slot {
                self.lists.resize_with(slot + 1, Vec::new);
            }
            let number = match std::mem::take(&mut self.slots[slot]) {
                Raw::Number(value) => value,
                Raw::Integer(value) => value as f64,
                Raw::Text(text) => text.trim().parse().unwrap_or(f64::NAN),
                Raw::Missing => f64::NAN,
            };
            self.lists[slot].push(number);
        }
    }

    pub(crate) fn set(&mut self, slot: usize, value: Raw<'a>) {
        self.slots[slot] = value;
    }

    /// The element selected by the match in a sibling array. While it is not known, records that the walk must be repeated.
    pub(crate) fn register(&mut self, slot: usize) -> Option<u64> {
        if let Raw::Integer(index) = self.slots[slot] {
            Some(index as u64)
        } else {
            self.again = true;
            None
        }
    }

    pub(crate) fn clear(&mut self, slots: &[usize]) {
        for slot in slots {
            self.slots[*slot] = Raw::Missing;
        }
    }
}
