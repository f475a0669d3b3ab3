//! The torques that a drive delivers, by speed.

/// The torques that a drive delivers: within the vehicle's limit in both directions and, while driving, the drive's limit where it is
/// lower.
pub(crate) struct DeliveredTorque<'a> {
    /// Least torque [N·m].
    pub(crate) least_nm: f64,
    /// Largest torque [N·m] at a speed [m/s].
    pub(crate) most_nm: &'a dyn Fn(f64) -> f64,
    /// Whether a limit of the speed leaves no driving torque at a speed [m/s]. The nodes there keep the torque of the map, so that the table
    /// does not fall off before it.
    pub(crate) is_governed: &'a dyn Fn(f64) -> bool,
    /// Largest torque of a node in either direction [N·m]. Nodes beyond the reach may have more than is delivered, so that the table is right
    /// between them and the reach.
    pub(crate) node_limit_nm: f64,
}

impl DeliveredTorque<'_> {
    /// The torques within which a speed [m/s] can be accelerated [N·m].
    pub(crate) fn reach_nm(&self, speed_mps: f64) -> [f64; 2] {
        [self.least_nm, if (self.is_governed)(speed_mps) { 0.0 } else { (self.most_nm)(speed_mps) }]
    }

    /// The delivered part of a torque [N·m] at a speed [m/s].
    pub(crate) fn clamp(&self, speed_mps: f64, torque_nm: f64) -> f64 {
        torque_nm.min((self.most_nm)(speed_mps)).max(self.least_nm)
    }
}
