//! Any bytes as a log: found by scan or summary, decompressed, walked.
#![no_main]

use libfuzzer_sys::fuzz_target;
use pivot_cal::internals::survey_bytes;
use pivot_cal::log::{Depth, Source};

#[path = "../one_thread.rs"]
mod one_thread;

fuzz_target!(init: one_thread::init(), |data: &[u8]| {
    let _ = survey_bytes(data.to_vec(), "fuzz", &Source::Detect, Depth::Everything);
});
