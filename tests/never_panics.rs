//! Nothing that is read makes a panic: every array of every map file in any wrong shape, and every signal stuck at any value.
//!
//! A result or an error are both right here; what each should say is asked elsewhere.

#![allow(clippy::unwrap_used)]

#[path = "common/map_copy.rs"]
mod map_copy;

use map_copy::copied;
use pivot_cal::calibrate::{InvertStage, invert_folder, report_folder, survey};
use pivot_cal::check::{CheckSettings, check};
use pivot_cal::export::{ExportSettings, Format, MapSource};
use pivot_cal::fit::{FitSettings, fit};
use pivot_cal::log::{Preset, Recording, Signal, Source, VehicleOverrides, read};
use pivot_cal::verify::Maps;
use proptest::prelude::*;
use serde_json::Value;
use std::path::Path;
use std::sync::LazyLock;

/// What is done to an array.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Fault {
    OneLess,
    OneMore,
    Empty,
    First(Item),
}

/// What takes the place of its first item.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Item {
    Null,
    Huge,
    Text,
    Nested,
}

const FAULTS: [Fault; 7] = [
    Fault::OneLess,
    Fault::OneMore,
    Fault::Empty,
    Fault::First(Item::Null),
    Fault::First(Item::Huge),
    Fault::First(Item::Text),
    Fault::First(Item::Nested),
];

const FILES: [&str; 6] = ["table1.json", "table2.json", "verify.json", "fit_traces.json", "verify_traces.json", "lateral_table.json"];

/// The places of all arrays, one of each kind: of the rows of a matrix the third, of a list of objects the first.
fn arrays(value: &Value, place: &str, found: &mut Vec<String>) {
    match value {
        Value::Array(items) => {
            found.push(place.to_owned());
            let inner = if items.iter().all(Value::is_array) { 2 } else { 0 };
            if let Some(item) = items.get(inner) {
                arrays(item, &format!("{place}/{inner}"), found);
            }
        }
        Value::Object(fields) => fields.iter().for_each(|(name, field)| arrays(field, &format!("{place}/{name}"), found)),
        _ => {}
    }
}

fn spoil(json: &mut Value, place: &str, fault: Fault) {
    let items = json.pointer_mut(place).unwrap().as_array_mut().unwrap();
    match fault {
        Fault::OneLess => drop(items.pop()),
        Fault::OneMore => items.extend(items.last().cloned()),
        Fault::Empty => items.clear(),
        Fault::First(item) => {
            let value = match item {
                Item::Null => Value::Null,
                Item::Huge => 1e308.into(),
                Item::Text => "x".into(),
                Item::Nested => serde_json::json!([[1]]),
            };
            if let Some(first) = items.first_mut() {
                *first = value;
            }
        }
    }
}

/// Every place of every file.
static PLACES: LazyLock<Vec<(&str, String)>> = LazyLock::new(|| {
    let mut all = Vec::new();
    for file in FILES {
        let mut found = Vec::new();
        arrays(&serde_json::from_str(&map_copy::text(&Path::new(env!("CARGO_MANIFEST_DIR")).join("maps"), file)).unwrap(), "", &mut found);
        all.extend(found.into_iter().map(|place| (file, place)));
    }
    all
});

/// Everything that reads the files of a folder, `invert` on a part of the faults only, since it takes longest.
fn read_all(maps: &Path, inverts: bool) {
    let _ = report_folder(maps, &maps.join("page.html"), None);
    let _ = Maps::read(maps, true);
    if let Ok(source) = MapSource::read(maps) {
        for format in Format::ALL {
            let _ = format.files(&source, &ExportSettings { without_binary: true, ..ExportSettings::default() });
        }
    }
    for file in ["table1.json", "table2.json"] {
        let _ = check(&maps.join(file), CheckSettings::default());
    }
    if inverts {
        let _ = invert_folder(maps, &InvertStage { force: true, ..InvertStage::default() }, &|_| {});
    }
}

/// The short recording of the tests, read once.
static RECORDING: LazyLock<Recording> = LazyLock::new(|| {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/mini_ros2.zstd.mcap");
    let vehicle =
        VehicleOverrides { wheelbase_m: Some(0.9), wheel_radius_m: Some(0.12), test_angle_deg: Some(90.0), ..VehicleOverrides::default() };
    read(&path, &Source::Preset(Preset::PivotCal), &vehicle, &|_| {}).unwrap()
});

/// The signals that can be stuck.
fn signal(recording: &mut Recording, number: usize) -> Option<&mut Signal> {
    let signals = &mut recording.signals;
    match number {
        0 => Some(&mut signals.speed),
        1 => Some(&mut signals.torque),
        2 => Some(&mut signals.angle),
        3 => signals.yaw_rate.as_mut(),
        4 => signals.torque_feedback.as_mut(),
        _ => signals.gear.as_mut(),
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 40, rng_seed: proptest::test_runner::RngSeed::Fixed(11), failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn no_shape_of_an_array_makes_a_panic(place in 0..PLACES.len(), fault in prop::sample::select(FAULTS.to_vec()), number in 0..8u8) {
        let (_keep, maps) = copied();
        let (file, place) = &PLACES[place];
        let mut json: Value = serde_json::from_str(&map_copy::text(&maps, file)).unwrap();
        spoil(&mut json, place, fault);
        std::fs::write(maps.join(file), json.to_string()).unwrap();
        read_all(&maps, number == 0);
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 6, rng_seed: proptest::test_runner::RngSeed::Fixed(12), failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn no_stuck_signal_makes_a_panic(
        stuck in prop::collection::vec((0..6usize, prop::sample::select(vec![0.0, 1e-300, 0.3, -2.0, 1e9]), 0.0..1.0f64), 1..3)
    ) {
        let mut recording = RECORDING.clone();
        for (number, value, from) in stuck {
            if let Some(signal) = signal(&mut recording, number) {
                let from = (from.max(0.1) - 0.1) * signal.value.len() as f64;
                signal.value[from as usize..].fill(value);
            }
        }
        if let Ok(surveys) = survey(&[recording], &|_| {}) {
            let _ = fit(surveys, &FitSettings::default());
        }
    }
}

#[test]
fn every_array_of_both_tables_with_one_entry_less_is_an_error_of_every_command() {
    for (file, place) in
        PLACES.iter().filter(|(file, place)| file.starts_with("table") && place.starts_with("/maps/") && place.matches('/').count() > 2)
    {
        let (_keep, maps) = copied();
        let mut json: Value = serde_json::from_str(&map_copy::text(&maps, file)).unwrap();
        spoil(&mut json, place, Fault::OneLess);
        std::fs::write(maps.join(file), json.to_string()).unwrap();
        let array = place.rsplit('/').find(|part| part.parse::<usize>().is_err()).unwrap();
        let page = report_folder(&maps, &maps.join("page.html"), None).err().map(|error| error.to_string());
        assert!(page.is_some(), "{file}{place}: `report` takes it");
        assert!(MapSource::read(&maps).is_err(), "{file}{place}: `export` takes it");
        let report = check(&maps.join(file), CheckSettings::default()).unwrap();
        assert!(!report.sound, "{file}{place}: `check` says sound");
        let found = report.findings.iter().map(|f| format!("{} {}", f.place(), f.what)).collect::<Vec<_>>().join("; ");
        for said in [page.unwrap(), found] {
            let is_named = ["Table ", " at line ", "row", "axis"].iter().any(|word| said.contains(word));
            assert!(is_named || said.contains(array), "{file}{place}: {said}");
        }
    }
}
