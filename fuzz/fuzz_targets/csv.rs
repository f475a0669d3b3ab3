//! Any bytes as a table of signals: separator, header, form, times, rows.
#![no_main]

use libfuzzer_sys::fuzz_target;
use pivot_cal::internals::survey_bytes;
use pivot_cal::log::{Depth, Source};

#[path = "../one_thread.rs"]
mod one_thread;

fuzz_target!(init: one_thread::init(), |data: &[u8]| {
    let _ = survey_bytes(data.to_vec(), "fuzz.csv", &Source::Detect, Depth::Everything);
});
