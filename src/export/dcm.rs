//! DCM 2.0 (data conservation format of calibration tools): one `KENNFELD` per gear with axes and units, and the drive's constants as
//! `FESTWERT`. X is the desired acceleration, Y the speed. The lateral compensation is a `KENNLINIE` with its law's settings.

use crate::export::constant::Constant;
use crate::export::file::File;
use crate::export::lateral_source::LateralSource;
use crate::export::number::plain;
use crate::export::{MapSource, UserUnits, provenance};
use crate::map::Gear;
use std::fmt::Write as _;

/// Numbers on a line, as calibration tools write them.
const PER_LINE: usize = 6;

pub(crate) fn file(source: &MapSource, units: &UserUnits) -> File {
    let mut text = String::from("* encoding=\"UTF-8\"\n");
    for line in provenance::lines(source).into_iter().chain(units.line()) {
        let _ = writeln!(text, "* {line}");
    }
    text.push_str("\nKONSERVIERUNG_FORMAT 2.0\n\nFUNKTIONEN\n");
    let _ = write!(text, "   FKT PIVOT_MAP \"{}\" \"Torque map for turning on the spot\"\nEND\n", env!("CARGO_PKG_VERSION"));
    for constant in constants(source).into_iter().chain(source.lateral.iter().flat_map(LateralSource::constants)) {
        let _ = write!(
            text,
            "\nFESTWERT {}\n   LANGNAME \"{}\"\n   FUNKTION PIVOT_MAP\n   EINHEIT_W \"{}\"\n   WERT {}\nEND\n",
            constant.name,
            constant.what,
            constant.unit,
            plain(constant.value)
        );
    }
    for (gear, table) in &source.torque {
        let (x, y) = (table.accel_mps2().breaks(), table.speed_mps().breaks());
        let _ = write!(text, "\nKENNFELD {} {} {}\n", name(*gear), x.len(), y.len());
        let _ = write!(text, "   LANGNAME \"{}\"\n   FUNKTION PIVOT_MAP\n", what(*gear));
        let (speed, torque) = (units.speed_name(), units.torque_name());
        let _ = write!(text, "   EINHEIT_X \"m/s^2\"\n   EINHEIT_Y \"{speed}\"\n   EINHEIT_W \"{torque}\"\n");
        numbers(&mut text, "ST/X", x);
        for (speed, row) in y.iter().zip(table.values().chunks(x.len())) {
            numbers(&mut text, "ST/Y", &[units.speed(*speed)]);
            numbers(&mut text, "WERT", &row.iter().map(|t| units.torque(*t)).collect::<Vec<_>>());
        }
        text.push_str("END\n");
    }
    if let Some(law) = &source.lateral {
        let (errors, angles) = (&law.file.curve.error_m, &law.file.curve.angle_rad);
        let _ = write!(text, "\nKENNLINIE {LATERAL} {}\n   LANGNAME \"{LATERAL_WHAT}\"\n   FUNKTION PIVOT_MAP\n", errors.len());
        text.push_str("   EINHEIT_X \"m\"\n   EINHEIT_W \"rad\"\n");
        numbers(&mut text, "ST/X", errors);
        numbers(&mut text, "WERT", angles);
        text.push_str("END\n");
    }
    File::new("pivot_map.dcm", text)
}

fn numbers(text: &mut String, keyword: &str, values: &[f64]) {
    for line in values.chunks(PER_LINE) {
        text.push_str("   ");
        text.push_str(keyword);
        for v in line {
            text.push_str("   ");
            text.push_str(&plain(*v));
        }
        text.push('\n');
    }
}

/// Name and description of the lateral compensation's curve in calibration data.
pub(crate) const LATERAL: &str = "LATERAL_COMPENSATION_ANGLE";
pub(crate) const LATERAL_WHAT: &str = "Compensation angle over the mean lateral error that it adds";

/// Name of a gear's map in calibration data.
pub(crate) fn name(gear: Gear) -> &'static str {
    match gear {
        Gear::Forward => "PIVOT_MAP_TORQUE_FORWARD",
        Gear::Reverse => "PIVOT_MAP_TORQUE_REVERSE",
    }
}

/// Description of a gear's map.
pub(crate) fn what(gear: Gear) -> String {
    format!("Torque over front-wheel speed and desired acceleration, {gear} gear")
}

/// The drive's delays, geometry and dead bands.
pub(crate) fn constants(source: &MapSource) -> Vec<Constant> {
    let file = &source.table2;
    let constant = |name: &str, what: &str, unit, value| Constant { name: name.to_owned(), what: what.to_owned(), unit, value };
    let mut constants = vec![
        constant("PIVOT_MAP_DEAD_TIME", "Dead time of the drive", "s", file.dead_time_s),
        constant("PIVOT_MAP_LAG", "Time constant of the drive", "s", file.lag_s),
        constant("PIVOT_MAP_WHEELBASE", "Wheelbase", "m", file.vehicle.wheelbase_m),
        constant("PIVOT_MAP_WHEEL_RADIUS", "Rolling radius of the front wheel", "m", file.vehicle.wheel_radius_m),
        constant("PIVOT_MAP_WHEEL_ANGLE", "Wheel angle of the map, left positive", "deg", file.vehicle.test_angle_deg),
        constant("PIVOT_MAP_FULL_TORQUE", "Torque limit, or the largest torque of the map", "Nm", source.full_torque_nm()),
    ];
    for (gear, _) in &source.torque {
        for (end, value) in ["LOW", "HIGH"].iter().zip(source.dead_band_nm(*gear).into_iter().flatten()) {
            let gear_name = gear.to_string();
            let name = format!("PIVOT_MAP_DEAD_BAND_{end}_{}", gear_name.to_ascii_uppercase());
            let what = format!("Torque at which a resting wheel just stays at rest, {gear_name} gear, {} end", end.to_ascii_lowercase());
            constants.push(Constant { name, what, unit: "Nm", value });
        }
    }
    constants
}
