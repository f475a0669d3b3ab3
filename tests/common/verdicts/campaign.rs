//! What is driven: a campaign for a vehicle's torques, short and yet enough for a verdict.

use crate::verdicts::Fallible;
use crate::verdicts::log::Log;
use pivot_cal::internals::{Campaign, VehicleFile, record};

/// Torque of a vehicle relative to the scrubber's.
pub(crate) fn size(vehicle: &VehicleFile) -> f64 {
    vehicle.vehicle.torque_limit_nm.unwrap_or(44.0) / 44.0
}

/// Torques in N·m of the scrubber, for a vehicle of that size.
fn torques(of_scrubber_nm: &[f64], size: f64) -> String {
    let list: Vec<String> = of_scrubber_nm.iter().map(|t| format!("{:.1}", t * size)).collect();
    format!("[{}]", list.join(", "))
}

/// A group of runs from rest.
pub(crate) fn from_rest(size: f64, of_scrubber_nm: &[f64], rest: &str) -> String {
    format!("[[runs]]\ntorque_nm = {}\n{rest}\n", torques(of_scrubber_nm, size))
}

/// A group of runs that begin at a speed.
pub(crate) fn from_speed(size: f64, of_scrubber_nm: &[f64], rest: &str) -> String {
    format!(
        "[[runs]]\ntorque_nm = {}\nstart_speed_mps = 0.8\nspin_up_nm = {:.1}\nend_speed_mps = 0.05\n{rest}\n",
        torques(of_scrubber_nm, size),
        36.0 * size
    )
}

/// The usual campaign: both gears, from rest and from speed.
pub(crate) fn usual(size: f64) -> String {
    from_rest(size, &[12.0, 18.0, 24.0, 32.0, 40.0], "hold_s = 3.0\nrepeats = 2")
        + &from_speed(size, &[-20.0, -12.0, -6.0, 0.0, 6.0], "hold_s = 3.0")
        + &from_rest(size, &[14.0, 20.0, 30.0, 40.0], "gear = \"reverse\"\nhold_s = 3.0\nrepeats = 2")
        + &from_speed(size, &[-12.0, 0.0, 6.0], "gear = \"reverse\"\nhold_s = 3.0")
}

/// Drives a campaign.
///
/// # Errors
/// A campaign or a vehicle that the simulator refuses.
pub(crate) fn driven(vehicle: &VehicleFile, campaign: &str, seed: u64) -> Fallible<Log> {
    Ok(Log::read(&record(vehicle, &Campaign::from_toml(campaign)?, Some(seed))?.bytes)?)
}
