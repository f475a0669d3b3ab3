//! One survey per log and wheel angle.
//!
//! In: [`Recording`]s and the wanted wheel angles. Out: an [`AngleGroup`] per angle. Its surveys treat the log as driven for that angle
//! alone: samples at other angles are left out as *wheel not at angle*.
//!
//! v = L·θ̇ / sin δ gives the wheel's speed from the yaw rate. Its scale is only as accurate as sin δ: an angle sensor's bias of 0.3°
//! changes it by 0.00001 at 90°, by 0.9 % at 30°, and without bound toward 0°. Hence only the angle with the largest |sin δ| determines the
//! encoder's scale. At other angles the yaw rate is scaled to agree with the encoder; below 15° it is ignored. At 0° it gives no speed.

use crate::campaign::{Survey, SurveySettings};
use crate::log::Recording;
use crate::signal::{Result, Track, median};
use crate::units::RAD_PER_DEG;

/// Below this wheel angle the yaw rate gives no speed [°]: a wheel angle that drifts by 0.3° would look like 2 % of slip.
const LEAST_YAW_ANGLE_DEG: f64 = 15.0;
/// A scale error is reported if it exceeds, by this amount, the error from a wheel angle that is wrong by the tolerance.
const UNEXPLAINED: f64 = 0.01;

/// The surveys of the runs at one wheel angle.
#[derive(Debug, Clone)]
pub struct AngleGroup {
    /// The wheel angle [°], left positive.
    pub wheel_angle_deg: f64,
    /// One survey per log with runs there.
    pub surveys: Vec<Survey>,
}

impl AngleGroup {
    /// Surveys of runs at one wheel angle, the angle of the first survey.
    pub fn of(surveys: Vec<Survey>) -> Self {
        Self { wheel_angle_deg: surveys.first().map_or(0.0, |s| s.track.wheel_angle_deg), surveys }
    }
}

/// Result of grouping.
#[derive(Debug, Clone, Default)]
pub struct Grouped {
    /// The groups, by ascending angle.
    pub groups: Vec<AngleGroup>,
    /// Angles without usable data in any log, with the reason of each log.
    pub empty: Vec<(f64, String)>,
    /// Notes on the yaw rate.
    pub notes: Vec<String>,
}

impl From<AngleGroup> for Grouped {
    fn from(group: AngleGroup) -> Self {
        Self { groups: vec![group], ..Self::default() }
    }
}

/// Surveys every log at each of `angles_deg`.
///
/// # Errors
/// No track can be made from the signals.
pub fn group_by_angle(recordings: &[Recording], angles_deg: &[f64], settings: &SurveySettings) -> Result<Grouped> {
    let mut angles_deg = angles_deg.to_vec();
    angles_deg.sort_unstable_by(f64::total_cmp);
    angles_deg.dedup();
    let mut grouped = Grouped::default();
    for wheel_angle_deg in angles_deg {
        let (mut surveys, mut reasons) = (Vec::new(), Vec::new());
        for recording in recordings {
            let mut track = Track::at_angle(recording, wheel_angle_deg)?;
            if wheel_angle_deg.abs() < LEAST_YAW_ANGLE_DEG {
                track.yaw_speed_mps = None;
            }
            match Survey::new(track, settings) {
                Ok(survey) => surveys.push(survey),
                Err(error) => reasons.push(format!("{}: {error}", recording.source.file)),
            }
        }
        if surveys.is_empty() {
            grouped.empty.push((wheel_angle_deg, reasons.join("; ")));
        } else {
            grouped.groups.push(AngleGroup { wheel_angle_deg, surveys });
        }
    }
    scale_yaw_rates(&mut grouped, settings);
    Ok(grouped)
}

/// Sine of the wheel angle's magnitude.
fn sine(group: &AngleGroup) -> f64 {
    (group.wheel_angle_deg * RAD_PER_DEG).sin().abs()
}

/// Encoder speed over yaw speed, the median over the logs; absent without a yaw rate or without enough speed.
fn encoder_over_yaw(group: &AngleGroup) -> Option<f64> {
    let scales: Vec<f64> = group.surveys.iter().filter_map(|s| s.alignment).map(|a| a.scale).collect();
    (!scales.is_empty()).then(|| median(&scales))
}

/// Scales the yaw speeds of all groups so that the ratio of encoder and yaw speed equals that of the group with the largest |sin δ|.
fn scale_yaw_rates(grouped: &mut Grouped, settings: &SurveySettings) {
    let with_yaw = || grouped.groups.iter().filter(|g| encoder_over_yaw(g).is_some());
    let Some(best) = with_yaw().max_by(|a, b| sine(a).total_cmp(&sine(b)).then(a.wheel_angle_deg.total_cmp(&b.wheel_angle_deg))) else {
        return;
    };
    let (reference_deg, Some(reference)) = (best.wheel_angle_deg, encoder_over_yaw(best)) else { return };
    for group in grouped.groups.iter_mut().filter(|g| (g.wheel_angle_deg - reference_deg).abs() > 1e-9) {
        let Some(scale) = encoder_over_yaw(group) else { continue };
        let factor = scale / reference;
        let explained = settings.angle_tolerance_deg * RAD_PER_DEG / (group.wheel_angle_deg * RAD_PER_DEG).tan().abs();
        if (factor - 1.0).abs() > explained + UNEXPLAINED {
            grouped.notes.push(format!(
                "at {}° the speed from the yaw rate differs from the encoder's by {:.1} %, more than a wheel angle error of {}° explains: slip, or a wrong wheelbase",
                group.wheel_angle_deg,
                100.0 * (factor - 1.0).abs(),
                settings.angle_tolerance_deg
            ));
        }
        for survey in &mut group.surveys {
            let mut track = survey.track.clone();
            if let Some(yaw) = &mut track.yaw_speed_mps {
                yaw.value.iter_mut().for_each(|v| *v *= factor);
            }
            // the same samples pass as before, or more, because false slip between the speed sources is gone
            if let Ok(again) = Survey::new(track, settings) {
                *survey = again;
            }
        }
    }
}
