//! The inputs of a manoeuvre's run.

use crate::controller::ControllerSettings;
use crate::guidance::route::response::VehicleResponse;
use crate::manoeuvre::Result;
use crate::manoeuvre::planned_task::Planned;
use crate::manoeuvre::torque::ManoeuvreTorque;
use crate::sim;
use crate::units::RAD_PER_DEG;
use crate::verify::Maps;

/// The inputs of a manoeuvre's run.
#[derive(Debug, Clone)]
pub(crate) struct ManoeuvreBench<'a> {
    /// The map, with the compensation table if the folder has one.
    pub(crate) maps: &'a Maps,
    /// Torque for speed, acceleration and angle.
    pub(crate) torque: ManoeuvreTorque<'a>,
    /// How fast the vehicle answers: the drive by the map, the steering by the vehicle's file.
    pub(crate) vehicle: VehicleResponse,
    /// Settings of the controller.
    pub(crate) controller: &'a ControllerSettings,
    /// The plan of a planned task, made once for all of its runs.
    pub(crate) planned: Option<&'a Planned>,
}

impl<'a> ManoeuvreBench<'a> {
    /// The inputs for a map and a physical vehicle, without a plan.
    ///
    /// # Errors
    /// A vehicle that cannot be simulated.
    pub(crate) fn new(maps: &'a Maps, vehicle: &sim::WorldSettings, controller: &'a ControllerSettings) -> Result<Self> {
        let torque = ManoeuvreTorque::new(Some(maps), vehicle)?;
        let response = VehicleResponse { dead_time_s: maps.table2.dead_time_s, lag_s: maps.table2.lag_s, ..response_of(vehicle) };
        Ok(Self { maps, torque, vehicle: response, controller, planned: None })
    }
}

/// How fast a simulated vehicle answers.
pub(crate) fn response_of(world: &sim::WorldSettings) -> VehicleResponse {
    VehicleResponse {
        wheelbase_m: world.vehicle.wheelbase_m,
        dead_time_s: world.drive.dead_time_s,
        lag_s: world.drive.lag_s,
        steering_rate_rad_s: world.steering.rate_deg_s * RAD_PER_DEG,
        steering_lag_s: world.steering.lag_s,
    }
}
