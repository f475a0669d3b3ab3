//! Drives that are more than a dead time and a lag.
//!
//! What the simulator's drive cannot do is put into the logged command: the command that would have given the torque that was driven.

use super::{Mistake, kind};
use crate::verdicts::Fallible;
use crate::verdicts::case::Case;
use crate::verdicts::log::{COMMAND, FEEDBACK, SPEED};
use crate::verdicts::vehicle_text::changed;

fn with_drive(case: &mut Case, lines: &str) -> Fallible<()> {
    let text = changed(&case.text, &[("[drive]", lines)]);
    case.drive_as(&text)
}

fn dead_band(case: &mut Case, width_nm: f64) {
    let width_nm = width_nm * case.size;
    case.logs[0].values(COMMAND, |_, value| if value == 0.0 { 0.0 } else { value + width_nm.copysign(value) });
    case.delivered = Box::new(move |_, torque_nm, _| (torque_nm.abs() - width_nm).max(0.0).copysign(torque_nm));
}

fn hysteresis(case: &mut Case, width_nm: f64) {
    let width_nm = width_nm * case.size;
    let (mut last_nm, mut side) = (0.0, 0.0);
    case.logs[0].values(COMMAND, |_, value| {
        if value != last_nm {
            side = if value > last_nm { 1.0 } else { -1.0 };
            last_nm = value;
        }
        if value == 0.0 { 0.0 } else { value + side * width_nm }
    });
}

fn without_feedback(case: &mut Case) {
    case.logs[0].keep(FEEDBACK, |_| false);
}

/// The torque that is delivered falls with speed: the command that would have given the torque that was driven, as long before it as the drive
/// takes.
fn falling(case: &mut Case, per_mps: f64) {
    let radius_m = case.truth.vehicle.wheel_radius_m;
    let delay_s = case.truth.drive.dead_time_s + case.truth.drive.lag_s;
    let speeds = case.logs[0].series(SPEED);
    case.logs[0].values(COMMAND, |t_s, value| {
        let k = speeds.partition_point(|(at_s, _)| *at_s <= t_s + delay_s).saturating_sub(1);
        value / (1.0 - per_mps * (speeds[k].1 * radius_m).abs())
    });
    case.delivered = Box::new(move |speed_mps, torque_nm, _| torque_nm * (1.0 - per_mps * speed_mps));
}

/// The torque that is delivered falls over the campaign, by this share at its end. Right is its mean.
fn warming(case: &mut Case, share: f64) {
    let end_s = case.logs[0].length_s();
    case.logs[0].values(COMMAND, |t_s, value| value / (1.0 - share * t_s / end_s));
    case.delivered = Box::new(move |_, torque_nm, _| torque_nm * (1.0 - 0.5 * share));
}

/// More torque is commanded than the drive gives, and the log has the command.
fn limited(case: &mut Case, most_nm: f64) -> Fallible<()> {
    let most_nm = (most_nm * case.size * 2.0).round() / 2.0;
    let drive = format!("torque_limit_nm = {most_nm:.2}");
    with_drive(case, &drive)?;
    let (mut held, mut more) = (false, 1.1);
    case.logs[0].values(COMMAND, |_, value| {
        let at_limit = value.abs() > most_nm - 0.01;
        if at_limit && !held {
            more = if more < 1.2 { 1.35 } else { 1.1 };
        }
        held = at_limit;
        if at_limit { value * more } else { value }
    });
    case.delivered = Box::new(move |_, torque_nm, _| torque_nm.clamp(-most_nm, most_nm));
    Ok(())
}

