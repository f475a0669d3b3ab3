//! Settings of a controller file that are words.

use crate::control::{Nearest, OutsidePolicy, WheelPolicy};
use crate::controller::setting::{Settable, Shown};
use serde::{Deserialize, Serialize};

/// Wheel policy of the vehicle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Policy {
    /// Both are judged, each by its own pivots.
    Both,
    /// The wheel always at its test angle; right turns in reverse gear.
    HoldLeft,
    /// The wheel to the right for right turns; always forward gear.
    Mirror,
}

impl Settable for Policy {
    const WORDS: &'static [&'static str] = &["both", "hold-left", "mirror"];

    fn shown(self) -> Shown {
        Shown::Word(match self {
            Self::Both => "both",
            Self::HoldLeft => "hold-left",
            Self::Mirror => "mirror",
        })
    }
}

/// Method of locating the wheel on the path.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Locate {
    /// The nearest waypoint.
    Waypoint,
    /// The foot of the perpendicular.
    Projection,
}

impl Settable for Locate {
    const WORDS: &'static [&'static str] = &["waypoint", "projection"];

    fn shown(self) -> Shown {
        Shown::Word(match self {
            Self::Waypoint => "waypoint",
            Self::Projection => "projection",
        })
    }
}

/// Policy outside the table's axes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Outside {
    /// The edge value.
    Clamp,
    /// No torque; the pivot fails.
    Refuse,
}

impl Settable for Outside {
    const WORDS: &'static [&'static str] = &["clamp", "refuse"];

    fn shown(self) -> Shown {
        Shown::Word(match self {
            Self::Clamp => "clamp",
            Self::Refuse => "refuse",
        })
    }
}

/// Finish on the last piece.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Ending {
    /// The torque ends at the threshold.
    Threshold,
    /// The torque ends where the wheel rolls out to the end.
    RollOut,
}

impl Settable for Ending {
    const WORDS: &'static [&'static str] = &["threshold", "roll-out"];

    fn shown(self) -> Shown {
        Shown::Word(match self {
            Self::Threshold => "threshold",
            Self::RollOut => "roll-out",
        })
    }
}

impl Policy {
    /// The word of a file.
    pub(crate) fn word(self) -> &'static str {
        match self {
            Self::Both => "both",
            Self::HoldLeft => "hold-left",
            Self::Mirror => "mirror",
        }
    }

    /// Whether pivots of `policy` are driven.
    pub(crate) fn has(self, policy: WheelPolicy) -> bool {
        matches!((self, policy), (Self::Both, _) | (Self::HoldLeft, WheelPolicy::HoldLeft) | (Self::Mirror, WheelPolicy::Mirror))
    }
}

impl From<Locate> for Nearest {
    fn from(locate: Locate) -> Self {
        match locate {
            Locate::Waypoint => Self::Waypoint,
            Locate::Projection => Self::Projection,
        }
    }
}

impl From<Outside> for OutsidePolicy {
    fn from(outside: Outside) -> Self {
        match outside {
            Outside::Clamp => Self::Clamp,
            Outside::Refuse => Self::Refuse,
        }
    }
}
