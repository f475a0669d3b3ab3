//! Columns after those of the surface: shared ones, then one dead time per log.

/// T_c.
pub(crate) const LAG: usize = 0;
/// Relative change of the encoder's scale.
pub(crate) const ENCODER_SCALE: usize = 1;
/// Change of the encoder's delay [s].
pub(crate) const ENCODER_DELAY: usize = 2;
/// T_d of the first log.
pub(crate) const DEAD_TIME: usize = 3;
