//! The adaptive U-turn: a straight run-up, then wheel in, hold, wheel out, so that the heading has turned by exactly 180°.
//!
//! In: a [`Car`], a [`UTurnScene`] and a [`UTurnShape`] (run-up, speed, wheel rate), or the ranges in which [`search`] looks for the turn with the largest
//! margin. Out: a [`UTurnTrack`] of the point in the middle between the axles, its margins, and the [`crate::guidance::PosePath`] of the rear axle. Equations and
//! the published case: `docs/manoeuvres.md`.

mod model;
mod published;
mod scene;
mod search;
mod track;

pub use model::{Car, Method, SteeringSegment, UTurnState, integrate};
pub use published::{
    ANSWERS, Answer, Hypothesis, INFERRED_BODY, INFERRED_HYPOTHESIS, PublishedCase, PublishedFinding, YAW_RATE_RAD_S, entry_speed_mps,
};
pub use scene::{Lane, Margins, UTurnScene};
pub use search::{FoundUTurn, Ranges, search};
pub use track::{UTurnSettings, UTurnShape, UTurnTrack, drive, largest_difference_m};
