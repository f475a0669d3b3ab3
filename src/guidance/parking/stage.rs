//! The stages of a parking path.

use serde::Serialize;

/// A stage of parking.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum ParkingStage {
    /// Forward along the first line, past the slot.
    Start,
    /// Back along the first line to the entry circle, until the vehicle is aligned with the line.
    Adjust,
    /// Along the circle and the slot's axis: in reverse, or nose in.
    Enter,
    /// A move out or in along the slot's axis, within the room that there is.
    Shuffle,
}

/// Start of a stage.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub(crate) struct StageSpan {
    /// The stage.
    pub stage: ParkingStage,
    /// Index of its first pose.
    pub from: usize,
}
