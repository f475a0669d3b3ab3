//! The verdict: does a map work in closed loop on the vehicle that it was made for?
//!
//! In: [`Maps`], the `table2.csv` that will be deployed with the JSON files that belong to it, and [`VerifySettings`]. Out: [`MapVerdict`]. Pivots are
//! driven by the bundled controller on the plant that Table 1 identified, nominal and perturbed (Monte Carlo). Failures are provoked. Every
//! measured cell makes the round trip Table 1 → Table 2 → Table 1. Other laws are compared with the map. A gate of documented limits
//! decides. Metrics, traces and logs observe the same runs.

mod basis;
pub(crate) mod bench;
mod comparison;
mod conclusion;
mod controller_command;
mod controller_library;
mod controller_process;
mod controller_protocol;
mod controller_under_test;
pub(crate) mod deployment;
pub(crate) mod drive;
mod earlier;
mod error;
mod exact_map;
mod gate;
pub(crate) mod judge;
mod laws;
mod maps;
mod measured_region;
pub(crate) mod metric;
mod notes;
mod other_angles;
pub(crate) mod perturbations;
mod pivot_driver;
mod pivot_law;
mod pivot_log;
mod pivot_traces;
mod pivots_check;
mod recorded_pivots;
pub(crate) mod reference_maps;
mod replay_check;
mod replayed;
mod round_trip;
mod run;
mod run_metrics;
mod scenario;
pub(crate) mod settings;
mod stage;
pub(crate) mod vehicle_log;
mod verdict;

pub use controller_command::ControllerCommand;
pub use error::Error;
pub(crate) use error::Result;
pub use gate::{Gate, Limit, LimitCheck};
pub use judge::verify;
pub(crate) use judge::{Verified, judge_pivots, verify_with};
pub use maps::Maps;
pub(crate) use metric::Values;
pub use metric::{Metric, MetricSummary, Statistic};
pub(crate) use other_angles::at_angles;
pub use perturbations::Spread;
pub(crate) use pivot_traces::ClosedLoop;
pub(crate) use pivot_traces::{Bands, LawTraces};
pub use recorded_pivots::RecordedPivots;
pub(crate) use recorded_pivots::recorded_pivots;
pub use replayed::ReplayedRun;
pub(crate) use replayed::replayed;
pub use round_trip::{RoundTripLimit, RoundTripVerdict, Worst};
pub use scenario::{Class, Scenario};
pub use settings::VerifySettings;
pub(crate) use settings::{RunLog, Wanted};
pub use verdict::{ConventionalGains, LawComparison, LawSummary, MapVerdict, PlantSummary, ScenarioVerdict, Status};
