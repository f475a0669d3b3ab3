//! From an estimate to `table1.json`: standard errors, tables, runs, objections and traces.

pub(crate) mod actuator;
pub(crate) mod angle_fit;
pub(crate) mod delay_likelihood;
pub(crate) mod diagnostics;
pub(crate) mod prediction_checks;
pub(crate) mod runs;
pub(crate) mod soundness;
pub(crate) mod standard_errors;
pub(crate) mod tables;
pub(crate) mod torque_gain;
pub(crate) mod traces;
