//! The forms that a drive can take between command and torque, its limits, and what changes while it is driven.

pub(crate) mod campaign_drift;
pub(crate) mod drift_posterior;
pub(crate) mod drive_model;
pub(crate) mod parameters;
pub(crate) mod torque;
pub(crate) mod torque_limit;
