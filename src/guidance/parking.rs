//! Perpendicular and slanted parking, in reverse: start and adjust on a line beside the row, enter on a circle, shuffle until straight.
//!
//! Frame: x along the row in the direction of travel, y away from it; the row's edge is y = 0, and the middle of the slot's mouth is the origin.
//! The vehicle drives along the row with the slot to its right, passes it and backs in. In: a [`ParkingScene`] and a start; out: a
//! [`ParkingPlan`]. Stages and equations: `docs/manoeuvres.md`.

mod check;
mod entry;
mod method;
mod parked_path;
mod plan;
mod scene;
mod shuffle;
mod stage;
pub(crate) mod start;
#[cfg(test)]
mod success;
mod tight;
mod tolerance;

pub(crate) use crate::guidance::parking::start::ParkingStart;
pub(crate) use method::ParkingMethod;
pub(crate) use plan::plan;
pub(crate) use scene::{ParkingScene, Slot};
pub(crate) use tolerance::Tolerance;
