//! Units of a file: of the line *Units of the tables* in our headers, or by name.

use crate::import::full_scale::FullScale;
use crate::units::{Dimension, Unit};

/// SI = scale · number + offset.
pub(crate) type Conversion = (f64, f64);

/// SI itself.
pub(crate) const SI: Conversion = (1.0, 0.0);

/// Conversions of speed and torque from the line of our headers: `speed in km per h, m per s = 0.27 x number + 0, torque in …`.
pub(crate) fn of_header(text: &str) -> Option<[Conversion; 2]> {
    let line = text.lines().take(400).find(|line| line.contains("Units of the tables:"))?;
    let of = |what: &str| -> Conversion {
        let after = line.split(&format!("{what} in ")).nth(1).and_then(|rest| rest.split(" = ").nth(1));
        let numbers = after.and_then(|rest| {
            let (scale, rest) = rest.split_once(" x number + ")?;
            let end = rest.find(|c: char| !(c.is_ascii_digit() || "+-.eE".contains(c))).unwrap_or(rest.len());
            Some((scale.trim().parse().ok()?, rest[..end].trim_end_matches('.').parse().ok()?))
        });
        numbers.unwrap_or(SI)
    };
    Some([of("speed"), of("torque")])
}

/// Conversion of a speed by the name of its unit.
///
/// # Errors
/// A unit that is none of a speed, or one of a turning wheel without a wheel radius.
pub(crate) fn speed(name: &str, full: FullScale) -> Result<Conversion, String> {
    let unit: Unit = name.parse().map_err(|_| format!("the unit {name:?} of the speeds is not known"))?;
    match unit.dimension() {
        Dimension::Speed => Ok((unit.factor(), 0.0)),
        Dimension::AngularSpeed => Ok((unit.factor() * full.wheel_radius_m, 0.0)),
        _ => Err(format!("{name:?} is no unit of a speed")),
    }
}

/// Conversion of a torque by the name of its unit.
///
/// # Errors
/// A unit that is none of a torque, or a share without a full scale.
pub(crate) fn torque(name: &str, full: FullScale) -> Result<Conversion, String> {
    let unit: Unit =
        name.parse().map_err(|_| format!("the unit {name:?} of the torques is not known; export with --torque-unit writes it down"))?;
    match unit.dimension() {
        Dimension::Torque => Ok((unit.factor(), 0.0)),
        Dimension::Share => {
            let full_nm = full.torque_nm.ok_or("torques in % need the torque that is 100 %: --torque-full-scale")?;
            Ok((unit.factor() * full_nm, 0.0))
        }
        _ => Err(format!("{name:?} is no unit of a torque")),
    }
}

/// The unit at the end of a column's name: `speed_kmh`, `Speed [km/h]`; empty without one.
pub(crate) fn of_column(name: &str) -> String {
    if let Some((_, unit)) = name.split_once('[') {
        return unit.trim_end().trim_end_matches(']').trim().to_owned();
    }
    match name.trim().rsplit_once('_').map(|(_, unit)| unit.to_ascii_lowercase()).as_deref() {
        Some("mps") => "m/s".to_owned(),
        Some("kmh") => "km/h".to_owned(),
        Some("mms") => "mm/s".to_owned(),
        Some("rpm") => "rpm".to_owned(),
        Some("nm") => "N.m".to_owned(),
        Some("mnm") => "mN.m".to_owned(),
        Some("pct") => "%".to_owned(),
        Some("permille") => "permille".to_owned(),
        _ => String::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_line_of_our_headers_gives_both_conversions() {
        let text = " * Units of the tables: speed in km per h, m per s = 0.2777777777777778 x number + 0, torque in %, N.m = 0.44 x number + -1.5.\n";
        assert_eq!(of_header(text), Some([(0.277_777_777_777_777_8, 0.0), (0.44, -1.5)]));
        assert_eq!(of_header("* nothing"), None);
    }
}
