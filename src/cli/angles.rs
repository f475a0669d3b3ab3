//! Wheel angles on the command line: which ones are fitted, what is said of them, and the files of angles that are no more.

use crate::campaign;
use crate::campaign::{Census, Grouped, group_by_angle};
use crate::cli::Ui;
use crate::log::Recording;
use crate::map::{AngleFamily, Table1File, WheelAngle, is_csv_name};
use anyhow::bail;
use std::path::Path;

/// What several wheel angles are fitted from.
pub(crate) struct AngleChoice {
    pub(crate) grouped: Grouped,
    /// The angle of the plain file names.
    pub(crate) test_angle_deg: f64,
}

/// The angles that are fitted: those asked for, else all at which enough torques were held. `None` where that is the test angle alone, or one
/// angle is asked for, which is then the test angle of the fit.
pub(crate) fn choose(recordings: &[Recording], census: &Census, asked: &[f64], ui: Ui) -> anyhow::Result<Option<AngleChoice>> {
    let Some(test_angle_deg) = recordings.first().map(|r| r.vehicle.test_angle_deg) else { return Ok(None) };
    let settings = campaign::SurveySettings::default();
    let is = |a: f64, b: f64| WheelAngle::from_deg(a).is_same_deg(b);
    if asked.len() == 1 {
        return Ok(None);
    }
    let mut angles_deg = Vec::new();
    for angle in asked {
        let Some(held) = census.find(*angle, &settings) else {
            bail!("--angle {angle}: no run was driven there; the wheel angles of the runs are {}", census.text());
        };
        if angles_deg.iter().any(|a| is(*a, held.wheel_angle_deg)) {
            bail!("--angle {angle}: the runs at {held} are asked for twice");
        }
        angles_deg.push(held.wheel_angle_deg);
    }
    let mut notes = Vec::new();
    if asked.is_empty() {
        for held in &census.held {
            if held.is_campaign() {
                angles_deg.push(held.wheel_angle_deg);
            } else if !is(held.wheel_angle_deg, test_angle_deg) {
                notes.push(format!("the runs at {held} are too few for a map of that angle: at least three torques are needed"));
            }
        }
        if !angles_deg.iter().any(|a| !is(*a, test_angle_deg)) || !census.held.iter().any(|h| is(h.wheel_angle_deg, test_angle_deg)) {
            for note in notes {
                ui.say(format!("note: {note}"));
            }
            return Ok(None);
        }
        if !angles_deg.iter().any(|a| is(*a, test_angle_deg)) {
            // its runs are few, and the fit says what they lack
            angles_deg.push(test_angle_deg);
        }
    }
    for held in census.held.iter().filter(|h| angles_deg.iter().any(|a| is(*a, h.wheel_angle_deg))) {
        let [low, high] = held.range_deg;
        if high - low > settings.angle_tolerance_deg {
            notes.push(format!("runs between {low:.1}° and {high:.1}° are taken for one wheel angle, {}°", held.wheel_angle_deg));
        }
    }
    if census.drifting_runs > 0 {
        let most = 2.0 * settings.angle_tolerance_deg;
        notes.push(format!("{} run(s) have no wheel angle: the wheel turned by more than {most}° along them", census.drifting_runs));
    }
    if census.between_runs > 0 {
        notes.push(format!(
            "{} run(s) lie more than {}° and less than {}° from a wheel angle with more runs, and belong to none",
            census.between_runs,
            settings.angle_tolerance_deg,
            2.0 * settings.angle_tolerance_deg
        ));
    }
    let mut grouped = group_by_angle(recordings, &angles_deg, &settings)?;
    if let Some((angle, reason)) = grouped.empty.first().filter(|_| !asked.is_empty()) {
        bail!("--angle {angle}: {reason}");
    }
    notes.append(&mut grouped.notes);
    grouped.notes = notes;
    let test_angle_deg = angles_deg.iter().copied().find(|a| is(*a, test_angle_deg)).unwrap_or(angles_deg[0]);
    Ok(Some(AngleChoice { grouped, test_angle_deg }))
}

/// Leaves the maps at the angles asked for in `file`; families stay, since they hold over the angle.
pub(crate) fn keep(file: &mut Table1File, asked: &[f64]) -> anyhow::Result<()> {
    let is = |a: f64, b: f64| WheelAngle::from_deg(a).is_same_deg(b);
    for angle in asked {
        if !file.maps.iter().any(|m| is(m.wheel_angle_deg, *angle)) {
            let mut found: Vec<f64> = file.maps.iter().map(|m| m.wheel_angle_deg).collect();
            found.sort_unstable_by(f64::total_cmp);
            found.dedup();
            let found: Vec<String> = found.iter().map(|a| format!("{a}°")).collect();
            bail!("--angle {angle}: the file holds no map there; its wheel angles are {}", found.join(", "));
        }
    }
    file.maps.retain(|m| asked.iter().any(|a| is(*a, m.wheel_angle_deg)));
    Ok(())
}

/// The file as one of a single wheel angle, which is then its test angle; says so where it holds others.
pub(crate) fn at(mut file: Table1File, angle_deg: f64, ui: Ui) -> anyhow::Result<Table1File> {
    let maps = file.maps.len();
    keep(&mut file, &[angle_deg])?;
    if file.maps.len() < maps {
        ui.say(format!("the map of {angle_deg}°; table1.json holds those of other wheel angles, too (--angle)"));
    }
    let is = |a: f64| WheelAngle::from_deg(angle_deg).is_same_deg(a);
    file.report.runs.retain(|run| run.wheel_angle_deg.is_none_or(is));
    file.families.clear();
    file.vehicle.test_angle_deg = angle_deg;
    Ok(file)
}

/// A family for people.
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

/// Removes the CSV files of `table` in `folder` that are not among `kept`: a table of an earlier run would pass for one of this one.
pub(crate) fn remove_stale<'a>(folder: &Path, table: &str, kept: impl Iterator<Item = &'a str>) -> anyhow::Result<()> {
    let kept: Vec<&str> = kept.collect();
    let Ok(entries) = std::fs::read_dir(folder) else { return Ok(()) };
    for entry in entries {
        let entry = entry?;
        let name = entry.file_name();
        if let Some(name) = name.to_str().filter(|n| is_csv_name(n, table) && !kept.contains(n)) {
            fs_err::remove_file(folder.join(name))?;
        }
    }
    Ok(())
}
