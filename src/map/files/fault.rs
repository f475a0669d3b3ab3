//! Faults on purpose, for the tests of what a killed process leaves behind. Built without debug assertions, this file does nothing.

/// Ends the process, as a kill would, before the rename that the variable `PIVOT_CAL_KILL_BEFORE_RENAME` numbers (from 1); panics if it is `panic`.
pub(crate) fn before_rename() {
    #[cfg(debug_assertions)]
    {
        use std::sync::atomic::{AtomicU64, Ordering};
        static RENAMES: AtomicU64 = AtomicU64::new(0);
        let number = RENAMES.fetch_add(1, Ordering::Relaxed) + 1;
        let asked = std::env::var("PIVOT_CAL_KILL_BEFORE_RENAME").unwrap_or_default();
        assert!(asked != "panic", "a fault on purpose");
        if asked.parse() == Ok(number) {
            std::process::abort();
        }
    }
}
