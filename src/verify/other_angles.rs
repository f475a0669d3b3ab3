//! Pivots with the maps of other wheel angles than the test angle, each on the plant of its angle.

use crate::verify::judge::judge_pivots;
use crate::verify::settings::VerifySettings;
use crate::verify::verdict::ScenarioVerdict;
use crate::verify::{Maps, Result};

/// The scenarios of `settings` at each of the wheel angles [°], named `left-90@80°`.
///
/// # Errors
/// An angle without a forward map, and any error of [`judge_pivots`].
pub(crate) fn at_angles(maps: &Maps, settings: &VerifySettings, angles_deg: &[f64]) -> Result<Vec<ScenarioVerdict>> {
    let mut all = Vec::new();
    for angle_deg in angles_deg {
        let judged = judge_pivots(&maps.at_angle(*angle_deg)?, settings, false)?;
        all.extend(judged.into_iter().map(|scenario| ScenarioVerdict {
            name: format!("{}@{angle_deg}°", scenario.name),
            what: format!("{}, the wheel at {angle_deg}°", scenario.what),
            wheel_angle_deg: Some(*angle_deg),
            ..scenario
        }));
    }
    Ok(all)
}
