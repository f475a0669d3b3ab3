//! The runs: segments of readings, the integral of the surface along them, whitened residuals and regressors, and the noise's likelihood.

pub(crate) mod coarse_readings;
pub(crate) mod expected_stop;
pub(crate) mod integration;
pub(crate) mod log_data;
pub(crate) mod lookup_speeds;
pub(crate) mod merging;
pub(crate) mod noise_likelihood;
pub(crate) mod passes;
pub(crate) mod regressors;
pub(crate) mod segment;
pub(crate) mod segmentation;
pub(crate) mod so_far;
