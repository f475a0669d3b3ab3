//! The verdict: does a map work, in closed loop, on the vehicle that it was made for?
//!
//! In: [`Maps`], the `table2.csv` that will be deployed with the JSON files that belong to it, and [`Settings`]. Out: [`Verdict`]. Pivots are
//! driven by the bundled controller on the plant that Table 1 identified, as it is and perturbed (Monte Carlo); failures are provoked; every
//! measured cell makes the round trip Table 1 → Table 2 → Table 1; and other laws drive beside the map. A gate of documented limits decides.

mod bench;
mod closed_loop;
mod error;
mod gate;
pub(crate) mod judge;
mod laws;
mod log;
mod maps;
mod measured_region;
pub(crate) mod metric;
pub(crate) mod perturbations;
mod plant;
mod reference_maps;
mod replayed;
mod round_trip;
mod run;
mod run_metrics;
pub(crate) mod scenario;
pub(crate) mod vehicle_log;
pub(crate) mod verdict;

pub use bench::Moment;
pub use closed_loop::{Bands, ClosedLoop, LawTraces, closed_loop};
pub use error::{Error, Result};
pub use gate::{Check, Gate, Limit};
pub use judge::{Settings, replay, verify, verify_watched};
pub use log::log_of;
pub use maps::{AngleMap, Maps};
pub use measured_region::Region;
pub use metric::{Metric, Statistic, Summary, Values};
pub use perturbations::Spread;
pub use plant::Plant;
pub use reference_maps::known_maps;
pub use replayed::{ReplayedRun, replayed};
pub use round_trip::{RoundTrip, RoundTripLimit, Worst, round_trip};
pub use scenario::{Class, Disturbance, Expected, Onset, Scenario};
pub use verdict::{Comparison, ConventionalGains, FORMAT, LawSummary, PlantSummary, ScenarioVerdict, Status, Verdict};
