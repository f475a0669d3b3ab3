//! Copies of the committed map, altered.
#![allow(dead_code, clippy::unwrap_used)] // every test takes what it needs

#[path = "program.rs"]
mod program;

use pivot_cal::map::{Table1File, Table2File, sha256_hex};
use program::repo;
#[allow(unused_imports)]
pub(crate) use program::run;
use std::path::{Path, PathBuf};

/// A copy of the committed map in a separate folder, `maps`.
pub(crate) fn copied() -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let maps = folder.path().join("maps");
    std::fs::create_dir(&maps).unwrap();
    for entry in std::fs::read_dir(repo("maps")).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_some_and(|e| e == "csv" || e == "json") {
            std::fs::copy(&path, maps.join(path.file_name().unwrap())).unwrap();
        }
    }
    (folder, maps)
}

/// The text of a file.
pub(crate) fn text(maps: &Path, name: &str) -> String {
    std::fs::read_to_string(maps.join(name)).unwrap()
}

/// Changes Table 2 as a whole: JSON and CSV belong together afterwards.
pub(crate) fn change_table2(maps: &Path, change: impl FnOnce(&mut Table2File)) {
    let mut file = Table2File::from_json(&text(maps, "table2.json")).unwrap();
    change(&mut file);
    for map in &mut file.maps {
        let csv = map.table().unwrap().to_matrix().to_csv();
        map.csv.sha256 = sha256_hex(csv.as_bytes());
        std::fs::write(maps.join(&map.csv.file), csv).unwrap();
    }
    std::fs::write(maps.join("table2.json"), file.to_json().unwrap()).unwrap();
}

/// Changes Table 1 as a whole, and makes Table 2 refer to the changed file.
pub(crate) fn change_table1(maps: &Path, change: impl FnOnce(&mut Table1File)) {
    let mut file = Table1File::from_json(&text(maps, "table1.json")).unwrap();
    change(&mut file);
    for map in &mut file.maps {
        let csv = map.table().unwrap().to_matrix().to_csv();
        map.csv.sha256 = sha256_hex(csv.as_bytes());
        std::fs::write(maps.join(&map.csv.file), csv).unwrap();
    }
    let json = file.to_json().unwrap();
    std::fs::write(maps.join("table1.json"), &json).unwrap();
    change_table2(maps, |table2| table2.table1.sha256 = sha256_hex(json.as_bytes()));
}

/// The text with one of its numbers changed in the last decimal.
pub(crate) fn with_last_decimal_changed(text: &str, value: f64) -> String {
    let number = value.to_string();
    let last = number.chars().last().unwrap();
    let other = if last == '4' { '5' } else { '4' };
    let changed = format!("{}{other}", &number[..number.len() - 1]);
    assert!(number.contains('.') && text.contains(&number), "{number} is in the text");
    text.replacen(&number, &changed, 1)
}
