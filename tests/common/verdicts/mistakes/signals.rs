//! Signals that are not what they are taken for, or not all of it.

use super::{Mistake, kind};
use crate::verdicts::case::Case;
use crate::verdicts::log::{COMMAND, FEEDBACK, SPEED, YAW_RATE};

/// Fastest rim speed of a campaign, about [m/s].
const FASTEST_MPS: f64 = 1.2;

fn offset(case: &mut Case, topic: &str, by: f64) {
    case.logs[0].values(topic, |_, value| value + by);
}

fn clamped(case: &mut Case, topic: &str, most: f64) {
    case.logs[0].values(topic, |_, value| value.clamp(-most, most));
}

fn thinned(case: &mut Case, topic: &str, rate_hz: f64) {
    let mut last_s = f64::NEG_INFINITY;
    case.logs[0].keep(topic, |t_s| {
        let keep = t_s - last_s > 0.97 / rate_hz;
        if keep {
            last_s = t_s;
        }
        keep
    });
}

/// The values of a topic keep what they had at a share of the log.
fn frozen(case: &mut Case, topic: &str, from: f64) {
    let from_s = from * case.logs[0].length_s();
    let mut last = 0.0;
    case.logs[0].values(topic, |t_s, value| {
        if t_s < from_s {
            last = value;
        }
        last
    });
}

fn stopped(case: &mut Case, topic: &str, at: f64) {
    let at_s = at * case.logs[0].length_s();
    case.logs[0].keep(topic, |t_s| t_s < at_s);
}

