//! Finds the runs in the signals of a log, with a verdict on every sample.
//!
//! In: a [`Track`](crate::signal::Track). Out: a [`Survey`]: one [`SampleVerdict`] per speed sample, the [`Stretch`]es of motion that a fit may
//! use, and the holds, the intervals of constant command, usually called runs. Verdicts that need a model (a push by hand) are added
//! by the fit. A `Census` lists the wheel angles of the runs. An [`AngleGroup`] holds the surveys of the runs at one of these angles.

mod angles;
mod by_angle;
pub(crate) mod driving;
mod error;
mod gates;
mod hold;
mod ledger;
mod runs;
mod settings;
mod slip;
mod survey;
mod survey_checks;

pub(crate) use crate::map::SampleVerdict;
pub(crate) use angles::{Census, HeldAngle};
pub use by_angle::{AngleGroup, Grouped, group_by_angle};
pub use error::Error;
pub(crate) use error::Result;
pub(crate) use hold::Hold;
pub(crate) use ledger::sample_seconds;
#[doc(hidden)]
#[doc(hidden)] // for the studies and tests
pub use ledger::{ledger, with_missing};
pub(crate) use runs::runs;
pub use settings::SurveySettings;
pub use survey::{Stretch, Survey};
