//! Writes the maps that a perfect campaign would give of a vehicle whose physics is known:
//! `cargo run --example known_maps -- FOLDER [VEHICLE.toml]`, then `pivot-cal verify --maps FOLDER`.
//!
//! They end at 1.0 m/s, as those of every campaign end somewhere: a look-up beyond gives the nearest entry, which is no error of the map.

use pivot_cal::internals::{PhysicalSettings, VehicleFile, WorldSettings, known_maps};
use pivot_cal::map::Vehicle;
use std::error::Error;
use std::path::PathBuf;

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let folder = PathBuf::from(arguments.next().ok_or("which folder?")?);
    let world = match arguments.next() {
        Some(path) => VehicleFile::from_toml(&std::fs::read_to_string(path)?)?.settings(),
        None => WorldSettings::physical(
            Vehicle {
                wheelbase_m: 0.92,
                wheel_radius_m: 0.12,
                test_angle_deg: 90.0,
                torque_limit_nm: Some(44.0),
                torque_full_scale_nm: None,
            },
            PhysicalSettings::default(),
        ),
    };
    let (table1, table2) = known_maps(&world)?;
    std::fs::write(folder.join("table1.json"), table1.to_json()?)?;
    std::fs::write(folder.join("table2.json"), table2.to_json()?)?;
    for map in &table1.maps {
        std::fs::write(folder.join(&map.csv.file), map.table()?.to_matrix().to_csv())?;
    }
    for map in &table2.maps {
        std::fs::write(folder.join(&map.csv.file), map.table()?.to_matrix().to_csv())?;
    }
    Ok(())
}
