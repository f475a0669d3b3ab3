//! What is random: the disturbance, the offset of a run and the noise of the readings, and the Kalman filter that whitens them.

pub(crate) mod kalman;
