//! The map of a vehicle whose physics is known: what a perfect campaign would give.

#![allow(dead_code, clippy::unwrap_used)] // every test takes what it needs

use pivot_cal::internals::{PhysicalSettings, WorldSettings as World, known_maps};
use pivot_cal::map::{Table1File, Table2File, Vehicle};
use std::path::Path;

pub(crate) fn vehicle() -> Vehicle {
    Vehicle { wheelbase_m: 0.92, wheel_radius_m: 0.12, test_angle_deg: 90.0, torque_limit_nm: Some(44.0), torque_full_scale_nm: None }
}

pub(crate) fn world() -> World {
    World::physical(vehicle(), PhysicalSettings::default())
}

pub(crate) fn good() -> (Table1File, Table2File) {
    known_maps(&world()).unwrap()
}

/// Writes the files of the map into `folder`.
pub(crate) fn save(folder: &Path) {
    let (table1, table2) = good();
    std::fs::write(folder.join("table1.json"), table1.to_json().unwrap()).unwrap();
    std::fs::write(folder.join("table2.json"), table2.to_json().unwrap()).unwrap();
    for map in &table2.maps {
        std::fs::write(folder.join(&map.csv.file), map.table().unwrap().to_matrix().to_csv()).unwrap();
    }
}
