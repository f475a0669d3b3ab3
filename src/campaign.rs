//! From the signals of a log to its runs, with a verdict on every sample.
//!
//! In: a [`Track`](crate::signal::Track). Out: a [`Survey`]: one [`Verdict`] per speed sample, the [`Stretch`]es of motion that a fit may
//! use, and the [`Hold`]s, the stretches of constant command that people call runs. What only a model can tell (a push by hand) is added
//! by the fit.

mod error;
mod gates;
mod hold;
mod ledger;
mod runs;
mod settings;
mod slip;
mod survey;
mod verdict;

pub use error::{Error, Result};
pub use hold::Hold;
pub use ledger::{ledger, sample_seconds};
pub use runs::runs;
pub use settings::Settings;
pub use survey::{StartTrial, Stretch, Survey};
pub use verdict::Verdict;