pub(super) fn all() -> Vec<Mistake> {
    [
        kind("dead band", [("2 N·m", 2.0), ("6 N·m", 6.0)], |case, width_nm| {
            dead_band(case, width_nm);
            Ok(())
        }),
        kind("dead band, no feedback", [("2 N·m", 2.0), ("6 N·m", 6.0)], |case, width_nm| {
            dead_band(case, width_nm);
            without_feedback(case);
            Ok(())
        }),
        kind("rate limit", [("60 N·m/s", 60.0), ("20 N·m/s", 20.0)], |case, rate| {
            let rate = rate * case.size;
            with_drive(case, &format!("slew_limit_nm_s = {rate:.1}"))
        }),
        kind("rate limit, no feedback", [("60 N·m/s", 60.0), ("20 N·m/s", 20.0)], |case, rate| {
            let rate = rate * case.size;
            with_drive(case, &format!("slew_limit_nm_s = {rate:.1}"))?;
            without_feedback(case);
            Ok(())
        }),
        kind("resonance", [("6 Hz", 6.0), ("2 Hz", 2.0)], |case, hz| with_drive(case, &format!("frequency_hz = {hz:.1}\ndamping = 0.15"))),
        kind("resonance, no feedback", [("6 Hz", 6.0), ("2 Hz", 2.0)], |case, hz| {
            with_drive(case, &format!("frequency_hz = {hz:.1}\ndamping = 0.15"))?;
            without_feedback(case);
            Ok(())
        }),
        kind("gain falls with speed", [("10 % per m/s", 0.1), ("30 % per m/s", 0.3)], |case, share| {
            falling(case, share);
            Ok(())
        }),
        kind("gain falls with speed, no feedback", [("10 % per m/s", 0.1), ("30 % per m/s", 0.3)], |case, share| {
            falling(case, share);
            without_feedback(case);
            Ok(())
        }),
        kind("gain falls with heat", [("10 %", 0.1), ("30 %", 0.3)], |case, share| {
            warming(case, share);
            Ok(())
        }),
        kind("gain falls with heat, no feedback", [("10 %", 0.1), ("30 %", 0.3)], |case, share| {
            warming(case, share);
            without_feedback(case);
            Ok(())
        }),
        kind("torque limit", [("34 N·m", 34.0), ("26 N·m", 26.0)], limited),
        kind("torque limit, no feedback", [("34 N·m", 34.0), ("26 N·m", 26.0)], |case, most_nm| {
            limited(case, most_nm)?;
            without_feedback(case);
            Ok(())
        }),
        kind("power limit", [("200 W", 200.0), ("90 W", 90.0)], |case, watts| {
            let text = changed(&case.text, &[("[motion]", &format!("power_limit_w = {:.1}", watts * case.size))]);
            case.drive_as(&text)
        }),
        kind("power limit, no feedback", [("200 W", 200.0), ("90 W", 90.0)], |case, watts| {
            let text = changed(&case.text, &[("[motion]", &format!("power_limit_w = {:.1}", watts * case.size))]);
            case.drive_as(&text)?;
            without_feedback(case);
            Ok(())
        }),
        kind("governor (steep quadratic drag)", [("20 N·m/(m/s)²", 20.0), ("60 N·m/(m/s)²", 60.0)], |case, drag| {
            let text = changed(&case.text, &[("[motion]", &format!("quadratic_nm_s2_m2 = {:.1}", drag * case.size))]);
            case.drive_as(&text)
        }),
        kind("other scale backwards", [("× 1.15", 1.15), ("× 1.5", 1.5)], |case, factor| {
            case.logs[0].values(COMMAND, |_, value| if value < 0.0 { value * factor } else { value });
            case.delivered = Box::new(move |_, torque_nm, sign| if torque_nm * sign < 0.0 { torque_nm / factor } else { torque_nm });
            Ok(())
        }),
        kind("torque relative to the gear", [("command", 0.0), ("and feedback", 1.0)], |case, feedback| {
            let log = &mut case.logs[0];
            // reverse runs are the later ones: the command is negative when it drives there
            let from_s = log.reverse_from_s();
            log.values(COMMAND, |t_s, value| if t_s > from_s { -value } else { value });
            if feedback > 0.0 {
                log.values(FEEDBACK, |t_s, value| if t_s > from_s { -value } else { value });
            }
            Ok(())
        }),
        kind("hysteresis", [("1 N·m", 1.0), ("4 N·m", 4.0)], |case, width_nm| {
            hysteresis(case, width_nm);
            Ok(())
        }),
        kind("hysteresis, no feedback", [("1 N·m", 1.0), ("4 N·m", 4.0)], |case, width_nm| {
            hysteresis(case, width_nm);
            without_feedback(case);
            Ok(())
        }),
    ]
    .concat()
}
