//! A speed or yaw rate that reads the same value throughout a log although the torque changes: a sensor that is dead, or another field.

use crate::log::{Recording, Signal};
use crate::signal::taken::FEWEST;
use crate::signal::{Error, Result};
use crate::units::NS_PER_S;

/// A range beyond the noise of any speed [m/s] and any yaw rate [rad/s] at rest: the other signal shows motion.
const MOTION: f64 = 0.1;
/// A wheel turned less than this (sine of its angle) hardly turns the vehicle.
const LEAST_TURN: f64 = 0.3;

/// Whether speed and yaw rate change, where torque and motion do. A speed that reads zero while no yaw rate shows motion is left to the
/// survey: the vehicle may not have moved.
///
/// # Errors
/// A signal reads one value throughout.
pub(crate) fn expect_changes(recording: &Recording) -> Result<()> {
    let signals = &recording.signals;
    let moves = |signal: &Signal| range(signal).is_some_and(|[low, high]| high - low > MOTION);
    let Some([low_nm, high_nm]) = range(&signals.torque).filter(|[low, high]| high > low) else { return Ok(()) };
    let stuck = |signal: &'static str, unit: &'static str, series: &Signal, evidence: &str| {
        let [value, high] = range(series)?;
        let seconds = series.time_ns.last()?.saturating_sub(*series.time_ns.first()?) as f64 / NS_PER_S;
        let is_stuck = series.len() >= FEWEST && high <= value;
        let evidence = evidence.to_owned();
        is_stuck.then_some(Error::Stuck { signal, unit, value, values: series.len(), seconds, low_nm, high_nm, evidence })
    };
    let turns = signals.yaw_rate.as_ref().is_some_and(moves);
    let reads_motion = signals.speed.value.first().is_some_and(|v| *v != 0.0);
    if turns || reads_motion {
        let evidence = if turns { " and the yaw rate shows motion" } else { "" };
        if let Some(error) = stuck("speed", "m/s", &signals.speed, evidence) {
            return Err(error);
        }
    }
    let is_turned = signals.angle.value.iter().any(|a| a.sin().abs() > LEAST_TURN);
    if let Some(yaw_rate) = signals.yaw_rate.as_ref().filter(|_| is_turned && moves(&signals.speed)) {
        return stuck("yaw_rate", "rad/s", yaw_rate, " and the speed shows motion with the wheel turned").map_or(Ok(()), Err);
    }
    Ok(())
}

/// Lowest and highest value.
fn range(signal: &Signal) -> Option<[f64; 2]> {
    let first = *signal.value.first()?;
    Some(signal.value.iter().fold([first; 2], |[low, high], v| [low.min(*v), high.max(*v)]))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::log::{Source, VehicleOverrides, read_bytes};
    use crate::signal::Track;

    fn demo() -> Recording {
        let log = include_bytes!("../../data/demo.mcap").to_vec();
        read_bytes(log, "demo.mcap", &Source::Detect, &VehicleOverrides::default()).unwrap()
    }

    #[test]
    fn a_speed_that_never_changes_is_named_with_its_value_before_anything_else() {
        for value in [0.0, 0.4] {
            let mut log = demo();
            log.signals.speed.value.fill(value);
            let error = Track::new(&log).unwrap_err().to_string();
            let expected = format!("speed never changes: it reads {value} m/s in all ");
            assert!(error.starts_with(&expected) && error.contains("the yaw rate shows motion") && error.contains("N·m"), "{error}");
        }
    }

    #[test]
    fn a_yaw_rate_that_never_changes_is_named_too() {
        let mut log = demo();
        log.signals.yaw_rate.as_mut().unwrap().value.fill(0.0);
        let error = Track::new(&log).unwrap_err().to_string();
        assert!(error.starts_with("yaw_rate never changes: it reads 0 rad/s") && error.contains("leave `yaw_rate` out"), "{error}");
    }

    #[test]
    fn a_vehicle_at_rest_and_a_log_without_torque_steps_are_no_dead_sensor() {
        let mut rest = demo();
        rest.signals.speed.value.fill(0.0);
        rest.signals.yaw_rate.as_mut().unwrap().value.fill(0.0);
        assert_eq!(expect_changes(&rest), Ok(()));
        let mut idle = demo();
        idle.signals.speed.value.fill(0.4);
        idle.signals.torque.value.fill(0.0);
        assert_eq!(expect_changes(&idle), Ok(()));
        assert_eq!(expect_changes(&demo()), Ok(()));
    }
}
