//! Which torque acts on the wheel: the command through dead time and lag, or the torque feedback.

pub(crate) mod effective_torque;
pub(crate) mod feedback_delays;
pub(crate) mod feedback_scale;
pub(crate) mod lagged_command;
pub(crate) mod measured_torque;
pub(crate) mod sampled_torque;
pub(crate) mod settled_holds;
pub(crate) mod speed_limit;
pub(crate) mod step_timing;
pub(crate) mod torque_input;
pub(crate) mod undelivered;
