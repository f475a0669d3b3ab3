//! What every log of `verify --log` holds of the vehicle: its joints, what it was commanded, its emergency stop.

use crate::map::Gear;
use crate::record::{JointState, LogWriter, MessageStamp, Result, RosMessage};
use crate::sim::{Measurement, TrueState};
use crate::units::NS_PER_S;

/// Time of the first message [ns since 1970]: 2026-01-01 UTC, so that the same run gives the same bytes.
pub(crate) const START_NS: u64 = 1_767_225_600_000_000_000;

/// The log's time of a simulated one.
pub(crate) fn log_time_ns(t_s: f64) -> u64 {
    START_NS + (t_s * NS_PER_S).round() as u64
}

/// One control period of the vehicle, as it was read, with the torque and the gear that were commanded.
pub(crate) fn write_vehicle(
    log: &mut LogWriter,
    wheel_radius_m: f64,
    state: &TrueState,
    seen: &Measurement,
    torque_nm: f64,
    gear: Option<Gear>,
) -> Result<()> {
    let ns = log_time_ns(state.t_s);
    let mut put = |topic: &str, message: &RosMessage<'_>| log.write(topic, ns, ns, message);
    put(
        "/joint_states",
        &RosMessage::JointState(JointState {
            stamp: MessageStamp { ns },
            frame_id: "base_link",
            names: &["front_steer_joint", "front_drive_joint"],
            positions: &[seen.wheel_angle_rad, f64::NAN],
            velocities: &[f64::NAN, seen.speed_mps.map_or(f64::NAN, |v| v / wheel_radius_m)],
            efforts: &[f64::NAN, state.torque_nm],
        }),
    )?;
    put("/drive/torque_command", &RosMessage::Float64(torque_nm))?;
    put("/drive/gear", &RosMessage::Int8(gear_number(gear)))?;
    put("/safety/estop", &RosMessage::Bool(seen.estop))
}

/// 0 neutral, 1 forward, 2 reverse.
fn gear_number(gear: Option<Gear>) -> i8 {
    match gear {
        None => 0,
        Some(Gear::Forward) => 1,
        Some(Gear::Reverse) => 2,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_rounded_to_the_nanosecond_and_gears_have_their_numbers() {
        assert_eq!(log_time_ns(0.02), START_NS + 20_000_000);
        assert_eq!(log_time_ns(0.1 + 0.2), START_NS + 300_000_000);
        assert_eq!([None, Some(Gear::Forward), Some(Gear::Reverse)].map(gear_number), [0, 1, 2]);
    }
}
