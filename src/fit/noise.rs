//! The random part of the model: the disturbance, the offset of a run and the noise of the readings (`model`), the Kalman filter
//! (`kalman`), and whitening by its innovations (`whitening`).

pub(crate) mod kalman;
pub(crate) mod model;
pub(crate) mod quantisation;
#[cfg(test)]
pub(crate) mod simulated;
pub(crate) mod whitening;
