//! Wheel angles on the command line.

use crate::map::AngleFamily;

/// A family, in words.
pub(crate) fn family_text(family: &AngleFamily) -> String {
    let angles: Vec<String> = family.wheel_angle_deg.iter().map(|a| format!("{a}°")).collect();
    let left_out: Vec<String> = family.left_out.iter().map(|l| format!("{}° {:.2} N·m", l.wheel_angle_deg, l.rms_nm)).collect();
    format!(
        "{} gear, {} ({}): inertia {:.2} N·m per m/s² straight ahead, {:.2} at 90°; between angles ± {:.2} N·m ({}{})",
        family.gear,
        family.side,
        angles.join(", "),
        family.inertia[0],
        family.inertia[0] + family.inertia[1],
        family.departure_nm,
        family.departure_from,
        if left_out.is_empty() { String::new() } else { format!(": {}", left_out.join(", ")) }
    )
}
