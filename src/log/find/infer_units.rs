//! Infers from the values what the names do not show: a gyro in degrees, a speed without sign, a torque in the gear's direction.
//!
//! This applies only to signals found by name; entries of a signal map are not changed.

use crate::log::recording::{Signal, Signals};
use crate::log::signal_map::SignalName;
use crate::map::Vehicle;
use crate::units::RAD_PER_DEG;

/// Signals whose unit is in no name.
pub(crate) type Unnamed<'a> = &'a [SignalName];

/// Corrects signals whose values contradict the assumed unit or sign; returns a note on each.
pub(crate) fn correct(signals: &mut Signals, vehicle: &Vehicle, unnamed: Unnamed<'_>) -> Vec<String> {
    let mut notes = Vec::new();
    if unnamed.contains(&SignalName::Angle) && largest(&signals.angle) > 2.0 * std::f64::consts::PI {
        signals.angle.value.iter_mut().for_each(|value| *value *= RAD_PER_DEG);
        notes.push("angle exceeds a whole turn in radians: read as degrees".to_owned());
    }
    let speed = signals.speed.clone();
    if let Some(yaw_rate) = signals.yaw_rate.as_mut().filter(|_| unnamed.contains(&SignalName::YawRate)) {
        // in a pivot: wheel speed = wheelbase · yaw rate
        let ratio = pairs(yaw_rate, &speed)
            .fold((0.0, 0.0), |(yaw, wheel): (f64, f64), (y, v)| (yaw + (y * vehicle.wheelbase_m).abs(), wheel + v.abs()));
        let degrees = ratio.0 / ratio.1 * RAD_PER_DEG;
        if (0.6..1.6).contains(&degrees) {
            yaw_rate.value.iter_mut().for_each(|value| *value *= RAD_PER_DEG);
            notes.push(format!("yaw_rate is {:.0} times the wheel's speed over the wheelbase: read as deg/s", ratio.0 / ratio.1));
        }
    }
    let (Some(gear), Some(yaw_rate)) = (&signals.gear, &signals.yaw_rate) else {
        return notes;
    };
    // turning right in reverse: a speed or torque that is positive there has no sign of its own
    let turning: Vec<(i64, bool)> =
        yaw_rate.time_ns.iter().zip(&yaw_rate.value).map(|(time, rate)| (*time, rate.abs() * vehicle.wheelbase_m > 0.1)).collect();
    let in_reverse = |signal: &Signal, least: f64| {
        let mut counts = (0, 0);
        for (time, value) in signal.time_ns.iter().zip(&signal.value) {
            if value.abs() > least && at(gear, *time) == Some(-1.0) && is_turning(&turning, *time) {
                if *value * at(yaw_rate, *time).unwrap_or(0.0) * vehicle.test_angle_deg.signum() < 0.0 {
                    counts.0 += 1; // against the vehicle's motion
                } else {
                    counts.1 += 1;
                }
            }
        }
        counts.0 > 20 && counts.0 > 4 * counts.1
    };
    if !signals.speed.unsigned && signals.speed.value.iter().all(|value| *value >= 0.0) && in_reverse(&signals.speed, 0.1) {
        signals.speed.unsigned = true;
        notes.push("speed is never negative, not even in reverse: read as a magnitude".to_owned());
    }
    for (name, torque) in [("torque", Some(&mut signals.torque)), ("torque_feedback", signals.torque_feedback.as_mut())] {
        if let Some(torque) = torque.filter(|torque| !torque.relative_to_gear && in_reverse(torque, 1.0)) {
            torque.relative_to_gear = true;
            notes.push(format!("{name} is positive while the vehicle drives backwards in reverse: read as relative to the gear"));
        }
    }
    notes
}

fn largest(signal: &Signal) -> f64 {
    signal.value.iter().fold(0.0, |largest: f64, value| largest.max(value.abs()))
}

/// The value that held at `time_ns`.
fn at(signal: &Signal, time_ns: i64) -> Option<f64> {
    let next = signal.time_ns.partition_point(|time| *time <= time_ns);
    next.checked_sub(1).map(|index| signal.value[index])
}

fn is_turning(turning: &[(i64, bool)], time_ns: i64) -> bool {
    let next = turning.partition_point(|(time, _)| *time <= time_ns);
    next.checked_sub(1).is_some_and(|index| turning[index].1)
}

/// The values of `a`, each with the value of `b` that held at its time, where `b` moves.
fn pairs<'a>(a: &'a Signal, b: &'a Signal) -> impl Iterator<Item = (f64, f64)> + 'a {
    a.time_ns.iter().zip(&a.value).filter_map(|(time, value)| Some((*value, at(b, *time)?))).filter(|(_, b)| b.abs() > 0.1)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn series(value: impl Fn(f64) -> f64) -> Signal {
        let time_ns: Vec<i64> = (0..500).map(|i| i64::from(i) * 20_000_000).collect();
        Signal { value: time_ns.iter().map(|time| value(*time as f64 * 1e-9)).collect(), time_ns, ..Signal::default() }
    }

    fn vehicle() -> Vehicle {
        Vehicle { wheelbase_m: 0.9, wheel_radius_m: 0.1, test_angle_deg: 90.0, torque_limit_nm: None, torque_full_scale_nm: None }
    }

    #[test]
    fn a_gyro_in_degrees_is_detected_by_the_wheel_speed() {
        let mut signals = Signals {
            speed: series(|t| 0.5 + 0.1 * t.sin()),
            yaw_rate: Some(series(|t| (0.5 + 0.1 * t.sin()) / 0.9 / RAD_PER_DEG)),
            ..Signals::default()
        };
        let notes = correct(&mut signals, &vehicle(), &[SignalName::YawRate]);
        assert_eq!(notes.len(), 1);
        assert!(signals.yaw_rate.is_some_and(|rate| largest(&rate) < 0.7));
    }

    #[test]
    fn magnitudes_are_detected_in_reverse() {
        let mut signals = Signals {
            speed: series(|_| 0.5),
            torque: series(|_| 12.0),
            yaw_rate: Some(series(|_| -0.55)),
            gear: Some(series(|_| -1.0)),
            ..Signals::default()
        };
        correct(&mut signals, &vehicle(), &[]);
        assert!(signals.speed.unsigned && signals.torque.relative_to_gear);
    }

    #[test]
    fn signed_values_in_reverse_are_not_changed() {
        let mut signals = Signals {
            speed: series(|_| -0.5),
            torque: series(|_| -12.0),
            yaw_rate: Some(series(|_| -0.55)),
            gear: Some(series(|_| -1.0)),
            ..Signals::default()
        };
        let before = signals.clone();
        assert_eq!(correct(&mut signals, &vehicle(), &[SignalName::YawRate]), Vec::<String>::new());
        assert_eq!(signals, before);
    }
}
