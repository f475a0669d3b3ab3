//! The effective torque of one log from either source: the command through dead time and a drive, or the drive's own feedback.

use crate::fit::drive::lagged_command::{LaggedCommand, LaggedCursor, Share};
use crate::fit::drive::measured_torque::{MeasuredCursor, MeasuredTorque};
use crate::fit::drive::sampled_torque::{SampledCursor, SampledTorque};
use crate::fit::drive_form::campaign_drift::CampaignDrift;
use crate::fit::drive_form::drive_model::{DriveKind, DriveModel};
use crate::fit::drive_form::torque::Torque;
use crate::fit::drive_form::torque_limit::TorqueLimit;
use crate::signal::Series;

/// Source of an effective torque.
#[derive(Debug, Clone)]
enum TorqueOrigin {
    /// The command through a first-order lag.
    Lagged(LaggedCommand),
    /// The command through another drive.
    Sampled(SampledTorque),
    /// The torque feedback.
    Measured(MeasuredTorque),
}

/// The effective torque of one log, for look-ups at any time minus the dead time, before the drive's limit.
#[derive(Debug, Clone)]
pub(crate) struct EffectiveTorque {
    source: TorqueOrigin,
    limit: TorqueLimit,
    drift: CampaignDrift,
    /// Intervals in which the feedback gives the torque instead.
    instead: Option<Instead>,
}

/// A feedback instead of the command's torque, in some intervals.
#[derive(Debug, Clone)]
pub(crate) struct Instead {
    pub(crate) feedback: MeasuredTorque,
    /// Time by which the feedback is later than the command [s].
    pub(crate) late_s: f64,
    /// On the command's clock, in order [s].
    pub(crate) intervals: Vec<(f64, f64)>,
}

impl Instead {
    fn holds(&self, t_s: f64) -> bool {
        let k = self.intervals.partition_point(|i| i.1 < t_s);
        self.intervals.get(k).is_some_and(|i| i.0 <= t_s)
    }

    /// The torque at a time of the command's clock, if the feedback gives it.
    fn at(&self, t_s: f64) -> Option<Torque> {
        self.holds(t_s).then(|| self.feedback.at(t_s + self.late_s))
    }
}

/// A position in the source of an effective torque.
#[derive(Debug, Clone)]
enum SourceCursor<'a> {
    /// In a lagged command.
    Lagged(LaggedCursor<'a>),
    /// In the response of another drive.
    Sampled(SampledCursor<'a>),
    /// In a torque feedback.
    Measured(MeasuredCursor<'a>),
}

impl SourceCursor<'_> {
    fn at(&mut self, t_s: f64) -> Torque {
        match self {
            Self::Lagged(cursor) => cursor.at(t_s),
            Self::Sampled(cursor) => cursor.at(t_s),
            Self::Measured(cursor) => cursor.at(t_s),
        }
    }

    fn moves(&mut self, from_s: f64, to_s: f64, share: Share) -> bool {
        match self {
            Self::Lagged(cursor) => cursor.moves(from_s, to_s, share),
            Self::Sampled(cursor) => cursor.moves(from_s, to_s, share),
            Self::Measured(cursor) => cursor.moves(from_s, to_s, share),
        }
    }
}

/// A position in an effective torque that moves along with time: a look-up near the last one needs no search.
#[derive(Debug, Clone)]
pub(crate) struct TorqueCursor<'a> {
    source: SourceCursor<'a>,
    instead: Option<&'a Instead>,
}

impl TorqueCursor<'_> {
    /// As [`EffectiveTorque::at`].
    pub(crate) fn at(&mut self, t_s: f64) -> Torque {
        self.instead.and_then(|i| i.at(t_s)).unwrap_or_else(|| self.source.at(t_s))
    }

    /// Whether the torque moves by more than `share` of the largest between two times, in order.
    pub(crate) fn moves(&mut self, from_s: f64, to_s: f64, share: Share) -> bool {
        // a feedback may move at any time
        self.instead.is_some_and(|i| i.holds(from_s) || i.holds(to_s)) || self.source.moves(from_s, to_s, share)
    }
}

