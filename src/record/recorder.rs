//! Drives a campaign on a simulated vehicle and records its log.

use crate::campaign::driving::CYCLE_S;
use crate::record::campaign::Campaign;
use crate::record::error::{Error, Result};
use crate::record::runner::{RunOutcome, Runner};
use crate::record::topics::Topics;
use crate::sim::{Fault, VehicleFile, World};
use crate::units::RAD_PER_DEG;
use serde::{Deserialize, Serialize};

/// Longest campaign [s].
const LIMIT_S: f64 = 4.0 * 3600.0;
/// A floor is less steep than this [°].
const STEEPEST_DEG: f64 = 45.0;

/// A log and its report.
#[derive(Debug, Clone, PartialEq)]
pub struct DrivenLog {
    /// The MCAP file.
    pub bytes: Vec<u8>,
    /// The report.
    pub report: RecordReport,
}

/// Report of a campaign.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RecordReport {
    /// The campaign's name.
    pub campaign: String,
    /// Seed.
    pub seed: u64,
    /// Length of the log [s].
    pub duration_s: f64,
    /// Number of messages.
    pub messages: usize,
    /// The runs in driving order.
    pub runs: Vec<RunOutcome>,
}

/// Drives `campaign` on `vehicle` and records its sensor readings. `seed` overrides the campaign's seed.
///
/// # Errors
/// A setting is out of its range, a wheel angle is beyond the steering limit, or the campaign is too long.
pub fn record(vehicle: &VehicleFile, campaign: &Campaign, seed: Option<u64>) -> Result<DrivenLog> {
    let seed = seed.unwrap_or(campaign.seed);
    let plan = campaign.plan(seed)?;
    let limit_deg = vehicle.steering.limit_deg;
    let beyond = plan.iter().find_map(|run| Some((run.group + 1, run.wheel_angle_deg.filter(|angle| angle.abs() > limit_deg)?)));
    if let Some((group, wheel_angle_deg)) = beyond {
        return Err(Error::BeyondSteering { group, wheel_angle_deg, limit_deg });
    }
    let mut world = World::new(&vehicle.settings(), seed)?;
    if !campaign.slope_deg.is_finite() || campaign.slope_deg.abs() >= STEEPEST_DEG {
        return Err(Error::Slope { slope_deg: campaign.slope_deg });
    }
    if campaign.slope_deg != 0.0 {
        world.inject(Fault::Slope { grade_rad: campaign.slope_deg * RAD_PER_DEG, uphill_heading_rad: 0.0 });
    }
    let mut runner = Runner::new(plan, &vehicle.vehicle, seed);
    let mut topics = Topics::new(&campaign.topics, &vehicle.vehicle, campaign.start_ns()?, seed)?;
    let steps_per_cycle = (CYCLE_S / vehicle.step_s).round().max(1.0) as u64;
    while let Some(command) = runner.decide(&mut world) {
        for _ in 0..steps_per_cycle {
            topics.write_command(&world, &command)?;
            world.step(&command);
            topics.write_sensors(&world)?;
        }
        if world.state().t_s > LIMIT_S {
            return Err(Error::TooLong { limit_s: LIMIT_S });
        }
    }
    let log = topics.into_log();
    let report = RecordReport {
        campaign: campaign.name.clone(),
        seed,
        duration_s: world.state().t_s,
        messages: log.len(),
        runs: runner.into_outcomes(),
    };
    Ok(DrivenLog { bytes: log.finish()?, report })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::campaign::driving::End;

    const VEHICLE: &str = "[vehicle]\nwheelbase_m = 0.9\nwheel_radius_m = 0.12\n";

    fn recorded(campaign: &str) -> DrivenLog {
        record(&VehicleFile::from_toml(VEHICLE).unwrap(), &Campaign::from_toml(campaign).unwrap(), None).unwrap()
    }

    #[test]
    fn every_run_ends_for_the_reason_given_by_its_torque() {
        let runs = recorded(
            "[[runs]]\ntorque_nm = [4, 12, 36]\nhold_s = 1.6\n[[runs]]\ntorque_nm = -20\nstart_speed_mps = 0.6\n\
             [[runs]]\ntorque_nm = 30\ngear = \"reverse\"\nevent = { kind = \"emergency_stop\", at_s = 0.3 }\n",
        )
        .report
        .runs;
        let ends: Vec<End> = runs.iter().map(|run| run.end).collect();
        assert_eq!(ends, [End::Stalled, End::TimeUp, End::SpeedLimit, End::Slowed, End::EmergencyStop]);
        assert!(runs[3].start_speed_mps > 0.55 && runs[3].end_speed_mps < 0.03, "{:?}", runs[3]);
    }

    #[test]
    fn the_log_holds_the_topics_with_their_types_and_the_vehicle() {
        let bytes = recorded("[[runs]]\ntorque_nm = 20\nhold_s = 0.5\n").bytes;
        let summary = mcap::Summary::read(&bytes).unwrap().unwrap();
        let mut topics: Vec<_> = summary.channels.values().map(|c| (c.topic.clone(), c.schema.as_ref().unwrap().name.clone())).collect();
        topics.sort();
        let expected = [
            ("/drive/gear", "std_msgs/msg/Int8"),
            ("/drive/torque_command", "std_msgs/msg/Float64"),
            ("/drive/torque_feedback", "std_msgs/msg/Float64"),
            ("/eps/joint_states", "sensor_msgs/msg/JointState"),
            ("/imu/twist", "geometry_msgs/msg/TwistStamped"),
            ("/joint_states", "sensor_msgs/msg/JointState"),
            ("/odom", "nav_msgs/msg/Odometry"),
            ("/safety/estop", "std_msgs/msg/Bool"),
        ];
        assert_eq!(topics, expected.map(|(topic, name)| (topic.to_owned(), name.to_owned())));
        let index = &summary.metadata_indexes[0];
        let vehicle = mcap::read::metadata(&bytes, index).unwrap();
        assert_eq!((index.name.as_str(), vehicle.metadata["wheelbase_m"].as_str()), ("pivot-cal/vehicle", "0.9"));
        assert_eq!(vehicle.metadata["test_angle_deg"], "90");
    }

    #[test]
    fn the_same_seed_gives_the_same_bytes_and_another_seed_gives_other_bytes() {
        let campaign = Campaign::from_toml("[[runs]]\ntorque_nm = 20\nhold_s = 0.5\n").unwrap();
        let vehicle = VehicleFile::from_toml(VEHICLE).unwrap();
        let bytes = |seed| record(&vehicle, &campaign, seed).unwrap().bytes;
        assert_eq!(bytes(None), bytes(Some(1)));
        assert_ne!(bytes(None), bytes(Some(2)));
    }

    #[test]
    fn an_angle_beyond_the_steering_limit_is_refused_with_the_limit() {
        let campaign = Campaign::from_toml("[[runs]]\ntorque_nm = 8\n[[runs]]\ntorque_nm = 8\nwheel_angle_deg = [30, -120]\n").unwrap();
        let error = record(&VehicleFile::from_toml(VEHICLE).unwrap(), &campaign, None).unwrap_err().to_string();
        assert_eq!(error, "runs entry 2: wheel_angle_deg is -120; the vehicle steers up to 100° in both directions");
    }

    #[test]
    fn a_slope_is_driven_on_and_one_that_is_no_floor_is_refused() {
        let levelled = recorded("[[runs]]\ntorque_nm = 20\nhold_s = 1.0\n").report.runs[0].end_speed_mps;
        let uphill = recorded("slope_deg = 15\n[[runs]]\ntorque_nm = 20\nhold_s = 1.0\n").report.runs[0].end_speed_mps;
        assert!((levelled - uphill).abs() > 0.05, "{levelled} on the level, {uphill} on the slope");
        let vehicle = VehicleFile::from_toml(VEHICLE).unwrap();
        let steep = Campaign::from_toml("slope_deg = 60\n[[runs]]\ntorque_nm = 20\n").unwrap();
        assert_eq!(record(&vehicle, &steep, None).unwrap_err().to_string(), "slope_deg is 60; allowed: above -45 and below 45");
    }

    #[test]
    fn slip_appears_as_a_difference_of_encoder_and_gyro() {
        let campaign = "[[runs]]\ntorque_nm = 30\nhold_s = 1.5\nspeed_limit_mps = 5.0\n\
                        event = { kind = \"wet_patch\", at_s = 0.4, duration_s = 0.4, grip_nm = 10 }\n";
        let bytes = recorded(campaign).bytes;
        let last_f64 = |data: &[u8], from_end: usize| f64::from_le_bytes(data[data.len() - from_end..][..8].try_into().unwrap());
        let (mut encoder, mut apart) = (0.0, 0.0_f64);
        for message in mcap::MessageStream::new(&bytes).unwrap().map(|m| m.unwrap()) {
            match message.channel.topic.as_str() {
                // velocity[0] precedes velocity[1] and the length of the empty efforts
                "/joint_states" => encoder = last_f64(&message.data, 20) * 0.12,
                "/imu/twist" => apart = apart.max(encoder - 0.9 * last_f64(&message.data, 8)),
                _ => {}
            }
        }
        assert!(apart > 0.5, "largest difference of encoder and gyro {apart} m/s");
    }
}
