//! Any bytes as a log: found by scan or summary, decompressed, walked.
#![no_main]

use libfuzzer_sys::fuzz_target;
use pivot_cal::log::{Depth, Source, survey_bytes};

fuzz_target!(|data: &[u8]| {
    let _ = survey_bytes(data.to_vec(), "fuzz", &Source::Detect, Depth::Everything);
});
