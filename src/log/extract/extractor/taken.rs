//! What one message gives: a slot for each path.

use crate::log::value::Raw;

/// The slots that a plan fills, kept from message to message of one channel.
#[derive(Debug, Default)]
pub(crate) struct Taken<'a> {
    pub(crate) slots: Vec<Raw<'a>>,
    /// What the elements of slices had for each slot, as numbers; NaN where an element holds none.
    pub(crate) lists: Vec<Vec<f64>>,
    /// Where the last message of a plan for CDR or ROS 1 had its values.
    pub(crate) shortcut: crate::log::extract::extractor::cdr::shortcut::Shortcut<'a>,
    /// A value was passed over because its sibling array had not been seen yet.
    pub(crate) again: bool,
}

impl<'a> Taken<'a> {
    pub(crate) fn get(&self, slot: usize) -> &Raw<'a> {
        &self.slots[slot]
    }

    /// The numbers that a slice picked for `slot`, in the array's order.
    pub(crate) fn list(&self, slot: usize) -> &[f64] {
        self.lists.get(slot).map_or(&[], Vec::as_slice)
    }

    /// Moves what an element of a slice put into `slots` to their lists.
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

    /// The element that a sibling array's match picked; notes that the walk must be repeated while it is not known.
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
