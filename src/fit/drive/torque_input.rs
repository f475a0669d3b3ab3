//! Which torque the fit uses: the command through dead time and a first-order lag, or the drive's own feedback.
//!
//! One choice is made for all logs. The model of an ordinary drive is more accurate than a noisy feedback. If a first-order lag does not
//! explain the drive (a slew limit, for example), the fit uses the feedback, on three conditions: every log has one, it is dense enough,
//! and it agrees with the command where the drive has settled. The torques of the map are commands; a feedback on another scale would
//! change them unnoticed.

use crate::campaign::Survey;
use crate::fit::FitSettings;
use crate::fit::drive::effective_torque::{EffectiveTorque, Instead};
use crate::fit::drive::feedback_delays::{FeedbackDelays, after_step_ratio, dead_time_through, delays, lag_explains};
use crate::fit::drive::feedback_scale::FeedbackScale;
use crate::fit::drive::measured_torque::{MeasuredTorque, gaps};
use crate::fit::drive::speed_limit::SpeedLimit;
use crate::fit::drive::undelivered::{Undelivered, exceeded_s, undelivered};
use crate::fit::drive_form::drive_model::{DriveKind, DriveModel};
use crate::map::{ActuatorInput, DriveFamily, InputSource, LogRef};
use crate::signal::{Series, Track, saturation};
use std::collections::BTreeMap;

/// Largest departure of a feedback's scale from 1: more is another torque, or a current.
const AGREES: f64 = 0.02;
/// Largest offset of a feedback, as a share of the largest torque.
const MOST_OFFSET: f64 = 0.02;
/// A feedback with a longer time between readings cannot follow the drive after a step [s].
const LONGEST_PERIOD_S: f64 = 0.05;
/// Largest share of the usable time that gaps of the feedback may take.
const MOST_MISSING: f64 = 0.05;

/// Least standard error of a lag by a feedback [s]: stamps are not better.
const LEAST_LAG_STD_ERR_S: f64 = 2e-4;
/// More torque than was asked for counts from this time on [s], and where it takes so many times the time of less: a drive that rings shows both.
const LEAST_EXCEEDED_S: f64 = 1.0;
const RINGING: f64 = 2.0;
/// Share of the usable time without the commanded torque from which on the feedback replaces the command.
const MOST_UNDELIVERED: f64 = 0.03;

/// Source of a log's effective torque.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum TorqueInput {
    /// The command, through an estimated dead time and first-order lag.
    Command,
    /// The feedback, which shows a step `late_s` after the command. The estimated dead time is the rest, from feedback to speed.
    Feedback {
        /// Dead time between command and feedback [s].
        late_s: f64,
        /// Its scale and offset, which are removed.
        scale: FeedbackScale,
    },
}

impl TorqueInput {
    /// The effective torque of a log, given the changes of its command; the drive counts for the command only.
    pub(crate) fn torque(self, track: &Track, changes: &Series, drive: &DriveModel) -> EffectiveTorque {
        match (self, &track.feedback_nm) {
            (Self::Feedback { late_s, scale }, Some(feedback)) => {
                let corrected = scale.corrected(feedback).unwrap_or_else(|| feedback.clone());
                EffectiveTorque::measured(MeasuredTorque::new(&track.command_nm, &corrected, late_s))
            }
            _ => EffectiveTorque::through(changes, drive),
        }
    }

    /// The part of the dead time that is not estimated here, from command to feedback [s].
    pub(crate) fn late_s(self) -> f64 {
        match self {
            Self::Command => 0.0,
            Self::Feedback { late_s, .. } => late_s,
        }
    }
}

/// The choice for all logs, and its reasons.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct TorqueChoice {
    feedback: bool,
    /// The reason, unless the command is the obvious choice.
    reason: Option<String>,
    /// Whether the feedback is the input because the drive did not deliver what was asked for.
    for_undelivered: bool,
    /// Ratio of the drive's residual after steps to that elsewhere.
    ratio: f64,
    delays: BTreeMap<LogRef, FeedbackDelays>,
    /// Scale and offset of each log's feedback, where it is the command's torque.
    scales: BTreeMap<LogRef, FeedbackScale>,
    /// Where each log's feedback lacks commanded torque.
    undelivered: BTreeMap<LogRef, Vec<Undelivered>>,
    /// Time for which the feedbacks show more torque than was asked for [s].
    exceeded_s: f64,
    /// The governor that the speeds show.
    speed_limit: Option<SpeedLimit>,
}

