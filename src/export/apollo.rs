//! Apollo's calibration table: protobuf text, one `calibration` message per speed and acceleration. Command is 100 · torque / full torque,
//! the full torque being that of [`MapSource::full_torque_nm`]: per cent of throttle when positive, of brake when negative.
//!
//! Sign rules: throttle means acceleration and brake means deceleration, so no entry has a command and an acceleration of opposite sign.
//! Between coasting (command 0) and holding a speed (acceleration 0), friction requires a driving torque at a negative acceleration. There
//! the table has the two ends, and Apollo's linear interpolation gives the values between. Accelerations of the same torque, at a limit or
//! of a wheel that is held, have one entry.
//!
//! Source of the rules: Apollo's longitudinal controller. It looks up the command over (speed, acceleration), uses it as throttle when it
//! is not negative and as brake otherwise, and clamps outside the table.

use crate::export::autoware::rounded;
use crate::export::file::File;
use crate::export::number::plain;
use crate::export::{Error, ExportSettings, MapSource, Result, provenance};
use crate::map::TorqueTable;
use std::fmt::Write as _;

const FORMAT: &str = "apollo";

pub(crate) fn files(source: &MapSource, settings: &ExportSettings) -> Result<Vec<File>> {
    let full_nm = settings.full_scale_nm.unwrap_or_else(|| source.full_torque_nm());
    let mut files = Vec::new();
    for (gear, table) in &source.torque {
        let mut text = String::new();
        for line in provenance::lines(source) {
            let _ = writeln!(text, "# {line}");
        }
        let _ = writeln!(text, "# {gear} gear; command = 100 * torque / {full_nm} N.m");
        let mut largest = 0.0f64;
        for (i, &speed) in table.speed_mps().breaks().iter().enumerate() {
            let (entries, lost) = row(table, i);
            largest = largest.max(lost);
            let mut before: Option<(f64, f64)> = None;
            for (accel, torque) in entries {
                let (accel, command) = (rounded(accel, 1e-6), rounded(100.0 * torque / full_nm, 1e-6));
                if before.is_some_and(|(a, c)| accel <= a || command <= c) {
                    let place = format!("speed {speed} m/s, acceleration {accel} m/s²");
                    return Err(Error::NotMonotone { format: FORMAT, gear: *gear, place });
                }
                before = Some((accel, command));
                text.push_str("calibration {\n");
                for (name, value) in [("speed", speed), ("acceleration", accel), ("command", command)] {
                    let _ = writeln!(text, "  {name}: {}", plain(value));
                }
                text.push_str("}\n");
            }
        }
        let note = format!("command = 100 · torque / {full_nm} N·m; sign rules cost at most {largest:.3} N·m");
        files.push(File { note: Some(note), ..File::new(format!("calibration_table{}.pb.txt", gear.file_infix()), text) });
    }
    Ok(files)
}

/// The entries of one speed, with rising acceleration and torque, and the distance [N·m] of the straight line between coasting and holding
/// from the table there.
fn row(table: &TorqueTable, i: usize) -> (Vec<(f64, f64)>, f64) {
    let accels = table.accel_mps2().breaks();
    let mut all: Vec<(f64, f64)> = Vec::new();
    for entry in accels.iter().enumerate().map(|(j, a)| (*a, table.at(i, j))) {
        match all.last_mut() {
            // of several accelerations of one torque (a limit or a wheel that is held), only the one nearest to the others is written
            Some(last) if last.1 == entry.1 && entry.1 > 0.0 => {}
            Some(last) if last.1 == entry.1 => *last = entry,
            _ => all.push(entry),
        }
    }
    let crossing = |of: fn(&(f64, f64)) -> f64, other: fn(&(f64, f64)) -> f64| {
        all.windows(2).find(|w| of(&w[0]) < 0.0 && of(&w[1]) > 0.0).map(|w| {
            let p = of(&w[0]) / (of(&w[0]) - of(&w[1]));
            (1.0 - p) * other(&w[0]) + p * other(&w[1])
        })
    };
    let coast = crossing(|e| e.1, |e| e.0).map(|accel| (accel, 0.0));
    let hold = crossing(|e| e.0, |e| e.1).map(|torque| (0.0, torque));
    let mut kept: Vec<_> = all.iter().copied().filter(|(a, t)| a * t >= 0.0).chain(coast).chain(hold).collect();
    kept.sort_by(|a, b| a.0.total_cmp(&b.0));
    let dropped = all.iter().filter(|(a, t)| a * t < 0.0);
    let lost = dropped.filter_map(|(a, t)| {
        let k = kept.partition_point(|e| e.0 < *a);
        let (before, after) = (kept.get(k.checked_sub(1)?)?, kept.get(k)?);
        let p = (a - before.0) / (after.0 - before.0);
        Some(((1.0 - p) * before.1 + p * after.1 - t).abs())
    });
    let lost = lost.fold(0.0, f64::max);
    (kept, lost)
}
