//! Columns after those of the surface: shared ones, then one dead time per log.

use crate::fit::drive_form::campaign_drift::SPANS;
use crate::fit::drive_form::parameters::PARAMETERS;

/// The first parameter of the drive; the others follow.
pub(crate) const DRIVE: usize = 0;
/// Relative change of the encoder's scale.
pub(crate) const ENCODER_SCALE: usize = DRIVE + PARAMETERS;
/// Change of the encoder's delay [s].
pub(crate) const ENCODER_DELAY: usize = ENCODER_SCALE + 1;
/// Relative changes of friction over half of the campaign, and of each log.
pub(crate) const DRIFT_FRICTION: usize = ENCODER_DELAY + 1;
/// Relative changes of the torque over half of the campaign, and of each log.
pub(crate) const DRIFT_TORQUE: usize = DRIFT_FRICTION + SPANS;
/// T_d of the first log.
pub(crate) const DEAD_TIME: usize = DRIFT_TORQUE + SPANS;