pub(super) fn all() -> Vec<Mistake> {
    [
        kind("wrong field", [("steering for speed", 0.0), ("roll rate for yaw rate", 1.0)], |case, yaw_rate| {
            let speed = ("velocity{name==\"front_drive_joint\"}", "position{name==\"front_steer_joint\"}");
            let rate = ("twist.angular.z", "twist.angular.x");
            case.map_signals(&[if yaw_rate > 0.0 { rate } else { speed }]);
            Ok(())
        }),
        kind("feedback as command", [("alone", 0.0), ("swapped", 1.0)], |case, swapped| {
            let feedback = "torque_feedback = { path = \"/drive/torque_feedback.data\", unit = \"N.m\" }";
            let other = if swapped > 0.0 { "torque_feedback = { path = \"/drive/COMMAND.data\", unit = \"N.m\" }" } else { "" };
            let command = ("torque_command", "torque_feedback");
            case.map_signals(&[(feedback, other), command, ("COMMAND", "torque_command")]);
            Ok(())
        }),
        kind("offset of the speed", [("0.03 m/s", 0.03), ("0.15 m/s", 0.15)], |case, by_mps| {
            let by = by_mps / case.truth.vehicle.wheel_radius_m;
            offset(case, SPEED, by);
            Ok(())
        }),
        kind("offset of the yaw rate", [("0.03 rad/s", 0.03), ("0.15 rad/s", 0.15)], |case, by| {
            offset(case, YAW_RATE, by);
            Ok(())
        }),
        kind("offset of the command", [("1 N·m", 1.0), ("4 N·m", 4.0)], |case, by_nm| {
            let by_nm = by_nm * case.size;
            offset(case, COMMAND, by_nm);
            case.delivered = Box::new(move |_, torque_nm, sign| torque_nm - sign * by_nm);
            Ok(())
        }),
        kind("offset of all torques", [("1 N·m", 1.0), ("4 N·m", 4.0)], |case, by_nm| {
            let by_nm = by_nm * case.size;
            offset(case, COMMAND, by_nm);
            offset(case, FEEDBACK, by_nm);
            case.delivered = Box::new(move |_, torque_nm, sign| torque_nm - sign * by_nm);
            Ok(())
        }),
        kind("saturated speed", [("at 60 %", 0.6), ("at 30 %", 0.3)], |case, share| {
            let most = share * FASTEST_MPS / case.truth.vehicle.wheel_radius_m;
            clamped(case, SPEED, most);
            Ok(())
        }),
        kind("saturated yaw rate", [("at 60 %", 0.6), ("at 30 %", 0.3)], |case, share| {
            let most = share * FASTEST_MPS / case.truth.vehicle.wheelbase_m;
            clamped(case, YAW_RATE, most);
            Ok(())
        }),
        kind("saturated speed and yaw rate", [("at 60 %", 0.6), ("at 30 %", 0.3)], |case, share| {
            let (radius_m, base_m) = (case.truth.vehicle.wheel_radius_m, case.truth.vehicle.wheelbase_m);
            clamped(case, SPEED, share * FASTEST_MPS / radius_m);
            clamped(case, YAW_RATE, share * FASTEST_MPS / base_m);
            Ok(())
        }),
        kind("saturated command", [("at 30 N·m", 30.0), ("at 20 N·m", 20.0)], |case, most_nm| {
            let most_nm = most_nm * case.size;
            clamped(case, COMMAND, most_nm);
            Ok(())
        }),
        kind("saturated command, no feedback", [("at 30 N·m", 30.0), ("at 20 N·m", 20.0)], |case, most_nm| {
            let most_nm = most_nm * case.size;
            clamped(case, COMMAND, most_nm);
            case.logs[0].keep(FEEDBACK, |_| false);
            Ok(())
        }),
        kind("saturated feedback", [("at 30 N·m", 30.0), ("at 20 N·m", 20.0)], |case, most_nm| {
            let most_nm = most_nm * case.size;
            clamped(case, FEEDBACK, most_nm);
            Ok(())
        }),
        kind("coarse command", [("3 N·m", 3.0), ("9 N·m", 9.0)], |case, step_nm| {
            let step_nm = step_nm * case.size;
            case.logs[0].values(COMMAND, |_, value| (value / step_nm).round() * step_nm);
            Ok(())
        }),
        kind("coarse command, no feedback", [("3 N·m", 3.0), ("9 N·m", 9.0)], |case, step_nm| {
            let step_nm = step_nm * case.size;
            case.logs[0].values(COMMAND, |_, value| (value / step_nm).round() * step_nm);
            case.logs[0].keep(FEEDBACK, |_| false);
            Ok(())
        }),
        kind("coarse speed", [("0.05 m/s", 0.05), ("0.2 m/s", 0.2)], |case, step_mps| {
            let step = step_mps / case.truth.vehicle.wheel_radius_m;
            case.logs[0].values(SPEED, |_, value| (value / step).round() * step);
            Ok(())
        }),
        kind("low rate of the speed", [("5 Hz", 5.0), ("2 Hz", 2.0)], |case, rate_hz| {
            thinned(case, SPEED, rate_hz);
            Ok(())
        }),
        kind("low rate of the command", [("5 Hz", 5.0), ("1 Hz", 1.0)], |case, rate_hz| {
            thinned(case, COMMAND, rate_hz);
            case.logs[0].keep(FEEDBACK, |_| false);
            Ok(())
        }),
        kind("dead yaw rate", [("from the start", 0.0), ("half-way", 0.5)], |case, from| {
            frozen(case, YAW_RATE, from);
            Ok(())
        }),
        kind("dead speed", [("from the start", 0.0), ("half-way", 0.5)], |case, from| {
            frozen(case, SPEED, from);
            Ok(())
        }),
        kind("dead feedback", [("from the start", 0.0), ("half-way", 0.5)], |case, from| {
            frozen(case, FEEDBACK, from);
            Ok(())
        }),
        kind("scale of the yaw rate", [("× 1.08", 1.08), ("× 1.3", 1.3)], |case, factor| {
            case.logs[0].values(YAW_RATE, |_, value| value * factor);
            Ok(())
        }),
        kind("scale of the feedback", [("× 0.8", 0.8), ("× 0.31", 0.31)], |case, factor| {
            case.logs[0].values(FEEDBACK, |_, value| value * factor);
            Ok(())
        }),
        kind("two publishers of the command", [("2 Hz", 2.0), ("10 Hz", 10.0)], |case, rate_hz| {
            let log = &mut case.logs[0];
            let mut others = Vec::new();
            let mut last_s = f64::NEG_INFINITY;
            log.change(COMMAND, |t_s, message| {
                if t_s - last_s >= 1.0 / rate_hz {
                    last_s = t_s;
                    let mut other = message.clone();
                    other.set_value(0.0);
                    other.log_ns += 7_000_000;
                    other.publish_ns += 7_000_000;
                    others.push(other);
                }
            });
            log.messages.extend(others);
            Ok(())
        }),
        kind("speed stops", [("at 50 %", 0.5), ("at 20 %", 0.2)], |case, at| {
            stopped(case, SPEED, at);
            Ok(())
        }),
        kind("command stops", [("at 50 %", 0.5), ("at 20 %", 0.2)], |case, at| {
            stopped(case, COMMAND, at);
            Ok(())
        }),
        kind("yaw rate stops", [("at 50 %", 0.5), ("at 20 %", 0.2)], |case, at| {
            stopped(case, YAW_RATE, at);
            Ok(())
        }),
    ]
    .concat()
}
