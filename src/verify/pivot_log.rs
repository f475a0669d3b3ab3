//! A scenario's nominal run as a log of standard ROS 2 messages, which Foxglove, `PlotJuggler` and rerun draw: what the vehicle did, what was
//! desired, and the messages between the controller's modules.

use crate::control::{AngleStatus, DriveLaw, LateralTask, Phase, PivotRequest};
use crate::map::Gear;
use crate::record::{LogWriter, MessageStamp, Odometry, RosMessage};
use crate::units::RAD_PER_DEG;
use crate::verify::bench::PivotMoment;
use crate::verify::drive::{Observer, Period};
use crate::verify::pivot_driver::PivotDriver;
use crate::verify::scenario::Scenario;
use crate::verify::vehicle_log::{log_time_ns, write_vehicle};
use crate::verify::{Maps, Result};
use std::fmt::Write as _;

/// A log under construction: observes a run.
pub(crate) struct PivotLog {
    log: LogWriter,
    wheel_radius_m: f64,
    last: (Option<Phase>, Option<LateralTask>),
    /// The first message that could not be written ends the log.
    outcome: crate::record::Result<()>,
}

impl PivotLog {
    /// An empty log of `scenario`.
    pub(crate) fn new(maps: &Maps, scenario: &Scenario) -> Self {
        let mut log = LogWriter::new();
        log.metadata("pivot-cal/scenario", [("name", scenario.name.clone()), ("what", scenario.what.clone())]);
        Self { log, wheel_radius_m: maps.table2.vehicle.wheel_radius_m, last: (None, None), outcome: Ok(()) }
    }

    /// The bytes of the MCAP file.
    ///
    /// # Errors
    /// What the MCAP writer refuses.
    pub(crate) fn finish(self) -> Result<Vec<u8>> {
        self.outcome?;
        Ok(self.log.finish()?)
    }
}

impl<'a, L: DriveLaw> Observer<PivotDriver<'a, L>> for PivotLog {
    fn see(&mut self, period: &Period<'_, PivotDriver<'a, L>>) {
        let moment = period.moment;
        if self.outcome.is_ok() {
            self.outcome = write(&mut self.log, self.wheel_radius_m, moment, period.driver.request(), self.last);
        }
        self.last = (Some(moment.command.phase), Some(moment.command.task));
    }

    fn reads_yaw_rate(&self) -> bool {
        true
    }
}

fn write(
    log: &mut LogWriter,
    wheel_radius_m: f64,
    moment: &PivotMoment,
    request: Option<&PivotRequest>,
    (last_phase, last_task): (Option<Phase>, Option<LateralTask>),
) -> crate::record::Result<()> {
    let (state, seen, command) = (&moment.state, &moment.seen, &moment.command);
    write_vehicle(log, wheel_radius_m, state, seen, command.torque_nm, command.gear)?;
    let ns = log_time_ns(state.t_s);
    let stamp = MessageStamp { ns };
    let mut put = |topic: &str, message: &RosMessage<'_>| log.write(topic, ns, ns, message);
    put(
        "/odom",
        &RosMessage::Odometry(Odometry {
            stamp,
            frame_id: "odom",
            child_frame_id: "base_link",
            x_m: state.x_m,
            y_m: state.y_m,
            heading_rad: state.heading_rad,
            speed_mps: state.speed_mps * state.wheel_angle_rad.cos(),
            yaw_rate_rad_s: seen.yaw_rate_rad_s,
        }),
    )?;
    put("/pivot/speed_actual", &RosMessage::Float64(state.speed_mps))?;
    put("/pivot/accel_actual", &RosMessage::Float64(state.accel_mps2))?;
    put("/pivot/wheel_angle_desired", &RosMessage::Float64(command.wheel_angle_rad))?;
    if let Some(drive) = &command.drive {
        let sign = command.gear.map_or(1.0, Gear::sign);
        put("/pivot/speed_desired", &RosMessage::Float64(sign * drive.target_speed_mps))?;
        put("/pivot/accel_desired", &RosMessage::Float64(sign * drive.accel_mps2))?;
        put("/pivot/arc", &RosMessage::Float64(drive.arc_m))?;
    }
    put("/pivot/restore", &RosMessage::Bool(command.restore))?;
    put("/pivot/angle_status", &RosMessage::String(&angle_name(command.angle)))?;
    if last_task != Some(command.task) {
        put("/pivot/task", &RosMessage::String(&task_name(command.task)))?;
    }
    if last_phase != Some(command.phase) {
        put("/pivot/phase", &RosMessage::String(&format!("{:?}", command.phase)))?;
        if let Some(request) = request.filter(|_| command.phase == Phase::WaitingForAngle) {
            put("/pivot/pivot_flag", &RosMessage::Bool(request.pivot))?;
            put("/pivot/direction_flag", &RosMessage::Int8(request.direction.flag().cast_signed()))?;
            put("/pivot/waypoints", &RosMessage::String(&waypoints(request)))?;
        }
    }
    Ok(())
}

fn task_name(task: LateralTask) -> String {
    match task {
        LateralTask::Rest => "rest".to_owned(),
        LateralTask::Hold(angle_rad) => format!("hold {:.2}°", angle_rad / RAD_PER_DEG),
        LateralTask::Restore => "restore".to_owned(),
        LateralTask::Freeze => "freeze".to_owned(),
    }
}

fn angle_name(angle: AngleStatus) -> String {
    match angle {
        AngleStatus::InProgress => "in progress".to_owned(),
        AngleStatus::Reached => "reached".to_owned(),
        AngleStatus::Fault(fault) => format!("fault: {fault:?}"),
    }
}

/// The waypoints as CSV: x [m], y [m], speed [m/s].
fn waypoints(request: &PivotRequest) -> String {
    request.path.waypoints().iter().fold("x_m,y_m,speed_mps\n".to_owned(), |mut text, p| {
        let _ = writeln!(text, "{:.4},{:.4},{:.4}", p.x_m, p.y_m, p.speed_mps);
        text
    })
}
