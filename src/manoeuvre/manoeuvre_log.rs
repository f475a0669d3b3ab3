//! A manoeuvre as a log of standard ROS 2 messages: navigated and true pose, commands, reference path and matched point.

use crate::guidance::path::PosePath;
use crate::guidance::route::follower::DriveStage;
use crate::log::SCENARIO_METADATA;
use crate::manoeuvre::Result;
use crate::manoeuvre::drive::{ManoeuvreDriver, ManoeuvreMoment};
use crate::map::Vehicle;
use crate::record;
use crate::record::{LogWriter, MessageStamp, Odometry, PathMessage, PointStamped, RosMessage};
use crate::verify::drive::{Observer, Period};
use crate::verify::vehicle_log::{START_NS, log_time_ns, write_vehicle};

/// A log under construction: observes a drive.
pub(crate) struct ManoeuvreLog {
    log: LogWriter,
    wheel_radius_m: f64,
    /// Whether the matched point is logged.
    points: bool,
    last_stage: Option<DriveStage>,
    /// The first message that could not be written ends the log.
    outcome: record::Result<()>,
}

impl ManoeuvreLog {
    pub(crate) fn new(vehicle: &Vehicle) -> Self {
        let mut log = LogWriter::new();
        let mut entries = vec![
            ("test_angle_deg", vehicle.test_angle_deg.to_string()),
            ("wheel_radius_m", vehicle.wheel_radius_m.to_string()),
            ("wheelbase_m", vehicle.wheelbase_m.to_string()),
        ];
        entries.extend(vehicle.torque_limit_nm.map(|limit| ("torque_limit_nm", limit.to_string())));
        log.metadata("pivot-cal/vehicle", entries);
        Self { log, wheel_radius_m: vehicle.wheel_radius_m, points: true, last_stage: None, outcome: Ok(()) }
    }

    /// Skips the matched point.
    pub(crate) fn without_points(self) -> Self {
        Self { points: false, ..self }
    }

    /// The log of a manoeuvre, which begins with its name and its path.
    ///
    /// # Errors
    /// Any error of the MCAP writer.
    pub(crate) fn of_scenario(vehicle: &Vehicle, name: &str, what: &str, path: &PosePath) -> Result<Self> {
        let mut log = Self::new(vehicle);
        log.log.metadata(SCENARIO_METADATA, [("name", name.to_owned()), ("what", what.to_owned())]);
        log.reference(path)?;
        Ok(log)
    }

    /// The reference path, once, at the start.
    pub(crate) fn reference(&mut self, path: &PosePath) -> Result<()> {
        let poses: Vec<[f64; 3]> = path.poses.iter().map(|p| [p.x_m, p.y_m, p.heading_rad]).collect();
        let message = RosMessage::Path(PathMessage { stamp: MessageStamp { ns: START_NS }, frame_id: "odom", poses: &poses });
        Ok(self.log.write("/reference/path", START_NS, START_NS, &message)?)
    }

    fn write(&mut self, moment: &ManoeuvreMoment) -> record::Result<()> {
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

    /// The bytes of the MCAP file.
    ///
    /// # Errors
    /// Any error of the MCAP writer.
    pub(crate) fn finish(self) -> Result<Vec<u8>> {
        self.outcome?;
        Ok(self.log.finish()?)
    }
}

impl<'a> Observer<ManoeuvreDriver<'a>> for ManoeuvreLog {
    fn see(&mut self, period: &Period<'_, ManoeuvreDriver<'a>>) {
        if self.outcome.is_ok() {
            self.outcome = self.write(period.moment);
        }
    }

    fn reads_yaw_rate(&self) -> bool {
        true
    }
}
