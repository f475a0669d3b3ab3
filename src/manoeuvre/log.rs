//! A manoeuvre as a log of standard ROS 2 messages: pose as navigated and as true, commands, reference path and matched point.

use crate::guidance::path::PosePath;
use crate::guidance::route::follower::Stage;
use crate::manoeuvre::drive::Moment;
use crate::manoeuvre::judge::replay;
use crate::manoeuvre::scenario::Manoeuvre;
use crate::map::Vehicle;
use crate::record::{LogWriter, MessageStamp, Odometry, PathMessage, PointStamped, RosMessage};
use crate::verify::vehicle_log::{START_NS, log_time_ns, write_vehicle};
use crate::verify::{Maps, Result};

/// A log under construction.
pub(crate) struct Log {
    log: LogWriter,
    wheel_radius_m: f64,
    /// Whether the matched point is logged.
    points: bool,
    last_stage: Option<Stage>,
}

impl Log {
    pub(crate) fn new(vehicle: &Vehicle) -> Self {
        let mut log = LogWriter::new();
        let mut entries = vec![
            ("test_angle_deg", vehicle.test_angle_deg.to_string()),
            ("wheel_radius_m", vehicle.wheel_radius_m.to_string()),
            ("wheelbase_m", vehicle.wheelbase_m.to_string()),
        ];
        entries.extend(vehicle.torque_limit_nm.map(|limit| ("torque_limit_nm", limit.to_string())));
        log.metadata("pivot-cal/vehicle", entries);
        Self { log, wheel_radius_m: vehicle.wheel_radius_m, points: true, last_stage: None }
    }

    /// Leaves out the matched point.
    pub(crate) fn without_points(self) -> Self {
        Self { points: false, ..self }
    }

    pub(crate) fn metadata<'a>(&mut self, name: &str, entries: impl IntoIterator<Item = (&'a str, String)>) {
        self.log.metadata(name, entries);
    }

    /// The reference path, once, at the start.
    pub(crate) fn reference(&mut self, path: &PosePath) -> Result<()> {
        let poses: Vec<[f64; 3]> = path.poses.iter().map(|p| [p.x_m, p.y_m, p.heading_rad]).collect();
        let message = RosMessage::Path(PathMessage { stamp: MessageStamp { ns: START_NS }, frame_id: "odom", poses: &poses });
        Ok(self.log.write("/reference/path", START_NS, START_NS, &message)?)
    }

    pub(crate) fn write(&mut self, moment: &Moment) -> Result<()> {
        let (state, seen, command) = (&moment.state, &moment.seen, &moment.command);
        write_vehicle(&mut self.log, self.wheel_radius_m, state, seen, command.torque_nm, command.gear)?;
        let ns = log_time_ns(state.t_s);
        let stamp = MessageStamp { ns };
        let log = &mut self.log;
        let mut put = |topic: &str, message: &RosMessage<'_>| log.write(topic, ns, ns, message);
        let speed_mps = state.speed_mps * state.wheel_angle_rad.cos();
        for (topic, x_m, y_m, heading_rad) in
            [("/odom", seen.x_m, seen.y_m, seen.heading_rad), ("/ground_truth/odom", state.x_m, state.y_m, state.heading_rad)]
        {
            let (frame_id, child_frame_id, yaw_rate_rad_s) = ("odom", "base_link", seen.yaw_rate_rad_s);
            put(
                topic,
                &RosMessage::Odometry(Odometry { stamp, frame_id, child_frame_id, x_m, y_m, heading_rad, speed_mps, yaw_rate_rad_s }),
            )?;
        }
        put("/navigation/yaw", &RosMessage::Float64(seen.heading_rad))?;
        put("/manoeuvre/speed_actual", &RosMessage::Float64(state.speed_mps))?;
        put("/manoeuvre/speed_desired", &RosMessage::Float64(command.target_speed_mps))?;
        put("/manoeuvre/accel_desired", &RosMessage::Float64(command.accel_mps2))?;
        put("/manoeuvre/wheel_angle_desired", &RosMessage::Float64(command.wheel_angle_rad))?;
        put("/steering/compensation", &RosMessage::Float64(moment.compensation_rad))?;
        if let Some(matched) = &command.matched {
            if self.points {
                let point = PointStamped { stamp, frame_id: "odom", x_m: matched.x_m, y_m: matched.y_m };
                put("/reference/matched_point", &RosMessage::PointStamped(point))?;
            }
            put("/manoeuvre/lateral_error", &RosMessage::Float64(command.lateral_error_m))?;
        }
        if self.last_stage != Some(command.stage) {
            put("/manoeuvre/stage", &RosMessage::String(&format!("{:?}, leg {}", command.stage, moment.leg + 1)))?;
        }
        self.last_stage = Some(command.stage);
        Ok(())
    }

    pub(crate) fn finish(self) -> Result<Vec<u8>> {
        Ok(self.log.finish()?)
    }
}

/// The bytes of an MCAP file with the nominal run of `manoeuvre`.
///
/// # Errors
/// A vehicle that cannot be simulated, and what the MCAP writer refuses.
pub fn log_of(maps: &Maps, settings: &crate::verify::Settings, manoeuvre: &Manoeuvre) -> Result<Vec<u8>> {
    let mut log = Log::new(&settings.manoeuvre_vehicle.vehicle);
    log.metadata("pivot-cal/scenario", [("name", manoeuvre.name.clone()), ("what", manoeuvre.what.clone())]);
    log.reference(&manoeuvre.reference(settings.manoeuvre_vehicle.vehicle.wheelbase_m)?)?;
    let mut outcome = Ok(());
    replay(maps, settings, manoeuvre, |moment| {
        if outcome.is_ok() {
            outcome = log.write(moment);
        }
    })?;
    outcome?;
    log.finish()
}
