//! The verdict: does a map work, in closed loop, on the vehicle that it was made for?
//!
//! In: [`Maps`], the `table2.csv` that will be deployed with the JSON files that belong to it, and [`VerifySettings`]. Out: [`MapVerdict`]. Pivots are
//! driven by the bundled controller on the plant that Table 1 identified, as it is and perturbed (Monte Carlo); failures are provoked; every
//! measured cell makes the round trip Table 1 → Table 2 → Table 1; and other laws drive beside the map. A gate of documented limits decides.
//! Metrics, traces and logs observe the same runs ([`verify_with`]).

mod bench;
mod comparison;
pub(crate) mod drive;
mod error;
mod exact_map;
mod gate;
mod judge;
mod laws;
mod maps;
mod measured_region;
mod metric;
mod notes;
pub(crate) mod perturbations;
mod pivot_driver;
mod pivot_log;
mod pivot_traces;
mod reference_maps;
mod replayed;
mod round_trip;
mod run;
mod run_metrics;
mod scenario;
mod settings;
mod stage;
pub(crate) mod vehicle_log;
mod verdict;

pub use bench::PivotMoment;
pub use error::{Error, Result};
pub use exact_map::ExactMap;
pub use gate::{Gate, Limit, LimitCheck};
pub use judge::{Verified, replay, verify, verify_with};
pub use maps::{AngleMap, Maps};
pub use measured_region::Region;
pub use metric::{Metric, MetricSummary, Statistic, Values};
pub use perturbations::Spread;
pub use pivot_traces::{Bands, ClosedLoop, LawTraces};
pub use reference_maps::known_maps;
pub use replayed::{ReplayedRun, replayed};
pub use round_trip::{RoundTripLimit, RoundTripVerdict, Worst, round_trip};
pub use scenario::{Class, Disturbance, Expected, Onset, Scenario};
pub use settings::{RunLog, VerifySettings, Wanted};
pub use verdict::{ConventionalGains, FORMAT, LawComparison, LawSummary, MapVerdict, PlantSummary, ScenarioVerdict, Status};
