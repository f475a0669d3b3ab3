//! The element that an index means: negative indices count from the end.

/// The element that an index means, if the array has it.
pub(crate) fn position(index: i64, count: usize) -> Option<usize> {
    let index = if index < 0 { index + count as i64 } else { index };
    usize::try_from(index).ok().filter(|index| *index < count)
}
