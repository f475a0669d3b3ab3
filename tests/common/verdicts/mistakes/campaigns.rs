//! Campaigns that were driven on another floor, with another vehicle, too short, or with help.

use super::{Mistake, hidden, kind};
use crate::verdicts::Fallible;
use crate::verdicts::campaign::{from_rest, from_speed, usual};
use crate::verdicts::case::Case;
use crate::verdicts::log::{ANGLE, COMMAND, FEEDBACK, SPEED};
use crate::verdicts::vehicles::scaled;

/// Adds a second good log, changed.
fn second(case: &mut Case, change: impl FnOnce(&mut crate::verdicts::log::Log)) -> Fallible<()> {
    let mut log = case.another(&usual(case.size))?;
    change(&mut log);
    case.logs.push(log);
    Ok(())
}

fn heavier(case: &Case, factor: f64) -> String {
    scaled(&scaled(&case.text, "mass_kg", factor), "yaw_inertia_kgm2", factor)
}

fn dragging(case: &Case, factor: f64) -> String {
    scaled(&scaled(&case.text, "coulomb_nm", factor), "static_nm", factor)
}

/// The usual campaign on a slope [°].
fn sloping(case: &Case, slope_deg: f64) -> String {
    format!("slope_deg = {slope_deg}\n{}", usual(case.size))
}

/// Every run of the usual campaign with an event.
fn with_event(case: &mut Case, event: &str) -> Fallible<()> {
    let campaign = usual(case.size).replace("[[runs]]", &format!("[[runs]]\nevent = {event}"));
    case.drive(&campaign)
}

