//! Any text as a signal map.
#![no_main]

use libfuzzer_sys::fuzz_target;
use pivot_cal::log::SignalMap;

fuzz_target!(|text: &str| {
    let _ = SignalMap::from_toml(text);
});
