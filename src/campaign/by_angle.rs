//! One survey per log and wheel angle.
//!
//! In: [`Recording`]s and the wheel angles wanted. Out: an [`AngleGroup`] per angle, its surveys as if the log had been driven for that angle
//! alone: samples elsewhere are left out as *wheel not at angle*.
//!
//! The yaw rate is a witness of the wheel's speed by v = L·θ̇ / sin δ, whose scale is as good as sin δ is known: an angle sensor's bias of 0.3°
//! changes it by 0.00001 at 90°, by 0.9 % at 30°, and without bound toward 0°. Hence the angle with the largest |sin δ| alone tells the
//! encoder's scale; elsewhere the yaw rate is scaled to agree with the encoder, and below 15° it is left out. At 0° there is none.

use crate::campaign::{Survey, SurveySettings};
use crate::log::Recording;
use crate::signal::{Result, Track, median};
use crate::units::RAD_PER_DEG;

/// Below this wheel angle the yaw rate tells no speed [°]: a wheel angle that wanders by 0.3° would pass for 2 % of slip.
const LEAST_YAW_ANGLE_DEG: f64 = 15.0;
/// A scale beyond what a wheel angle that is off by the tolerance explains is told, from this excess on.
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
    /// Surveys of runs at one wheel angle, that of the first.
    pub fn of(surveys: Vec<Survey>) -> Self {
        Self { wheel_angle_deg: surveys.first().map_or(0.0, |s| s.track.wheel_angle_deg), surveys }
    }
}

/// What grouping gives.
#[derive(Debug, Clone, Default)]
pub struct Grouped {
    /// The groups, by ascending angle.
    pub groups: Vec<AngleGroup>,
    /// Angles at which no log holds anything to use, with the reason of each log.
    pub empty: Vec<(f64, String)>,
    /// What a reader should know of the yaw rate.
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
/// Signals from which no track can be made.
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

/// Encoder over yaw speed, the median over the logs; absent without a yaw rate, or where nothing moves fast enough.
fn encoder_over_yaw(group: &AngleGroup) -> Option<f64> {
    let scales: Vec<f64> = group.surveys.iter().filter_map(|s| s.alignment).map(|a| a.scale).collect();
    (!scales.is_empty()).then(|| median(&scales))
}

/// Scales the yaw speeds of all groups but that with the largest |sin δ| so that encoder and yaw rate compare there as they do in it.
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
                "at {}° the yaw rate tells a speed {:.1} % off the encoder's, more than a wheel angle off by {}° explains: slip, or a wrong wheelbase",
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
            // the same samples pass as before, or more, now that no false slip parts the witnesses
            if let Ok(again) = Survey::new(track, settings) {
                *survey = again;
            }
        }
    }
}
