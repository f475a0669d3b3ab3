//! Geometry and signs that are not the vehicle's.

use super::{Mistake, hidden, kind};
use crate::verdicts::case::Case;
use crate::verdicts::log::{ANGLE, COMMAND, FEEDBACK, SPEED, YAW_RATE};

fn given(case: &mut Case, wheelbase: f64, radius: f64) {
    case.given.wheelbase_m = Some(case.truth.vehicle.wheelbase_m * wheelbase);
    case.given.wheel_radius_m = Some(case.truth.vehicle.wheel_radius_m * radius);
}

fn times(case: &mut Case, topic: &str, factor: f64) {
    case.logs[0].values(topic, |_, value| value * factor);
}

pub(super) fn all() -> Vec<Mistake> {
    let scales = "encoder and yaw rate agree: both speeds have the same scale";
    let alone = "the encoder is the only source of speed";
    [
        kind("wheelbase", [("× 1.08", 1.08), ("× 1.3", 1.3)], |case, factor| {
            given(case, factor, 1.0);
            Ok(())
        }),
        kind("wheel radius", [("× 1.08", 1.08), ("× 0.8", 0.8)], |case, factor| {
            given(case, 1.0, factor);
            Ok(())
        }),
        kind("wheelbase and radius apart", [("5 %", 1.05), ("15 %", 1.15)], |case, factor| {
            given(case, factor, 1.0 / factor);
            Ok(())
        }),
        hidden("wheelbase and radius alike", [("5 %", 1.05), ("20 %", 1.2)], scales, |case, factor| {
            given(case, factor, factor);
            Ok(())
        }),
        hidden("wheel radius, no yaw rate", [("5 %", 1.05), ("20 %", 1.2)], alone, |case, factor| {
            given(case, 1.0, factor);
            case.logs[0].keep(YAW_RATE, |_| false);
            Ok(())
        }),
        kind("gear ratio of the encoder", [("2", 2.0), ("5", 5.0)], |case, ratio| {
            times(case, SPEED, ratio);
            Ok(())
        }),
        kind("sign of the torque", [("command", 0.0), ("and feedback", 1.0)], |case, feedback| {
            times(case, COMMAND, -1.0);
            times(case, FEEDBACK, if feedback > 0.0 { -1.0 } else { 1.0 });
            Ok(())
        }),
        kind("sign of the feedback", [("whole log", 0.0), ("second half", 0.5)], |case, from| {
            let from_s = from * case.logs[0].length_s();
            case.logs[0].values(FEEDBACK, |t_s, value| if t_s >= from_s { -value } else { value });
            Ok(())
        }),
        kind("sign of the speed", [("whole log", 0.0), ("second half", 0.5)], |case, from| {
            let from_s = from * case.logs[0].length_s();
            case.logs[0].values(SPEED, |t_s, value| if t_s >= from_s { -value } else { value });
            Ok(())
        }),
        kind("speed without sign", [("whole log", 0.0), ("second half", 0.5)], |case, from| {
            let from_s = from * case.logs[0].length_s();
            case.logs[0].values(SPEED, |t_s, value| if t_s >= from_s { value.abs() } else { value });
            Ok(())
        }),
        kind("torque without sign", [("whole log", 0.0), ("second half", 0.5)], |case, from| {
            let from_s = from * case.logs[0].length_s();
            for topic in [COMMAND, FEEDBACK] {
                case.logs[0].values(topic, |t_s, value| if t_s >= from_s { value.abs() } else { value });
            }
            Ok(())
        }),
        kind("sign of the yaw rate", [("whole log", 0.0), ("second half", 0.5)], |case, from| {
            let from_s = from * case.logs[0].length_s();
            case.logs[0].values(YAW_RATE, |t_s, value| if t_s >= from_s { -value } else { value });
            Ok(())
        }),
        kind("sign of the steering", [("whole log", 0.0), ("and yaw rate", 1.0)], |case, yaw_rate| {
            times(case, ANGLE, -1.0);
            times(case, YAW_RATE, if yaw_rate > 0.0 { -1.0 } else { 1.0 });
            Ok(())
        }),
    ]
    .concat()
}
