//! The effective torque of one log from either source: the command through dead time and a drive, or the drive's own feedback.

use crate::fit::drive::lagged_command::{LaggedCommand, LaggedCursor, Share, Torque};
use crate::fit::drive::measured_torque::{MeasuredCursor, MeasuredTorque};
use crate::fit::drive::sampled_torque::{SampledCursor, SampledTorque};

/// The effective torque of one log, for look-ups at any time minus the dead time.
#[derive(Debug, Clone)]
pub(crate) enum EffectiveTorque {
    /// The command through a first-order lag.
    Lagged(LaggedCommand),
    /// The command through another drive.
    Sampled(SampledTorque),
    /// The torque feedback.
    Measured(MeasuredTorque),
}

/// A position in an effective torque that moves along with time: a look-up near the last one needs no search.
#[derive(Debug, Clone)]
pub(crate) enum TorqueCursor<'a> {
    /// In a lagged command.
    Lagged(LaggedCursor<'a>),
    /// In the response of another drive.
    Sampled(SampledCursor<'a>),
    /// In a torque feedback.
    Measured(MeasuredCursor<'a>),
}

impl TorqueCursor<'_> {
    /// As [`EffectiveTorque::at`].
    pub(crate) fn at(&mut self, t_s: f64) -> Torque {
        match self {
            Self::Lagged(cursor) => cursor.at(t_s),
            Self::Sampled(cursor) => cursor.at(t_s),
            Self::Measured(cursor) => cursor.at(t_s),
        }
    }

    /// Whether the torque moves by more than `share` of the largest between two times, in order.
    pub(crate) fn moves(&mut self, from_s: f64, to_s: f64, share: Share) -> bool {
        match self {
            Self::Lagged(cursor) => cursor.moves(from_s, to_s, share),
            Self::Sampled(cursor) => cursor.moves(from_s, to_s, share),
            Self::Measured(cursor) => cursor.moves(from_s, to_s, share),
        }
    }
}

impl EffectiveTorque {
    /// Effective torque at `t_s`. The dead time is already subtracted: pass t − T_d.
    pub(crate) fn at(&self, t_s: f64) -> Torque {
        match self {
            Self::Lagged(lagged) => lagged.at(t_s),
            Self::Sampled(sampled) => sampled.at(t_s),
            Self::Measured(measured) => measured.at(t_s),
        }
    }

    /// A cursor at the beginning.
    pub(crate) fn cursor(&self) -> TorqueCursor<'_> {
        match self {
            Self::Lagged(lagged) => TorqueCursor::Lagged(lagged.cursor()),
            Self::Sampled(sampled) => TorqueCursor::Sampled(sampled.cursor()),
            Self::Measured(measured) => TorqueCursor::Measured(measured.cursor()),
        }
    }

    /// Largest torque commanded [N·m].
    pub(crate) fn largest_nm(&self) -> f64 {
        match self {
            Self::Lagged(lagged) => lagged.largest_nm(),
            Self::Sampled(sampled) => sampled.largest_nm(),
            Self::Measured(measured) => measured.largest_nm(),
        }
    }

    /// Times at which a change of the command by more than `least_nm` begins to act, without the dead time [s].
    pub(crate) fn steps(&self, least_nm: f64) -> Vec<f64> {
        match self {
            Self::Lagged(lagged) => lagged.steps(least_nm),
            Self::Sampled(sampled) => sampled.steps(least_nm),
            Self::Measured(measured) => measured.steps(least_nm),
        }
    }

    /// Where the torque is unknown [s], in order: gaps of the feedback.
    pub(crate) fn gaps(&self) -> &[(f64, f64)] {
        match self {
            Self::Lagged(_) | Self::Sampled(_) => &[],
            Self::Measured(measured) => measured.gaps(),
        }
    }
}
