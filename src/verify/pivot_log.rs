//! A scenario's nominal run as a log of standard ROS 2 messages, which Foxglove, `PlotJuggler` and rerun draw: the actual and the desired
//! motion, and the messages between the controller's modules.

use crate::control::{AngleStatus, LateralTask, Phase, PivotRequest};
use crate::log::SCENARIO_METADATA;
use crate::map::Gear;
use crate::record::{LogWriter, MessageStamp, Odometry, RosMessage};
use crate::units::RAD_PER_DEG;
use crate::verify::bench::PivotMoment;
use crate::verify::drive::{Observer, Period};
use crate::verify::pivot_driver::PivotDriver;
use crate::verify::pivot_law::PivotControl;
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
        log.metadata(SCENARIO_METADATA, [("name", scenario.name.clone()), ("what", scenario.what.clone())]);
        Self { log, wheel_radius_m: maps.table2.vehicle.wheel_radius_m, last: (None, None), outcome: Ok(()) }
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

impl<'a, C: PivotControl> Observer<PivotDriver<'a, C>> for PivotLog {
    fn see(&mut self, period: &Period<'_, PivotDriver<'a, C>>) {
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
        LateralTask::Restore(angle_rad) => format!("restore {:.2}°", angle_rad / RAD_PER_DEG),
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

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::control::{PlanningSettings, Pose, SteeringFault};
    use crate::sim::{PhysicalSettings, WorldSettings};
    use crate::verify::judge::verify_with;
    use crate::verify::reference_maps::known_maps;
    use crate::verify::settings::Wanted;
    use crate::verify::{Scenario, VerifySettings};
    use std::f64::consts::FRAC_PI_2;

    #[test]
    fn tasks_and_the_wheels_status_are_named() {
        assert_eq!(task_name(LateralTask::Hold(-FRAC_PI_2)), "hold -90.00°");
        assert_eq!([LateralTask::Rest, LateralTask::Restore(0.0), LateralTask::Freeze].map(task_name), ["rest", "restore 0.00°", "freeze"]);
        assert_eq!(angle_name(AngleStatus::Fault(SteeringFault::Stuck)), "fault: Stuck");
    }

    #[test]
    fn waypoints_are_rows_of_place_and_speed_that_end_at_rest() {
        let request = PlanningSettings::new(0.92, FRAC_PI_2).plan(FRAC_PI_2, Pose::default()).unwrap();
        let text = waypoints(&request);
        let rows: Vec<Vec<f64>> = text.lines().skip(1).map(|row| row.split(',').map(|cell| cell.parse().unwrap()).collect()).collect();
        assert_eq!((text.lines().next(), rows.len()), (Some("x_m,y_m,speed_mps"), request.path.waypoints().len()));
        // the front wheel goes round the middle of the rear axle
        assert!(rows.iter().all(|row| (row[0].hypot(row[1]) - 0.92).abs() < 1e-3));
        assert_eq!(rows.last().unwrap()[2], 0.0);
    }

    #[test]
    fn a_phase_is_written_when_it_changes_and_the_motion_in_every_period() {
        let vehicle = crate::map::Vehicle {
            wheelbase_m: 0.92,
            wheel_radius_m: 0.12,
            test_angle_deg: 90.0,
            torque_limit_nm: Some(44.0),
            torque_full_scale_nm: None,
        };
        let (table1, table2) = known_maps(&WorldSettings::physical(vehicle, PhysicalSettings::default())).unwrap();
        let maps = Maps::new(table1, table2).unwrap();
        let scenarios = Scenario::all().into_iter().filter(|s| s.name == "left-90").collect();
        let settings = VerifySettings { scenarios, draws: 0, comparison_draws: 0, ..VerifySettings::new().unwrap() };
        let logs = verify_with(&maps, &settings, Wanted { logs: true, ..Wanted::default() }).unwrap().logs;
        let mut topics = std::collections::BTreeMap::new();
        for message in mcap::MessageStream::new(&logs[0].bytes).unwrap() {
            *topics.entry(message.unwrap().channel.topic.clone()).or_insert(0) += 1;
        }
        let periods = topics["/odom"];
        assert!(periods > 300 && topics["/pivot/speed_actual"] == periods && topics["/pivot/arc"] < periods, "{topics:?}");
        assert_eq!((topics["/pivot/waypoints"], topics["/pivot/task"]), (1, 3));
        assert!((4..10).contains(&topics["/pivot/phase"]), "{topics:?}");
    }
}