impl TorqueChoice {
    /// From the logs of one fit. A log may occur several times, with the runs of one wheel angle each.
    pub(crate) fn new<'s>(surveys: impl IntoIterator<Item = &'s Survey>, settings: &FitSettings) -> Self {
        let surveys: Vec<&Survey> = surveys.into_iter().collect();
        let tracks: BTreeMap<&LogRef, &Track> = surveys.iter().map(|s| (&s.track.source, &s.track)).collect();
        let read = |track: &Track| FeedbackScale::of(&track.command_nm, track.feedback_nm.as_ref()?);
        let all: BTreeMap<LogRef, FeedbackScale> = tracks.iter().filter_map(|(log, track)| Some(((*log).clone(), read(track)?))).collect();
        let largest_nm = largest_nm(&tracks);
        let saturated = || tracks.values().find_map(|track| saturated(track, largest_nm));
        let disagreement = disagreement(all.values().copied(), largest_nm).or_else(saturated);
        // a feedback of another quantity than the command's torque is of no use
        let scales = if disagreement.is_some() { BTreeMap::new() } else { all };
        let corrected: BTreeMap<&LogRef, Series> =
            scales.iter().filter_map(|(log, scale)| Some((log, scale.corrected(tracks[log].feedback_nm.as_ref()?)?))).collect();
        let found = |log: &LogRef| delays(&tracks[log].command_nm, &corrected[log], settings.lag_s);
        let delays: BTreeMap<LogRef, FeedbackDelays> = scales.keys().filter_map(|log| Some((log.clone(), found(log)?))).collect();
        let undelivered: BTreeMap<LogRef, Vec<Undelivered>> = delays
            .iter()
            .map(|(log, d)| (log.clone(), undelivered(&tracks[log].command_nm, &corrected[log], (d.dead_time_s, d.lag_s))))
            .collect();
        let exceeded_s = delays.iter().map(|(log, d)| exceeded_s(&tracks[log].command_nm, &corrected[log], (d.dead_time_s, d.lag_s))).sum();
        let ratio = after_step_ratio(delays.values());
        let explained = lag_explains(delays.values());
        let objection = || objection(&surveys, &delays);
        let lacking = lacking(&surveys, &undelivered);
        let for_undelivered = settings.drive.is_none() && explained && lacking.is_some();
        let (feedback, reason) = match (disagreement, settings.drive) {
            // an ordinary drive: no reason is given, unless its feedback is not the command's torque
            (Some(how), _) => (false, Some(format!("the feedback {how}: it is not the command's torque, and is not used"))),
            (None, Some(DriveFamily::Feedback)) => match objection() {
                Some(reason) => (false, Some(format!("the feedback was requested, but {reason}"))),
                None => (true, Some("as requested".to_owned())),
            },
            (None, Some(_)) => (false, None),
            (None, None) if delays.is_empty() => (false, None),
            (None, None) if explained && lacking.is_some() && objection().is_none() => (true, lacking),
            (None, None) if explained => (false, None),
            (None, None) if settings.lag_s.is_some() || settings.dead_time_s.is_some() => {
                (false, Some("dead time or lag are given, and the feedback does not follow them".to_owned()))
            }
            (None, None) => match objection() {
                Some(reason) => (false, Some(format!("the feedback does not follow a first-order lag, but {reason}"))),
                None => (true, Some("it does not follow the command through a first-order lag".to_owned())),
            },
        };
        Self {
            feedback,
            reason,
            for_undelivered: feedback && for_undelivered,
            ratio,
            delays,
            scales,
            undelivered,
            exceeded_s,
            speed_limit: SpeedLimit::of(&surveys),
        }
    }

    /// Time for which the feedbacks show more torque than was asked for [s], where that is no ringing around it.
    pub(crate) fn exceeded_s(&self) -> Option<f64> {
        let lacking_s: f64 = self.undelivered.values().flatten().map(|u| u.to_s - u.from_s).sum();
        Some(self.exceeded_s).filter(|s| *s > LEAST_EXCEEDED_S && *s > RINGING * lacking_s)
    }

    /// Source of a log's effective torque.
    pub(crate) fn of(&self, log: &LogRef) -> TorqueInput {
        match (self.delays.get(log), self.scales.get(log)) {
            (Some(found), Some(scale)) if self.feedback => TorqueInput::Feedback { late_s: found.dead_time_s, scale: *scale },
            _ => TorqueInput::Command,
        }
    }

    /// Where a log's drive did not deliver the commanded torque, by its feedback.
    pub(crate) fn undelivered(&self, log: &LogRef) -> &[Undelivered] {
        self.undelivered.get(log).map_or(&[], Vec::as_slice)
    }

    /// The governor that the speeds show.
    pub(crate) fn speed_limit(&self) -> Option<SpeedLimit> {
        self.speed_limit
    }

    /// What replaces the torque of a log's command where it was not delivered: the corrected feedback, in the intervals in which the torque
    /// depends on it.
    pub(crate) fn instead(&self, track: &Track) -> Option<Instead> {
        let undelivered = self.undelivered(&track.source);
        if self.feedback || undelivered.is_empty() {
            return None;
        }
        let (scale, delays) = (self.scales.get(&track.source)?, self.delays.get(&track.source)?);
        let corrected = scale.corrected(track.feedback_nm.as_ref()?)?;
        let intervals = undelivered.iter().map(|u| (u.from_s, u.forgotten_s)).collect();
        Some(Instead { feedback: MeasuredTorque::new(&track.command_nm, &corrected, 0.0), late_s: delays.dead_time_s, intervals })
    }

    /// The same choice with the command as the input.
    pub(crate) fn with_command(&self) -> Self {
        Self { feedback: false, for_undelivered: false, ..self.clone() }
    }

    /// Whether the feedback is the input because no drive behind the command explains what was delivered.
    pub(crate) fn is_for_undelivered(&self) -> bool {
        self.for_undelivered
    }

    /// Whether the feedback is the input.
    pub(crate) fn is_feedback(&self) -> bool {
        self.feedback
    }

    /// Delays of the drive by the feedback of one log.
    pub(crate) fn delays(&self, log: &LogRef) -> Option<&FeedbackDelays> {
        self.delays.get(log)
    }

    /// Dead time from command to feedback by the feedback of one log, with its standard error [s], behind the drive that was found.
    pub(crate) fn feedback_dead_time(&self, track: &Track, drive: &DriveModel) -> Option<(f64, f64)> {
        let first = self.delays(&track.source)?;
        let misfit = if self.feedback { first.misfit() } else { 1.0 };
        let plain = (first.dead_time_s, misfit * first.dead_time_std_err_s);
        if self.feedback || drive.kind == DriveKind::FirstOrder {
            return Some(plain);
        }
        let corrected = self.scales.get(&track.source)?.corrected(track.feedback_nm.as_ref()?)?;
        let torque = EffectiveTorque::through(&track.command_nm, drive);
        Some(dead_time_through(&torque, &track.command_nm, &corrected, first).unwrap_or(plain))
    }

    /// Lag of the drive by the feedbacks of all logs, with its standard error [s]: where a first-order lag explains them, and they are not the
    /// input themselves.
    pub(crate) fn feedback_lag(&self) -> Option<(f64, f64)> {
        if self.feedback || self.delays.is_empty() || !lag_explains(self.delays.values()) {
            return None;
        }
        let weight = |f: &FeedbackDelays| (f.misfit() * f.lag_std_err_s).max(LEAST_LAG_STD_ERR_S).powi(-2);
        let weights: f64 = self.delays.values().map(weight).sum();
        let mean = self.delays.values().map(|f| weight(f) * f.lag_s).sum::<f64>() / weights;
        // logs that disagree more than their errors widen it
        let count = self.delays.len() as f64;
        let chi_square: f64 = self.delays.values().map(|f| weight(f) * (f.lag_s - mean).powi(2)).sum();
        let spread = (chi_square / (count - 1.0).max(1.0)).max(1.0);
        Some((mean, (spread / weights).sqrt().max(LEAST_LAG_STD_ERR_S)))
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
                 has settled), and it agrees with the command there, its scale and offset taken out; dead time and lag are those of the nearest first-order drive",
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

