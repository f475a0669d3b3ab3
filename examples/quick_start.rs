//! From a log to a verified map, by the library: what `pivot-cal calibrate` does. `cargo run --release --example quick_start`
#![allow(clippy::print_stdout)]
use pivot_cal::{CalibrateSettings, Result, calibrate};
use std::path::Path;

fn main() -> Result<()> {
    let logs = ["data/demo.mcap".into()];
    let made = calibrate(&logs, Path::new("target/quick_start"), &CalibrateSettings::default())?;
    for map in &made.inversion.file.maps {
        let torque_nm = map.table()?.torque_from_accel(0.3, 0.5);
        println!("{} gear: {torque_nm:?} N·m at 0.3 m/s for 0.5 m/s²", map.gear);
    }
    println!("verdict: {}", if made.passes() { "pass" } else { "fail" });
    Ok(())
}
