//! From the signals of a log to its runs, with a verdict on every sample.
//!
//! In: a [`Track`](crate::signal::Track). Out: a [`Survey`]: one [`Verdict`] per speed sample, the [`Stretch`]es of motion that a fit may
//! use, and the [`Hold`]s, the stretches of constant command that people call runs. What only a model can tell (a push by hand) is added
//! by the fit. A [`Census`] tells the wheel angles of the runs, and an [`AngleGroup`] holds the surveys of the runs at one of them.

mod angles;
mod by_angle;
mod error;
mod gates;
mod hold;
mod ledger;
mod runs;
mod settings;
mod slip;
mod survey;

pub use crate::map::SampleVerdict;
pub use angles::{Census, HeldAngle};
pub use by_angle::{AngleGroup, Grouped, group_by_angle};
pub use error::{Error, Result};
pub use hold::Hold;
pub use ledger::{ledger, sample_seconds};
pub use runs::runs;
pub use settings::SurveySettings;
pub use survey::{StartTrial, Stretch, Survey};
