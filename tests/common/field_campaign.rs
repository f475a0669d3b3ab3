//! The campaign of the studies of drives and sensors in the field, and its fit without any option.

use super::Fallible;
use pivot_cal::campaign::{Survey, SurveySettings};
use pivot_cal::fit::{FitSettings, fit};
use pivot_cal::log::{Source, VehicleOverrides, read_bytes};
use pivot_cal::map::Table1File;
use pivot_cal::signal::Track;

/// The bundled vehicle.
pub(crate) const SCRUBBER: &str = include_str!("../../data/vehicles/scrubber.toml");

/// Five levels from rest and five braking levels forward, four levels in reverse, each driven twice.
pub(crate) const CAMPAIGN: &str = "
[[runs]]
torque_nm = [12, 18, 24, 32, 40]
hold_s = 3.0
repeats = 2
[[runs]]
torque_nm = [-20, -12, -6, 0, 6]
start_speed_mps = 0.55
spin_up_nm = 36
end_speed_mps = 0.05
hold_s = 3.0
repeats = 2
[[runs]]
gear = \"reverse\"
torque_nm = [14, 22, 32, 40]
hold_s = 3.0
repeats = 2
[[runs]]
gear = \"reverse\"
torque_nm = [-12, 0]
start_speed_mps = 0.55
spin_up_nm = 36
end_speed_mps = 0.05
hold_s = 3.0
";

/// Table 1 of a log, without any option but the vehicle's dimensions.
pub(crate) fn fitted(log: Vec<u8>) -> Fallible<Table1File> {
    let overrides = VehicleOverrides { wheelbase_m: Some(0.9), wheel_radius_m: Some(0.12), ..VehicleOverrides::default() };
    let recording = read_bytes(log, "field.mcap", &Source::Detect, &overrides)?;
    let survey = Survey::new(Track::new(&recording)?, &SurveySettings::default())?;
    Ok(fit(vec![survey], &FitSettings::default())?.file)
}