/// Reason for the feedback of a drive that follows a first-order lag: it shows torque that was not delivered in much of the usable time.
fn lacking(surveys: &[&Survey], undelivered: &BTreeMap<LogRef, Vec<Undelivered>>) -> Option<String> {
    let (mut usable_s, mut lacking_s) = (0.0, 0.0);
    for survey in surveys {
        let of_log = undelivered.get(&survey.track.source).map_or(&[][..], Vec::as_slice);
        for stretch in &survey.stretches {
            usable_s += stretch.to_s - stretch.from_s;
            lacking_s += of_log.iter().map(|u| (u.to_s.min(stretch.to_s) - u.from_s.max(stretch.from_s)).max(0.0)).sum::<f64>();
        }
    }
    (lacking_s > MOST_UNDELIVERED * usable_s).then(|| format!("it shows that the torque was not delivered for {lacking_s:.1} s"))
}

/// The largest torque commanded [N·m].
fn largest_nm(tracks: &BTreeMap<&LogRef, &Track>) -> f64 {
    tracks.values().flat_map(|t| &t.command_nm.value).fold(0.0f64, |m, v| m.max(v.abs()))
}

/// How the feedback differs from the command's torque, if it does in any log.
fn disagreement(mut scales: impl Iterator<Item = FeedbackScale>, largest_nm: f64) -> Option<String> {
    let side = |value: f64| if value > 0.0 { "high" } else { "low" };
    scales.find_map(|FeedbackScale { scale, offset_nm }| {
        if scale < 0.0 {
            Some("has the other sign than the command".to_owned())
        } else if (scale - 1.0).abs() > AGREES {
            Some(format!("reads {:.0} % {}", 100.0 * (scale - 1.0).abs(), side(scale - 1.0)))
        } else if offset_nm.abs() > MOST_OFFSET * largest_nm {
            Some(format!("reads {:.1} N·m {}", offset_nm.abs(), side(offset_nm)))
        } else {
            None
        }
    })
}

/// Where a feedback saturates below the torque that was commanded.
fn saturated(track: &Track, largest_nm: f64) -> Option<String> {
    let feedback = track.feedback_nm.as_ref()?;
    let below = |at_nm: &f64| at_nm.abs() < (1.0 - AGREES) * largest_nm && at_nm.abs() > MOST_OFFSET * largest_nm;
    let at_nm = saturation(&feedback.value).into_iter().flatten().find(below)?;
    Some(format!("saturates at {at_nm:.1} N·m instead of {largest_nm:.1} N·m"))
}
