//! Several wheel angles from one campaign: a fit per angle with shared delays, and what the maps have in common.

pub(crate) mod angle_groups;
pub(crate) mod family;
pub(crate) mod shrink_together;
