//! Clocks that do not agree.

use super::{Mistake, kind};
use crate::verdicts::case::Case;
use crate::verdicts::log::{ANGLE, COMMAND, FEEDBACK, SPEED, YAW_RATE};

const STAMPED: [&str; 3] = [SPEED, YAW_RATE, ANGLE];

fn speed_ahead(case: &mut Case, by_s: f64) {
    case.logs[0].stamps(SPEED, |_| by_s);
}

/// Log times and stamps move together: nothing but the motion shows it.
fn everything_ahead(case: &mut Case, topic: &str, ahead_s: impl Fn(f64) -> f64) {
    case.logs[0].stamps(topic, &ahead_s);
    case.logs[0].change(topic, |t_s, m| m.log_ns = m.log_ns.saturating_add_signed((ahead_s(t_s) * 1e9) as i64));
}

pub(super) fn all() -> Vec<Mistake> {
    [
        kind("speed's clock", [("50 ms ahead", 0.05), ("0.5 s ahead", 0.5), ("2 s ahead", 2.0), ("60 s ahead", 60.0)], |case, by_s| {
            speed_ahead(case, by_s);
            Ok(())
        }),
        kind("speed's clock behind", [("50 ms", -0.05), ("0.5 s", -0.5), ("2 s", -2.0), ("60 s", -60.0)], |case, by_s| {
            speed_ahead(case, by_s);
            Ok(())
        }),
        kind("speed logged late", [("0.2 s", 0.2), ("2 s", 2.0)], |case, by_s| {
            everything_ahead(case, SPEED, |_| by_s);
            Ok(())
        }),
        kind("speed and yaw rate logged late", [("0.2 s", 0.2), ("2 s", 2.0)], |case, by_s| {
            everything_ahead(case, SPEED, |_| by_s);
            everything_ahead(case, YAW_RATE, |_| by_s);
            Ok(())
        }),
        kind("torques logged late", [("0.2 s", 0.2), ("2 s", 2.0)], |case, by_s| {
            everything_ahead(case, COMMAND, |_| by_s);
            everything_ahead(case, FEEDBACK, |_| by_s);
            Ok(())
        }),
        kind("feedback logged late", [("0.2 s", 0.2), ("2 s", 2.0)], |case, by_s| {
            everything_ahead(case, FEEDBACK, |_| by_s);
            Ok(())
        }),
        kind("drift of the speed's clock", [("500 ppm", 5e-4), ("5000 ppm", 5e-3)], |case, rate| {
            case.logs[0].stamps(SPEED, |t_s| rate * t_s);
            Ok(())
        }),
        kind("drift of all stamps", [("500 ppm", 5e-4), ("5000 ppm", 5e-3)], |case, rate| {
            for topic in STAMPED {
                case.logs[0].stamps(topic, |t_s| rate * t_s);
            }
            Ok(())
        }),
        kind("step of the speed's clock", [("0.2 s", 0.2), ("5 s", 5.0)], |case, by_s| {
            let half_s = 0.5 * case.logs[0].length_s();
            case.logs[0].stamps(SPEED, |t_s| if t_s > half_s { by_s } else { 0.0 });
            Ok(())
        }),
        kind("speed logged late from half-way", [("0.2 s", 0.2), ("1 s", 1.0)], |case, by_s| {
            let half_s = 0.5 * case.logs[0].length_s();
            everything_ahead(case, SPEED, |t_s| if t_s > half_s { by_s } else { 0.0 });
            Ok(())
        }),
        kind("stamps rounded", [("0.1 s", 0.1), ("1 s", 1.0)], |case, step_s| {
            let step_ns = (step_s * 1e9) as u64;
            for topic in STAMPED {
                case.logs[0].change(topic, |_, m| m.set_stamp_ns(m.stamp_ns() / step_ns * step_ns));
            }
            Ok(())
        }),
        kind("log times in bursts", [("0.1 s", 0.1), ("1 s", 1.0)], |case, step_s| {
            let step_ns = (step_s * 1e9) as u64;
            for message in &mut case.logs[0].messages {
                message.log_ns = message.log_ns.div_ceil(step_ns) * step_ns;
                let is_stamped = STAMPED.contains(&message.topic.as_str());
                message.set_stamp_ns(if is_stamped { 0 } else { message.log_ns });
            }
            Ok(())
        }),
    ]
    .concat()
}
