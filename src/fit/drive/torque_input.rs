//! Which torque the fit uses: the command through dead time and a first-order lag, or the drive's own feedback.
//!
//! One choice is made for all logs. The model of an ordinary drive is more accurate than a noisy feedback. If a first-order lag does not
//! explain the drive (a slew limit, for example), the fit uses the feedback, on three conditions: every log has one, it is dense enough,
//! and it agrees with the command where the drive has settled. The torques of the map are commands; a feedback on another scale would
//! change them unnoticed.

use crate::campaign::Survey;
use crate::fit::FitSettings;
use crate::fit::drive::drive_model::{DriveKind, DriveModel};
use crate::fit::drive::effective_torque::EffectiveTorque;
use crate::fit::drive::feedback_delays::{FeedbackDelays, after_step_ratio, delays, lag_explains};
use crate::fit::drive::lagged_command::LaggedCommand;
use crate::fit::drive::measured_torque::{MeasuredTorque, gaps};
use crate::fit::drive::sampled_torque::SampledTorque;
use crate::fit::drive::settled_holds::{FeedbackReading, Settled, reading, settled};
use crate::map::{ActuatorInput, InputSource, LogRef};
use crate::signal::{Series, Track};
use std::collections::BTreeMap;

/// Largest departure of the feedback from the command where the drive has settled: of the scale, and of the offset as a share of the
/// largest torque.
const AGREES: f64 = 0.02;
/// Largest share of the settled holds whose feedback may be off.
const MOST_OFF: f64 = 0.1;
/// A feedback with a longer time between readings cannot follow the drive after a step [s].
const LONGEST_PERIOD_S: f64 = 0.05;
/// Largest share of the usable time that gaps of the feedback may take.
const MOST_MISSING: f64 = 0.05;

/// Source of a log's effective torque.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum TorqueInput {
    /// The command, through an estimated dead time and first-order lag.
    Command,
    /// The feedback, which shows a step `late_s` after the command. The estimated dead time is the rest, from feedback to speed.
    Feedback {
        /// Dead time between command and feedback [s].
        late_s: f64,
    },
}

impl TorqueInput {
    /// The effective torque of a log, given the changes of its command; the drive counts for the command only.
    pub(crate) fn torque(self, track: &Track, changes: &Series, drive: &DriveModel) -> EffectiveTorque {
        match (self, &track.feedback_nm) {
            (Self::Feedback { late_s }, Some(feedback)) => {
                EffectiveTorque::Measured(MeasuredTorque::new(&track.command_nm, feedback, late_s))
            }
            _ if drive.kind == DriveKind::FirstOrder => EffectiveTorque::Lagged(LaggedCommand::new(changes, drive.lag_s())),
            _ => EffectiveTorque::Sampled(SampledTorque::new(changes, drive)),
        }
    }

    /// The part of the dead time that is not estimated here, from command to feedback [s].
    pub(crate) fn late_s(self) -> f64 {
        match self {
            Self::Command => 0.0,
            Self::Feedback { late_s } => late_s,
        }
    }
}

/// The choice for all logs, and its reasons.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct TorqueChoice {
    feedback: bool,
    /// The reason, unless the command is the obvious choice.
    reason: Option<String>,
    /// Ratio of the drive's residual after steps to that elsewhere.
    ratio: f64,
    delays: BTreeMap<LogRef, FeedbackDelays>,
}

