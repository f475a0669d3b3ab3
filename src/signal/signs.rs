//! Checks signs that must agree: of the speed, the gear, the yaw rate, and of the torque with the motion.
//!
//! A reversed sign is no reason to drop data: it is reported as such.

use crate::signal::response::{Accelerations, HeldMeans};
use crate::signal::{Error, Result, Series};

/// Speed that shows a direction [m/s].
const CLEAR_MPS: f64 = 0.1;
/// Time that shows a sign [s].
const LEAST_S: f64 = 3.0;
/// Least share of the time against a sign that shows that the sign is wrong.
const AGAINST: f64 = 0.9;
/// Least share of the acceleration that a torque explains when its sign is clear.
const CLEAR_ANSWER: f64 = 0.5;
/// Lags of a motion behind its torque [s].
const LAGS_S: [f64; 2] = [-0.1, 0.5];

/// Time with and against a sign [s].
#[derive(Debug, Clone, Copy, Default)]
struct Agreement {
    against_s: f64,
    whole_s: f64,
}

impl Agreement {
    /// Compares the speed with another value at its time; `None` where there is none.
    fn of(speed: &Series, mut other: impl FnMut(f64) -> Option<f64>) -> Self {
        let period_s = speed.median_period_s().min(1.0);
        let mut found = Self::default();
        for (t_s, v) in speed.t_s.iter().zip(&speed.value).filter(|(_, v)| v.abs() > CLEAR_MPS) {
            let Some(other) = other(*t_s).filter(|o| *o != 0.0) else { continue };
            found.whole_s += period_s;
            found.against_s += if other * v < 0.0 { period_s } else { 0.0 };
        }
        found
    }

    fn is_against(self) -> bool {
        self.whole_s > LEAST_S && self.against_s > AGAINST * self.whole_s
    }

    fn is_with(self) -> bool {
        self.whole_s > LEAST_S && self.against_s < (1.0 - AGAINST) * self.whole_s
    }
}

/// Compares the direction of travel by the wheel, the gear and the yaw rate.
///
/// # Errors
/// One of them contradicts the others.
pub(crate) fn check_direction(encoder: &Series, gear: Option<&Series>, yaw: Option<&Series>, at_angle: impl Fn(f64) -> bool) -> Result<()> {
    let with_gear = gear.map(|gear| Agreement::of(encoder, |t| gear.held(t))).unwrap_or_default();
    let with_yaw = yaw.map(|yaw| Agreement::of(encoder, |t| yaw.interpolated(t).filter(|y| at_angle(t) && y.abs() > CLEAR_MPS)));
    let with_yaw = with_yaw.unwrap_or_default();
    let wrong = |signal, others, of: Agreement| Err(Error::Against { signal, others, against_s: of.against_s, whole_s: of.whole_s });
    match (with_gear.is_against(), with_yaw.is_against()) {
        (true, true) => wrong("speed", "the gear and the yaw rate", with_gear),
        (true, false) if with_yaw.is_with() => wrong("gear", "the speed and the yaw rate", with_gear),
        (true, false) => wrong("speed", "the gear", with_gear),
        (false, true) if with_gear.is_with() => wrong("yaw_rate", "the speed and the gear", with_yaw),
        (false, true) => wrong("yaw_rate", "the speed", with_yaw),
        (false, false) => Ok(()),
    }
}

/// Compares the torque with the motion.
///
/// # Errors
/// A higher torque clearly accelerates in the negative direction.
pub(crate) fn check_torque(torque: &Series, motion: &Accelerations) -> Result<()> {
    let Some(means) = HeldMeans::of(torque) else { return Ok(()) };
    let answer = motion.best(&means, LAGS_S[0], LAGS_S[1], 0.05);
    if !answer.is_positive && answer.explained > CLEAR_ANSWER {
        return Err(Error::TorqueAgainst { percent: 100.0 * answer.explained });
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::signal::response::tests::driven;

    fn negative(series: &Series) -> Series {
        Series { t_s: series.t_s.clone(), value: series.value.iter().map(|v| -v).collect() }
    }

    #[test]
    fn the_signal_that_runs_against_the_others_is_named() {
        let (_, speed) = driven(0.1);
        let gear = Series { t_s: speed.t_s.clone(), value: speed.value.iter().map(|v| v.signum()).collect() };
        let named = |encoder: &Series, gear: Option<&Series>, yaw: Option<&Series>| match check_direction(encoder, gear, yaw, |_| true) {
            Err(Error::Against { signal, .. }) => signal,
            _ => "none",
        };
        assert_eq!(named(&speed, Some(&gear), Some(&speed)), "none");
        assert_eq!(named(&negative(&speed), Some(&gear), Some(&speed)), "speed");
        assert_eq!(named(&negative(&speed), Some(&gear), None), "speed");
        assert_eq!(named(&speed, Some(&negative(&gear)), Some(&speed)), "gear");
        assert_eq!(named(&speed, Some(&gear), Some(&negative(&speed))), "yaw_rate");
        assert_eq!(named(&speed, None, Some(&negative(&speed))), "yaw_rate");
    }

    #[test]
    fn a_torque_against_the_motion_is_an_error() {
        let (command, speed) = driven(0.1);
        let motion = Accelerations::of(&speed).unwrap();
        assert!(check_torque(&command, &motion).is_ok());
        assert!(matches!(check_torque(&negative(&command), &motion), Err(Error::TorqueAgainst { .. })));
    }
}
