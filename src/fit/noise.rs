//! What is random: the disturbance, the offset of a run and the noise of the readings (`model`), the Kalman filter (`kalman`), and whitening
//! by its innovations (`whitening`).

pub(crate) mod kalman;
pub(crate) mod model;
#[cfg(test)]
pub(crate) mod simulated;
pub(crate) mod whitening;
