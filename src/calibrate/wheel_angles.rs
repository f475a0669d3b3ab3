//! Wheel angles of a campaign: the fitted ones, and the kept maps of a file.

use crate::calibrate::{Error, Listener, Result, StageEvent};
use crate::campaign::{Census, Grouped, SurveySettings, group_by_angle};
use crate::log::Recording;
use crate::map::{Table1File, WheelAngle};

/// Input of a fit at several wheel angles.
pub(crate) struct AngleChoice {
    pub(crate) grouped: Grouped,
    /// The angle of the plain file names.
    pub(crate) test_angle_deg: f64,
}

/// The fitted angles: the requested ones, otherwise all at which enough torques were held. `None` if that is the test angle alone, or if
/// one angle is requested, which is then the test angle of the fit.
pub(crate) fn choose_angles(recordings: &[Recording], census: &Census, asked: &[f64], listen: &Listener) -> Result<Option<AngleChoice>> {
    let Some(test_angle_deg) = recordings.first().map(|r| r.vehicle.test_angle_deg) else { return Ok(None) };
    let settings = SurveySettings::default();
    let is = |a: f64, b: f64| WheelAngle::from_deg(a).is_same_deg(b);
    if asked.len() == 1 {
        return Ok(None);
    }
    let mut angles_deg = Vec::new();
    for angle in asked {
        let Some(held) = census.find(*angle, &settings) else {
            return Err(wrong(*angle, format!("no run was driven there; the wheel angles of the runs are {}", census.text())));
        };
        if angles_deg.iter().any(|a| is(*a, held.wheel_angle_deg)) {
            return Err(wrong(*angle, format!("the runs at {held} are requested twice")));
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
                listen(StageEvent::Note(format!("note: {note}")));
            }
            return Ok(None);
        }
        if !angles_deg.iter().any(|a| is(*a, test_angle_deg)) {
            // it has few runs, and the fit reports what is missing
            angles_deg.push(test_angle_deg);
        }
    }
    for held in census.held.iter().filter(|h| angles_deg.iter().any(|a| is(*a, h.wheel_angle_deg))) {
        let [low, high] = held.range_deg;
        if high - low > settings.angle_tolerance_deg {
            notes.push(format!("runs between {low:.1}° and {high:.1}° count as one wheel angle, {}°", held.wheel_angle_deg));
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
        return Err(wrong(*angle, reason.clone()));
    }
    notes.append(&mut grouped.notes);
    grouped.notes = notes;
    let test_angle_deg = angles_deg.iter().copied().find(|a| is(*a, test_angle_deg)).unwrap_or(angles_deg[0]);
    Ok(Some(AngleChoice { grouped, test_angle_deg }))
}

/// Keeps the maps at the wheel angles `asked` [°] in `file`; families stay, since they apply to all angles.
///
/// # Errors
/// An angle without a map in the file.
pub(crate) fn keep_angles(file: &mut Table1File, asked: &[f64]) -> Result<()> {
    let is = |a: f64, b: f64| WheelAngle::from_deg(a).is_same_deg(b);
    for angle in asked {
        if !file.maps.iter().any(|m| is(m.wheel_angle_deg, *angle)) {
            let mut found: Vec<f64> = file.maps.iter().map(|m| m.wheel_angle_deg).collect();
            found.sort_unstable_by(f64::total_cmp);
            found.dedup();
            let found: Vec<String> = found.iter().map(|a| format!("{a}°")).collect();
            return Err(wrong(*angle, format!("the file holds no map there; its wheel angles are {}", found.join(", "))));
        }
    }
    file.maps.retain(|m| asked.iter().any(|a| is(*a, m.wheel_angle_deg)));
    Ok(())
}

/// The file as one of a single wheel angle [°], which is then its test angle.
///
/// # Errors
/// An angle without a map in the file.
pub(crate) fn only_angle(mut file: Table1File, angle_deg: f64) -> Result<Table1File> {
    keep_angles(&mut file, &[angle_deg])?;
    let is = |a: f64| WheelAngle::from_deg(angle_deg).is_same_deg(a);
    file.report.runs.retain(|run| run.wheel_angle_deg.is_none_or(is));
    file.families.clear();
    file.vehicle.test_angle_deg = angle_deg;
    Ok(file)
}

fn wrong(angle_deg: f64, reason: String) -> Error {
    Error::WheelAngle { angle_deg, reason }
}
