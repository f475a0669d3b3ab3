//! Any text as a message path; what is printed parses again to the same.
#![no_main]

use libfuzzer_sys::fuzz_target;
use pivot_cal::log::MessagePath;

fuzz_target!(|text: &str| {
    if let Ok(path) = text.parse::<MessagePath>() {
        assert_eq!(path.to_string().parse::<MessagePath>().expect("it came from a path"), path);
    }
});