impl TorqueChoice {
    /// From the logs of one fit. A log may occur several times, with the runs of one wheel angle each.
    pub(crate) fn new<'s>(surveys: impl IntoIterator<Item = &'s Survey>, settings: &FitSettings) -> Self {
        let surveys: Vec<&Survey> = surveys.into_iter().collect();
        let tracks: BTreeMap<&LogRef, &Track> = surveys.iter().map(|s| (&s.track.source, &s.track)).collect();
        let found = |track: &Track| delays(&track.command_nm, track.feedback_nm.as_ref()?, settings.lag_s);
        let delays: BTreeMap<LogRef, FeedbackDelays> =
            tracks.iter().filter_map(|(log, track)| Some(((*log).clone(), found(track)?))).collect();
        let ratio = after_step_ratio(delays.values());
        let explained = lag_explains(delays.values());
        let disagreement = (!delays.is_empty()).then(|| disagreement(&tracks, &delays));
        let (feedback, reason) = match disagreement {
            None => (false, None),
            // an ordinary drive: nothing to say, unless its feedback is not what it seems
            Some(disagreement) if explained => (false, disagreement.flatten().map(|how| format!("the feedback {how}"))),
            Some(_) if settings.lag_s.is_some() || settings.dead_time_s.is_some() => {
                (false, Some("dead time or lag are given, and the feedback does not follow them".to_owned()))
            }
            Some(disagreement) => {
                let objection = objection(&surveys, &delays);
                let objection =
                    objection.or_else(|| disagreement.unwrap_or_else(|| Some("has too few settled holds to compare".to_owned())));
                match objection {
                    Some(reason) => (false, Some(format!("the feedback does not follow a first-order lag, but {reason}"))),
                    None => (true, Some("it does not follow the command through a first-order lag".to_owned())),
                }
            }
        };
        Self { feedback, reason, ratio, delays }
    }

    /// Source of a log's effective torque.
    pub(crate) fn of(&self, log: &LogRef) -> TorqueInput {
        match self.delays.get(log).filter(|_| self.feedback) {
            Some(found) => TorqueInput::Feedback { late_s: found.dead_time_s },
            None => TorqueInput::Command,
        }
    }

    /// Whether the feedback is the input.
    pub(crate) fn is_feedback(&self) -> bool {
        self.feedback
    }

    /// Delays of the drive by the feedback of one log.
    pub(crate) fn delays(&self, log: &LogRef) -> Option<&FeedbackDelays> {
        self.delays.get(log)
    }

    /// Delays of the drive by the feedback of all logs.
    pub(crate) fn all_delays(&self) -> impl ExactSizeIterator<Item = &FeedbackDelays> {
        self.delays.values()
    }

    /// The input's name, with the reason if there is one.
    pub(crate) fn named(&self) -> ActuatorInput {
        let source = if self.feedback { InputSource::TorqueFeedback } else { InputSource::TorqueCommand };
        ActuatorInput { source, reason: self.reason.clone() }
    }

    /// The note for the report.
    pub(crate) fn note(&self) -> Option<String> {
        let reason = self.reason.as_ref()?;
        Some(if self.feedback {
            format!(
                "the torque feedback is the fit's input: {reason} (residual {:.1} times as large in the 0.3 s after a step as where the drive \
                 has settled), and it agrees with the command there; dead time and lag are those of the nearest first-order drive",
                self.ratio
            )
        } else {
            format!("the torque command is the fit's input: {reason}")
        })
    }
}

/// Reason against the feedback of a drive that is not of first order, other than its scale.
fn objection(surveys: &[&Survey], delays: &BTreeMap<LogRef, FeedbackDelays>) -> Option<String> {
    if surveys.iter().any(|s| !delays.contains_key(&s.track.source)) {
        return Some("not every log has one that shows its delays".to_owned());
    }
    let feedbacks = || surveys.iter().filter_map(|s| Some((*s, s.track.feedback_nm.as_ref()?)));
    let period_s = feedbacks().map(|(_, f)| f.median_period_s()).fold(0.0, f64::max);
    if period_s > LONGEST_PERIOD_S {
        return Some(format!("comes at {:.1} Hz only", 1.0 / period_s));
    }
    let (mut usable_s, mut missing_s) = (0.0, 0.0);
    for (survey, feedback) in feedbacks() {
        let gaps = gaps(feedback);
        for stretch in &survey.stretches {
            usable_s += stretch.to_s - stretch.from_s;
            missing_s += gaps.iter().map(|g| (g.1.min(stretch.to_s) - g.0.max(stretch.from_s)).max(0.0)).sum::<f64>();
        }
    }
    (missing_s > MOST_MISSING * usable_s).then(|| format!("is missing in {:.0} % of the usable time", 100.0 * missing_s / usable_s))
}

/// How the feedback differs from the command where the drive has settled. The inner `None`: it does not. The outer `None`: no data.
#[allow(clippy::option_option)] // agreement and ignorance are not the same
fn disagreement(tracks: &BTreeMap<&LogRef, &Track>, delays: &BTreeMap<LogRef, FeedbackDelays>) -> Option<Option<String>> {
    let mut holds: Vec<Settled> = Vec::new();
    let mut largest_nm = 0.0f64;
    for (log, track) in tracks {
        let (Some(feedback), Some(found)) = (&track.feedback_nm, delays.get(*log)) else { continue };
        largest_nm = track.command_nm.value.iter().fold(largest_nm, |m, v| m.max(v.abs()));
        holds.extend(settled(&track.command_nm, feedback, (-found.dead_time_s).max(0.0)));
    }
    let FeedbackReading { scale, offset_nm, share_off, missed } = reading(&holds, largest_nm)?;
    let side = |value: f64| if value > 0.0 { "high" } else { "low" };
    Some(if scale < 0.0 {
        Some("has the other sign than the command".to_owned())
    } else if (scale - 1.0).abs() > AGREES {
        Some(format!("reads {:.0} % {}", 100.0 * (scale - 1.0).abs(), side(scale - 1.0)))
    } else if offset_nm.abs() > AGREES * largest_nm {
        Some(format!("reads {:.1} N·m {}", offset_nm.abs(), side(offset_nm)))
    } else if let Some((command_nm, feedback_nm)) = missed {
        Some(format!("settles at {feedback_nm:.1} instead of {command_nm:.1} N·m"))
    } else if share_off > MOST_OFF {
        Some(format!("does not settle at the command in {:.0} % of the holds", 100.0 * share_off))
    } else {
        None
    })
}
