//! Why a manoeuvre cannot be driven. A badly driven manoeuvre is a verdict, not an error.

use crate::{control, guidance, map, record, sim, verify};

/// Result of this module.
pub(crate) type Result<T> = std::result::Result<T, Error>;

/// Why a manoeuvre cannot be driven.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
#[allow(missing_docs)] // the message explains the fields
pub enum Error {
    #[error("the polyline cannot be planned: {0}")]
    Polyline(#[from] guidance::route::polyline::PolylineError),
    #[error("the manoeuvre cannot be planned: {0}")]
    Planning(#[from] guidance::Error),
    #[error("the scene has neither a slot nor a field to plan in")]
    NothingToPlan,
    #[error("the plant cannot be simulated: {0}")]
    Sim(#[from] sim::Error),
    #[error("the controller cannot be set up: {0}")]
    Control(#[from] control::Error),
    #[error(transparent)]
    Map(#[from] map::Error),
    #[error("the log of a run cannot be written: {0}")]
    Record(#[from] record::Error),
    #[error(transparent)]
    Verify(#[from] verify::Error),
}