impl EffectiveTorque {
    /// The command through a first-order lag.
    pub(crate) fn lagged(command: LaggedCommand) -> Self {
        Self { source: TorqueOrigin::Lagged(command), limit: TorqueLimit::None, drift: CampaignDrift::default(), instead: None }
    }

    /// The changes of a command through a drive. A torque limit bounds what the drive aims at; a power limit depends on the speed and acts
    /// on what comes out.
    pub(crate) fn through(changes: &Series, drive: &DriveModel) -> Self {
        let bounded = match drive.limit {
            TorqueLimit::Torque(most_nm) => {
                Some(Series { value: changes.value.iter().map(|u| u.clamp(-most_nm, most_nm)).collect(), ..changes.clone() })
            }
            _ => None,
        };
        let changes = bounded.as_ref().unwrap_or(changes);
        let source = if drive.kind == DriveKind::FirstOrder {
            TorqueOrigin::Lagged(LaggedCommand::new(changes, drive.lag_s()))
        } else {
            TorqueOrigin::Sampled(SampledTorque::new(changes, drive))
        };
        Self { source, limit: drive.limit, drift: CampaignDrift::default(), instead: None }
    }

    /// The torque feedback, which is right for any drive.
    pub(crate) fn measured(feedback: MeasuredTorque) -> Self {
        Self { source: TorqueOrigin::Measured(feedback), limit: TorqueLimit::None, drift: CampaignDrift::default(), instead: None }
    }

    /// The same with what changes during the campaign.
    pub(crate) fn drifting(self, drift: CampaignDrift) -> Self {
        Self { drift, ..self }
    }

    /// What changes during the campaign.
    pub(crate) fn drift(&self) -> CampaignDrift {
        self.drift
    }

    /// The limit of the delivered torque.
    pub(crate) fn limit(&self) -> TorqueLimit {
        self.limit
    }

    /// The same with a feedback instead of the command in some intervals.
    pub(crate) fn with_feedback(self, instead: Instead) -> Self {
        Self { instead: Some(instead), ..self }
    }

    /// Effective torque at `t_s`. The dead time is already subtracted: pass t − T_d.
    pub(crate) fn at(&self, t_s: f64) -> Torque {
        self.cursor().at(t_s)
    }

    /// A cursor at the beginning.
    pub(crate) fn cursor(&self) -> TorqueCursor<'_> {
        let source = match &self.source {
            TorqueOrigin::Lagged(lagged) => SourceCursor::Lagged(lagged.cursor()),
            TorqueOrigin::Sampled(sampled) => SourceCursor::Sampled(sampled.cursor()),
            TorqueOrigin::Measured(measured) => SourceCursor::Measured(measured.cursor()),
        };
        TorqueCursor { source, instead: self.instead.as_ref() }
    }

    /// Largest torque commanded [N·m].
    pub(crate) fn largest_nm(&self) -> f64 {
        match &self.source {
            TorqueOrigin::Lagged(lagged) => lagged.largest_nm(),
            TorqueOrigin::Sampled(sampled) => sampled.largest_nm(),
            TorqueOrigin::Measured(measured) => measured.largest_nm(),
        }
    }

    /// Times at which a change of the command by more than `least_nm` begins to act, without the dead time [s].
    pub(crate) fn steps(&self, least_nm: f64) -> Vec<f64> {
        match &self.source {
            TorqueOrigin::Lagged(lagged) => lagged.steps(least_nm),
            TorqueOrigin::Sampled(sampled) => sampled.steps(least_nm),
            TorqueOrigin::Measured(measured) => measured.steps(least_nm),
        }
    }

    /// Where the torque is unknown [s], in order: gaps of the feedback.
    pub(crate) fn gaps(&self) -> &[(f64, f64)] {
        match &self.source {
            TorqueOrigin::Lagged(_) | TorqueOrigin::Sampled(_) => &[],
            TorqueOrigin::Measured(measured) => measured.gaps(),
        }
    }
}
