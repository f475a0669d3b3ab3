//! Time series on one clock.
//!
//! In: the signals of one log in SI ([`crate::log::Recording`]). Out: a [`Track`] with resolved signs, without repeated values, and with
//! all times in seconds since the log's first sample.

mod agreement;
mod align;
mod clock_check;
mod error;
mod held;
mod new_values;
mod noise;
mod publishers;
mod resolve;
mod response;
mod saturation;
mod series;
mod signs;
mod slope;
mod standstill;
mod stuck;
mod taken;
mod track;

pub(crate) use align::Alignment;
pub use error::Error;
pub(crate) use error::Result;
pub(crate) use new_values::new_values_only;
pub(crate) use noise::median;
pub(crate) use noise::median_of_few;
pub(crate) use noise::{hampel, noise_std, quantum};
pub(crate) use saturation::saturation;
pub use series::Series;
pub(crate) use slope::slope_through_origin;
pub(crate) use standstill::RestDetector;
pub use track::Track;
