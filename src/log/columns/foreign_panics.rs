//! A parser that is not ours may panic where a file is damaged. That is a fault of the file, and becomes an error.

use std::cell::Cell;
use std::panic::{AssertUnwindSafe, catch_unwind};

thread_local! {
    static IS_CAUGHT: Cell<bool> = const { Cell::new(false) };
}

/// Whether a panic of this thread becomes an error, so that nothing needs to be reported.
pub(crate) fn is_caught() -> bool {
    IS_CAUGHT.with(Cell::get)
}

/// The result of `parse`, or the message of its panic. What `parse` has changed must not be used after a panic.
pub(crate) fn caught<T>(parse: impl FnOnce() -> T) -> Result<T, String> {
    let before = IS_CAUGHT.replace(true);
    let result = catch_unwind(AssertUnwindSafe(parse));
    IS_CAUGHT.set(before);
    result.map_err(|panic| {
        let text = panic.downcast_ref::<String>().map(String::as_str).or_else(|| panic.downcast_ref::<&str>().copied());
        text.unwrap_or("its parser gave up").to_owned()
    })
}
