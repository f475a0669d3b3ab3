//! The adaptive U-turn: a straight run-up, then wheel in, hold, wheel out, so that the heading has turned by exactly 180°.
//!
//! In: a [`Car`], a [`Scene`] and a [`Turn`] (run-up, speed, wheel rate), or the ranges in which [`search`] looks for the turn with the largest
//! margin. Out: a [`Track`] of the point in the middle between the axles, its margins, and the [`crate::guidance::PosePath`] of the rear axle. Equations and
//! the published case: `docs/manoeuvres.md`.

mod model;
mod published;
mod scene;
mod search;
mod track;

pub use model::{Car, Method, Segment, State, integrate};
pub use published::{
    ANSWERS, Answer, Finding, Hypothesis, INFERRED_BODY, INFERRED_HYPOTHESIS, PublishedCase, YAW_RATE_RAD_S, entry_speed_mps,
};
pub use scene::{Lane, Margins, Scene};
pub use search::{Found, Ranges, search};
pub use track::{Settings, Track, Turn, drive, largest_difference_m};
