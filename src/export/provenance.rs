//! Origin of an exported map, as lines for a comment.

use crate::controller::ControllerFile;
use crate::export::{MapSource, Proof};
use crate::map::{FixedText, IdentifiedDrive, LateralTableFile};

/// The lines. Without time and machine, so that the same map gives the same bytes; without characters that could end a comment.
pub(crate) fn lines(source: &MapSource) -> Vec<String> {
    let file = &source.table2;
    let vehicle = file.vehicle;
    let mut lines = vec![
        format!("Written by pivot-cal {} from table2.json; do not edit.", env!("CARGO_PKG_VERSION")),
        proof_line(&source.proof),
        format!("Generation: {}.", if file.generation.is_empty() { "not given".to_owned() } else { clean(&file.generation) }),
        format!(
            "Vehicle: wheelbase {} m, wheel radius {} m, wheel at {} deg (left positive){}.",
            vehicle.wheelbase_m,
            vehicle.wheel_radius_m,
            vehicle.test_angle_deg,
            vehicle.torque_limit_nm.map_or(String::new(), |limit| format!(", torque limit {limit} N.m"))
        ),
        format!("Drive: dead time {} s, lag {} s.", file.dead_time_s, file.lag_s),
    ];
    let drive = file.drive.iter().flat_map(IdentifiedDrive::lines);
    lines.extend(drive.map(|(label, text)| {
        clean(&format!("{label} {text}").replace('·', ".").replace('±', "+-").replace('/', " per ")).trim().to_owned()
    }));
    lines.extend(source.proof.controller.iter().flat_map(controller_lines));
    for map in &file.maps {
        let band = &map.dead_band;
        lines.push(format!(
            "{} gear: {} speeds x {} accelerations, dead band {} to {} N.m, row at speed 0: {}.",
            map.gear,
            map.speed_mps.len(),
            map.accel_mps2.len(),
            band.low_nm,
            band.high_nm,
            map.zero_row.name()
        ));
        lines.push(format!("{}: SHA-256 {}", clean(&map.csv.file), clean(&map.csv.sha256)));
    }
    lines.push(format!("{}: SHA-256 {}", clean(&file.table1.file), clean(&file.table1.sha256)));
    lines.extend(file.logs.iter().flat_map(|log| {
        let lost = log.loss.as_ref().map(|loss| format!("log {}: {}", clean(&log.file), clean(&loss.to_string())));
        std::iter::once(format!("log {}: SHA-256 {}", clean(&log.file), clean(&log.sha256))).chain(lost)
    }));
    lines
}

/// The lines for the lateral compensation.
pub(crate) fn lateral_lines(file: &LateralTableFile, proof: &Proof) -> Vec<String> {
    let mut lines = vec![
        format!("Written by pivot-cal {} from lateral_table.json; do not edit.", env!("CARGO_PKG_VERSION")),
        proof_line(proof),
        format!(
            "Vehicle: wheelbase {} m. {} entries; the curve has {} points.",
            file.vehicle.wheelbase_m,
            file.entries.len(),
            file.curve.error_m.len()
        ),
        format!("{}: SHA-256 {}", clean(&file.csv.file), clean(&file.csv.sha256)),
    ];
    lines.extend(file.logs.iter().map(|log| format!("log {}: SHA-256 {}", clean(&log.file), clean(&log.sha256))));
    lines
}

/// The controller that the verdict is about: its file, and all of its settings.
fn controller_lines(controller: &ControllerFile) -> impl Iterator<Item = String> {
    let head = format!("Controller settings: {}, SHA-256 {}.", clean(controller.settings().name()), clean(controller.sha256()));
    std::iter::once(head).chain(controller.settings().lines().into_iter().map(|line| format!("  {}", harmless(&line))))
}

/// The verdict on the map. Signs become words.
fn proof_line(proof: &Proof) -> String {
    let words = [("°", " deg"), ("±", "+-"), ("·", "."), ("²", "2"), ("³", "3"), ("/", " per "), ("µ", "u")];
    harmless(&words.iter().fold(proof.line(), |line, (sign, word)| line.replace(sign, word)))
}

/// Letters, digits and signs of a sentence that end no comment; every other character becomes `_`.
fn harmless(line: &str) -> String {
    line.chars().map(|c| if c.is_ascii_alphanumeric() || "._-+ :;,()%=".contains(c) { c } else { '_' }).collect()
}

/// Letters, digits and harmless signs; every other character becomes `_`.
fn clean(text: &str) -> String {
    text.chars().map(|c| if c.is_ascii_alphanumeric() || matches!(c, '.' | '_' | '-' | '+' | ' ') { c } else { '_' }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_name_cannot_end_the_comment() {
        assert_eq!(clean("a*/b\nc\".mcap"), "a__b_c_.mcap");
        let proof = Proof { is_verified: false, reason: "0.9° of 1 m/s² */ \n-->".to_owned(), controller: None };
        assert_eq!(proof_line(&proof), "UNVERIFIED, not for deployment: 0.9 deg of 1 m per s2 * per  _--_.".replace('*', "_"));
    }
}
