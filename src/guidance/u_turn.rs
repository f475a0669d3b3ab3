//! The adaptive U-turn: a straight run-up, then wheel in, hold, wheel out, so that the heading has turned by exactly 180°.
//!
//! In: a [`Car`], a [`UTurnScene`] and a [`UTurnShape`] (run-up, speed, wheel rate), or the ranges in which [`search`] finds the turn with
//! the largest margin. Out: a [`UTurnTrack`] of the point in the middle between the axles, its margins, and the
//! `PosePath` of the rear axle. Equations and the published case: `docs/manoeuvres.md`.

mod model;
mod scene;
mod search;
mod track;

pub use model::{Car, Method};
pub use scene::{Lane, UTurnScene, beyond_m};
pub use search::{Ranges, search};
pub use track::{UTurnSettings, UTurnShape, UTurnTrack, drive, largest_difference_m};