pub(super) fn all() -> Vec<Mistake> {
    let angle = "a steering angle that is off everywhere looks like another map: its yaw rate differs by less than 1.5 % up to 10°";
    [
        kind("a slope", [("1°", 1.0), ("4°", 4.0)], |case, slope_deg| {
            let campaign = sloping(case, slope_deg);
            case.drive(&campaign)
        }),
        kind("one of two logs: slope", [("2°", 2.0), ("6°", 6.0)], |case, slope_deg| {
            let log = case.another(&sloping(case, slope_deg))?;
            case.logs.push(log);
            Ok(())
        }),
        kind("one of two logs: load", [("+ 20 %", 1.2), ("+ 80 %", 1.8)], |case, factor| {
            let log = case.another_of(&heavier(case, factor), &usual(case.size))?;
            case.logs.push(log);
            Ok(())
        }),
        kind("load changed half-way", [("+ 20 %", 1.2), ("+ 80 %", 1.8)], |case, factor| {
            let log = case.another_of(&heavier(case, factor), &usual(case.size))?;
            case.logs[0].append(&log);
            Ok(())
        }),
        kind("one of two logs: brake drags", [("friction × 1.4", 1.4), ("friction × 2", 2.0)], |case, factor| {
            let log = case.another_of(&dragging(case, factor), &usual(case.size))?;
            case.logs.push(log);
            Ok(())
        }),
        kind("brake drags from half-way", [("friction × 1.4", 1.4), ("friction × 2", 2.0)], |case, factor| {
            let log = case.another_of(&dragging(case, factor), &usual(case.size))?;
            case.logs[0].append(&log);
            Ok(())
        }),
        kind("one of two logs: sign", [("torque", 0.0), ("speed", 1.0)], |case, speed| {
            second(case, |log| {
                for topic in if speed > 0.0 { vec![SPEED] } else { vec![COMMAND, FEEDBACK] } {
                    log.values(topic, |_, value| -value);
                }
            })
        }),
        kind("one of two logs: torque scale", [("× 1.15", 1.15), ("× 0.5", 0.5)], |case, factor| {
            second(case, |log| [COMMAND, FEEDBACK].iter().for_each(|topic| log.values(topic, |_, value| value * factor)))
        }),
        kind("one of two logs: speed scale", [("× 1.1", 1.1), ("rpm", 9.549)], |case, factor| {
            second(case, |log| log.values(SPEED, |_, value| value * factor))
        }),
        kind("one of two logs: speed's clock", [("0.5 s", 0.5), ("5 s", 5.0)], |case, by_s| {
            second(case, |log| log.stamps(SPEED, |_| by_s))
        }),
        kind("one of two logs: torques late", [("0.2 s", 0.2), ("1 s", 1.0)], |case, by_s| {
            second(case, |log| {
                for topic in [COMMAND, FEEDBACK] {
                    log.stamps(topic, |_| by_s);
                    log.change(topic, |_, m| m.log_ns += (by_s * 1e9) as u64);
                }
            })
        }),
        kind("two levels", [("of driving", 0.0), ("and coasting", 1.0)], |case, coasting| {
            let mut campaign = from_rest(case.size, &[18.0, 36.0], "hold_s = 3.0\nrepeats = 6");
            if coasting > 0.0 {
                campaign += &from_speed(case.size, &[0.0], "hold_s = 3.0\nrepeats = 4");
            }
            case.drive(&campaign)
        }),
        kind("few seconds", [("25 s", 1.0), ("12 s", 0.0)], |case, more| {
            let levels: &[f64] = if more > 0.0 { &[14.0, 20.0, 28.0, 36.0] } else { &[14.0, 24.0] };
            let campaign = from_rest(case.size, levels, "hold_s = 2.0");
            case.drive(&campaign)
        }),
        kind("one gear", [("forward", 0.0), ("reverse", 1.0)], |case, reverse| {
            let gear = if reverse > 0.0 { "gear = \"reverse\"\n" } else { "" };
            let campaign = from_rest(case.size, &[12.0, 18.0, 24.0, 32.0, 40.0], &format!("{gear}hold_s = 3.0\nrepeats = 3"))
                + &from_speed(case.size, &[-12.0, 0.0, 6.0], &format!("{gear}hold_s = 3.0"));
            case.drive(&campaign)
        }),
        kind("short holds", [("0.4 s", 0.4), ("0.15 s", 0.15)], |case, hold_s| {
            let campaign = from_rest(case.size, &[12.0, 18.0, 24.0, 32.0, 40.0], &format!("hold_s = {hold_s}\nrepeats = 5\npause_s = 0.1"));
            case.drive(&campaign)
        }),
        kind("pushed in every run", [("60 N for 0.5 s", 60.0), ("60 N for the whole run", -60.0)], |case, force_n| {
            let size = case.size;
            let duration_s = if force_n > 0.0 { 0.5 } else { 9.0 };
            let at_s = if force_n > 0.0 { 0.4 } else { 0.0 };
            let force_n = force_n.abs() * size;
            with_event(case, &format!("{{ kind = \"hand_push\", at_s = {at_s:.1}, duration_s = {duration_s:.1}, force_n = {force_n:.1} }}"))
        }),
        kind("slip in every run", [("0.5 s", 0.5), ("throughout", 9.0)], |case, duration_s| {
            let grip_nm = 14.0 * case.size;
            let at_s = if duration_s > 1.0 { 0.0 } else { 0.3 };
            with_event(case, &format!("{{ kind = \"wet_patch\", at_s = {at_s:.1}, duration_s = {duration_s:.1}, grip_nm = {grip_nm:.1} }}"))
        }),
        kind("wheel not at 90°", [("75°, seen", 75.0), ("45°, seen", 45.0)], |case, angle_deg| {
            let campaign = usual(case.size).replace("[[runs]]", &format!("[[runs]]\nwheel_angle_deg = {angle_deg:.1}"));
            case.drive(&campaign)
        }),
        kind("wheel not at 90°, read as 90°", [("70°", 70.0), ("45°", 45.0)], misread),
        hidden("wheel at 80°, read as 90°", [("80°", 80.0)], angle, misread),
    ]
    .concat()
}

/// The runs are driven at an angle [°] that the sensor reads as 90°.
fn misread(case: &mut Case, angle_deg: f64) -> Fallible<()> {
    let campaign = usual(case.size).replace("[[runs]]", &format!("[[runs]]\nwheel_angle_deg = {angle_deg:.1}"));
    case.drive(&campaign)?;
    case.logs[0].values(ANGLE, |_, value| value + (90.0 - angle_deg).to_radians());
    Ok(())
}
