//! The vehicles of the suite, each known to the last number.

use pivot_cal::internals::VehicleFile;

use crate::verdicts::Fallible;
use crate::verdicts::vehicle_text::changed;

/// Names of the vehicles.
pub(crate) const NAMES: [&str; 3] = ["scrubber", "sweeper", "drag"];

const SCRUBBER: &str = include_str!("../../../data/vehicles/scrubber.toml");
const SWEEPER: &str = include_str!("../../../data/vehicles/sweeper.toml");

/// What makes the third vehicle of the first: heavy, short, high friction, a slow drive.
const DRAG: &[(&str, &str)] = &[
    ("[vehicle]", "wheelbase_m = 0.75\nwheel_radius_m = 0.100"),
    ("[drive]", "dead_time_s = 0.030\nlag_s = 0.120"),
    ("[motion]", "yaw_inertia_kgm2 = 70.0\ncoulomb_nm = 5.0\nstatic_nm = 6.5\nviscous_nm_s_m = 9.0\ndrive_efficiency = 0.86"),
];

/// The text of a vehicle file.
pub(crate) fn text(name: &str) -> String {
    match name {
        "sweeper" => SWEEPER.to_owned(),
        "drag" => changed(SCRUBBER, DRAG),
        _ => SCRUBBER.to_owned(),
    }
}

/// The vehicle of a text.
///
/// # Errors
/// A text that is no vehicle file.
pub(crate) fn vehicle(text: &str) -> Fallible<VehicleFile> {
    Ok(VehicleFile::from_toml(text)?)
}

/// The file with one of its numbers multiplied; a key that it does not have stays away.
pub(crate) fn scaled(text: &str, key: &str, factor: f64) -> String {
    let start = format!("{key} = ");
    let line = |line: &str| {
        let Some(rest) = line.strip_prefix(&start) else { return line.to_owned() };
        let number = rest.split([' ', '#']).next().and_then(|n| n.parse::<f64>().ok());
        number.map_or(line.to_owned(), |n| format!("{key} = {}", n * factor))
    };
    text.lines().map(line).collect::<Vec<_>>().join("\n") + "\n"
}
