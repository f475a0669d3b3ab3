//! The library's front door makes the map that the command line makes, and README.md shows the program that does it.
#![allow(clippy::unwrap_used)]

use pivot_cal::calibrate::{FitStage, LogSource, StageEvent, fit_logs};
use pivot_cal::{CalibrateSettings, Error, calibrate};
use std::path::Path;

#[test]
fn the_front_door_makes_the_bundled_map_byte_for_byte() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let folder = tempfile::tempdir().unwrap();
    let made = calibrate(&[root.join("data/demo.mcap")], folder.path(), &CalibrateSettings::default()).unwrap();
    assert!(made.passes());
    for name in ["table1.csv", "table1.reverse.csv", "table1.json", "table2.csv", "table2.json", "verify.json", "fit_traces.json"] {
        let (own, bundled) = (std::fs::read(folder.path().join(name)).unwrap(), std::fs::read(root.join("maps").join(name)).unwrap());
        assert!(own == bundled, "{name}");
    }
    assert!(folder.path().join("report.html").is_file());
}

#[test]
fn the_readme_shows_the_example() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let readme = std::fs::read_to_string(root.join("README.md")).unwrap();
    let example = std::fs::read_to_string(root.join("examples/quick_start.rs")).unwrap();
    assert!(example.lines().count() <= 20);
    let code: Vec<&str> = example.lines().skip_while(|line| !line.starts_with("use pivot_cal")).collect();
    let block = readme.split("```rust\n").nth(1).unwrap().split("```").next().unwrap();
    assert_eq!(block.trim_end(), code.join("\n"));
}

#[test]
fn a_log_that_is_not_there_is_an_error_about_its_path_and_a_stage_reports_what_it_does() {
    let folder = tempfile::tempdir().unwrap();
    let missing = folder.path().join("no.mcap");
    let heard = std::sync::Mutex::new(Vec::new());
    let listen = |event: StageEvent| heard.lock().unwrap().push(event);
    let error =
        fit_logs(std::slice::from_ref(&missing), folder.path(), &FitStage { source: LogSource::default(), ..FitStage::default() }, &listen);
    let Err(Error::About { what, .. }) = error else { panic!("{error:?}") };
    assert_eq!(what, missing.display().to_string());
    assert!(std::fs::read_dir(folder.path()).unwrap().next().is_none());
}
