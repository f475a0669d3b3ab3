//! Any text as a message path; what is printed parses again to the same, the whole and its steps one by one.
#![no_main]

use pivot_cal::internals::MessagePath;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|text: &str| {
    if let Ok(path) = text.parse::<MessagePath>() {
        assert_eq!(path.to_string().parse::<MessagePath>().expect("it came from a path"), path);
        let steps: String = path.steps.iter().map(ToString::to_string).collect();
        let again: MessagePath = format!("/t{steps}").parse().expect("they came from a path");
        // as text, in which a number that is none equals itself
        assert_eq!(format!("{:?}", again.steps), format!("{:?}", path.steps));
    }
});
