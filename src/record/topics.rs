//! The topics of a recorded log and the content of their messages.
//!
//! Values are rounded to single precision, as on the buses of real drives.

use crate::map::Vehicle;
use crate::record::campaign::TopicSettings;
use crate::record::error::Result;
use crate::record::log_writer::LogWriter;
use crate::record::message::{JointState, MessageStamp, Odometry, RosMessage, TwistStamped};
use crate::sim::{Channel, Gear, SensorReading, Stream, World, WorldCommand};

/// Name of the metadata record of the vehicle.
pub(crate) const VEHICLE_METADATA: &str = "pivot-cal/vehicle";

const JOINTS: [&str; 2] = ["front_drive_joint", "front_steer_joint"];
const FRAME: &str = "base_link";

/// The topics of one log.
pub(crate) struct Topics {
    log: LogWriter,
    start_ns: u64,
    wheel_radius_m: f64,
    torque_command: Channel<f64>,
    /// The last command written, if only changes are.
    last_command_nm: Option<f64>,
    on_change: bool,
    gear: Channel<i8>,
    estop: Channel<bool>,
    odometry: Channel<()>,
}

impl Topics {
    pub(crate) fn new(settings: &TopicSettings, vehicle: &Vehicle, start_ns: u64, seed: u64) -> Result<Self> {
        let mut log = LogWriter::new();
        let mut entries = vec![
            ("test_angle_deg", vehicle.test_angle_deg.to_string()),
            ("wheel_radius_m", vehicle.wheel_radius_m.to_string()),
            ("wheelbase_m", vehicle.wheelbase_m.to_string()),
        ];
        entries.extend(vehicle.torque_limit_nm.map(|limit| ("torque_limit_nm", limit.to_string())));
        log.metadata(VEHICLE_METADATA, entries);
        Ok(Self {
            log,
            start_ns,
            wheel_radius_m: vehicle.wheel_radius_m,
            torque_command: Channel::new(&settings.torque_command, seed, Stream::CommandMessages, 0.0)?,
            last_command_nm: None,
            on_change: settings.torque_command_on_change,
            gear: Channel::new(&settings.gear, seed, Stream::GearMessages, 0)?,
            estop: Channel::new(&settings.estop, seed, Stream::EstopMessages, false)?,
            odometry: Channel::new(&settings.odometry, seed, Stream::OdometryMessages, ())?,
        })
    }

    /// Messages of the current command, before the next step of the world.
    pub(crate) fn write_command(&mut self, world: &World, command: &WorldCommand) -> Result<()> {
        let now_s = world.state().t_s;
        self.torque_command.poll(now_s, |_, _| world.accepted_torque_nm(command));
        if let Some(reading) = self.torque_command.taken().copied() {
            if !self.on_change || self.last_command_nm != Some(reading.value) {
                self.plain("/drive/torque_command", &reading, &RosMessage::Float64(single(reading.value)))?;
            }
            self.last_command_nm = Some(reading.value);
        }
        self.gear.poll(now_s, |_, _| match command.gear {
            None => 0,
            Some(Gear::Forward) => 1,
            Some(Gear::Reverse) => 2,
        });
        if let Some(reading) = self.gear.taken().copied() {
            self.plain("/drive/gear", &reading, &RosMessage::Int8(reading.value))?;
        }
        self.estop.poll(now_s, |_, _| world.measure().estop);
        if let Some(reading) = self.estop.taken().copied() {
            self.plain("/safety/estop", &reading, &RosMessage::Bool(reading.value))?;
        }
        Ok(())
    }

    /// Messages of the sensors with a reading in the last step.
    pub(crate) fn write_sensors(&mut self, world: &World) -> Result<()> {
        let sensors = world.sensors();
        if let Some(reading) = sensors.encoder().taken() {
            let stamp = self.stamp(reading);
            let message = RosMessage::JointState(JointState {
                stamp,
                frame_id: "",
                names: &JOINTS,
                positions: &[f64::NAN, sensors.steering_angle().latest(world.state().t_s)].map(single),
                velocities: &[reading.value / self.wheel_radius_m, f64::NAN].map(single),
                efforts: &[],
            });
            self.headed("/joint_states", reading, &message)?;
        }
        if let Some(reading) = sensors.steering_angle().taken() {
            let message = RosMessage::JointState(JointState {
                stamp: self.stamp(reading),
                frame_id: "",
                names: &JOINTS[1..],
                positions: &[single(reading.value)],
                velocities: &[],
                efforts: &[],
            });
            self.headed("/eps/joint_states", reading, &message)?;
        }
        if let Some(reading) = sensors.gyro().taken() {
            let message = RosMessage::TwistStamped(TwistStamped {
                stamp: self.stamp(reading),
                frame_id: FRAME,
                linear: [0.0; 3],
                angular: [0.0, 0.0, single(reading.value)],
            });
            self.headed("/imu/twist", reading, &message)?;
        }
        if let Some(reading) = sensors.torque_feedback().taken() {
            self.plain("/drive/torque_feedback", reading, &RosMessage::Float64(single(reading.value)))?;
        }
        self.odometry.poll(world.state().t_s, |_, _| ());
        if let Some(reading) = self.odometry.taken().copied() {
            let seen = world.measure();
            let speed_mps = seen.speed_mps.unwrap_or(0.0) * seen.wheel_angle_rad.cos();
            let message = RosMessage::Odometry(Odometry {
                stamp: self.stamp(&reading),
                frame_id: "odom",
                child_frame_id: FRAME,
                x_m: single(seen.x_m),
                y_m: single(seen.y_m),
                heading_rad: single(seen.heading_rad),
                speed_mps: single(speed_mps),
                yaw_rate_rad_s: single(seen.yaw_rate_rad_s),
            });
            self.headed("/odom", &reading, &message)?;
        }
        Ok(())
    }

    /// The writer with all messages.
    pub(crate) fn into_log(self) -> LogWriter {
        self.log
    }

    /// A message without a header: its stamp is the publish time.
    fn plain<T>(&mut self, topic: &str, reading: &SensorReading<T>, message: &RosMessage<'_>) -> Result<()> {
        let (log_ns, publish_ns) = (self.ns(reading.arrival_s), self.ns(reading.stamp_s));
        self.log.write(topic, log_ns, publish_ns, message)
    }

    /// A message with its own stamp.
    fn headed<T>(&mut self, topic: &str, reading: &SensorReading<T>, message: &RosMessage<'_>) -> Result<()> {
        let log_ns = self.ns(reading.arrival_s);
        self.log.write(topic, log_ns, log_ns, message)
    }

    fn stamp<T>(&self, reading: &SensorReading<T>) -> MessageStamp {
        MessageStamp { ns: self.ns(reading.stamp_s) }
    }

    fn ns(&self, t_s: f64) -> u64 {
        self.start_ns.saturating_add_signed((t_s * 1e9).round() as i64)
    }
}

/// The nearest single-precision number.
fn single(value: f64) -> f64 {
    f64::from(value as f32)
}
