//! Units that are not those of the log: each once in the log, and once in the signal map.

use super::{Mistake, hidden, kind};
use crate::verdicts::case::Case;
use crate::verdicts::log::{ANGLE, COMMAND, FEEDBACK, SPEED, YAW_RATE};
use std::f64::consts::{PI, TAU};

const SPEED_UNIT: (&str, &str) = ("_drive_joint\"}', unit = \"rad/s\"", "_drive_joint\"}', unit = ");

/// The speed in another unit: `per_unit` of it make one of the log's unit. Either the values have it, or only the signal map names it.
fn speed_unit(case: &mut Case, in_map: f64, unit: &str, per_unit: f64) {
    if in_map > 0.0 {
        case.map_signals(&[(SPEED_UNIT.0, &format!("{}\"{unit}\"", SPEED_UNIT.1))]);
    } else {
        case.map_signals(&[]);
        case.logs[0].values(SPEED, |_, value| value * per_unit);
    }
}

pub(super) fn all() -> Vec<Mistake> {
    let where_it_is = [("log", 0.0), ("signal map", 1.0)];
    let scale = "one scale of all torques looks like another mass and friction";
    [
        kind("rpm for rad/s", where_it_is, |case, in_map| {
            speed_unit(case, in_map, "rpm", 60.0 / TAU);
            Ok(())
        }),
        kind("rev/s for rad/s", where_it_is, |case, in_map| {
            // the map takes rpm times 60
            if in_map > 0.0 {
                case.map_signals(&[(SPEED_UNIT.0, &format!("{}\"rpm\", scale = 60.0", SPEED_UNIT.1))]);
            } else {
                speed_unit(case, 0.0, "", 1.0 / TAU);
            }
            Ok(())
        }),
        kind("km/h, m/s for rad/s", [("km/h in the log", 0.0), ("m/s in the map", 1.0)], |case, in_map| {
            let km_h = 3.6 * case.truth.vehicle.wheel_radius_m;
            speed_unit(case, in_map, "m/s", km_h);
            Ok(())
        }),
        kind("deg/s for rad/s (yaw rate)", where_it_is, |case, in_map| {
            if in_map > 0.0 {
                case.map_signals(&[("angular.z\", unit = \"rad/s\"", "angular.z\", unit = \"deg/s\"")]);
            } else {
                case.map_signals(&[]);
                case.logs[0].values(YAW_RATE, |_, value| value * 180.0 / PI);
            }
            Ok(())
        }),
        kind("unit of the steering", where_it_is, |case, in_map| {
            if in_map > 0.0 {
                case.map_signals(&[("_steer_joint\"}', unit = \"rad\"", "_steer_joint\"}', unit = \"deg\"")]);
            } else {
                case.map_signals(&[]);
                case.logs[0].values(ANGLE, |_, value| value * 180.0 / PI);
            }
            Ok(())
        }),
        kind("scale of the command", [("× 1.15", 1.15), ("× 2", 2.0)], |case, factor| {
            case.logs[0].values(COMMAND, |_, value| value * factor);
            let inverse = 1.0 / factor;
            case.delivered = Box::new(move |_, torque_nm, _| torque_nm * inverse);
            Ok(())
        }),
        hidden("scale of all torques", [("× 1.15", 1.15), ("× 2", 2.0)], scale, |case, factor| {
            for topic in [COMMAND, FEEDBACK] {
                case.logs[0].values(topic, |_, value| value * factor);
            }
            Ok(())
        }),
    ]
    .concat()
}
