//! From surveyed logs to Table 1.
//!
//! In: [`Survey`](crate::campaign::Survey)s of the logs of one vehicle. Out: a [`Fit`]: `table1.json` and its CSVs, and the final verdict on
//! every sample. The method is a prediction-error identification: the speed is integrated, never differentiated; what is random is
//! whitened by a Kalman filter; the surface a(v, τ) is a penalised lattice whose smoothness the data choose; dead time and lag are
//! estimated with it. A drive that a lag does not explain is followed by its torque feedback instead.

mod actuator;
mod angle_groups;
mod anova;
mod coarse;
mod convergence;
mod course;
mod delay_likelihood;
mod error;
mod estimate;
mod family;
mod feedback;
mod gram;
mod hyper;
mod input;
mod kalman;
mod known;
mod lattice;
mod measured;
mod merging;
mod monotone;
mod part;
mod passes;
mod penalised;
mod plan;
mod product;
mod regressors;
mod robust;
mod runs;
mod sampling;
mod search;
mod segment;
mod settings;
mod soundness;
mod speeds;
mod spline;
mod stacked;
mod start;
mod steady;
mod step_timing;
mod stop;
mod stribeck;
mod tables;
mod torque;
mod traces;
mod uncertainty;
mod validation;

pub use angle_groups::fit_angles;
pub use error::{Error, Result};
pub use known::KnownCalibration;
pub use plan::{ExpectedCell, Plan, PlanEntry, PlanSettings, PlannedRun, expected, plan};
pub use product::{Fit, fit, fit_traced};
pub use settings::Settings;
