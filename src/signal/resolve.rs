//! Resolves signs: a torque relative to the gear, a speed logged as a magnitude.

use crate::signal::{Error, Result, Series};

/// Negates values that are relative to the gear while reverse is engaged. `gear` holds −1, 0 or 1.
pub(crate) fn relative_to_gear(signal: &'static str, series: &mut Series, gear: Option<&Series>) -> Result<()> {
    let gear = gear.filter(|g| !g.is_empty()).ok_or(Error::NoGear { signal })?;
    for (t, v) in series.t_s.iter().zip(&mut series.value) {
        if gear.held(*t).is_some_and(|g| g < 0.0) {
            *v = -*v;
        }
    }
    Ok(())
}

/// Gives a magnitude its sign. Where the yaw rate is clearly not zero, it determines the sign (at a test angle on the left, a forward wheel
/// turns the vehicle left); otherwise the gear does.
pub(crate) fn signed(signal: &'static str, series: &mut Series, gear: Option<&Series>, yaw_speed_mps: Option<&Series>) -> Result<()> {
    if gear.is_none() && yaw_speed_mps.is_none() {
        return Err(Error::NoSign { signal });
    }
    let yaw_smooth = yaw_speed_mps.map(|y| Series { t_s: y.t_s.clone(), value: y.smoothed(0.1) });
    let clear_mps = 0.03;
    for (t, v) in series.t_s.iter().zip(&mut series.value) {
        let by_yaw = yaw_smooth.as_ref().and_then(|y| y.interpolated(*t)).filter(|y| y.abs() > clear_mps);
        let by_gear = gear.and_then(|g| g.held(*t)).filter(|g| *g != 0.0);
        let sign = by_yaw.or(by_gear).map_or(1.0, f64::signum);
        *v = sign * v.abs();
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn series(values: &[f64]) -> Series {
        Series { t_s: (0..values.len()).map(|k| k as f64).collect(), value: values.to_vec() }
    }

    #[test]
    fn a_torque_relative_to_gear_is_negated_in_reverse_only() {
        let mut torque = series(&[5.0, 5.0, 5.0]);
        relative_to_gear("torque", &mut torque, Some(&series(&[1.0, 0.0, -1.0]))).unwrap();
        assert_eq!(torque.value, [5.0, 5.0, -5.0]);
        assert_eq!(relative_to_gear("torque", &mut torque, None), Err(Error::NoGear { signal: "torque" }));
    }

    #[test]
    fn a_magnitude_takes_its_sign_from_the_yaw_rate_and_otherwise_from_the_gear() {
        let mut speed = series(&[0.5, 0.5]);
        signed("speed", &mut speed, Some(&series(&[1.0, -1.0])), None).unwrap();
        assert_eq!(speed.value, [0.5, -0.5]);
        let mut speed = series(&[0.5, 0.5]);
        signed("speed", &mut speed, Some(&series(&[1.0, 1.0])), Some(&series(&[-0.5, -0.5]))).unwrap();
        assert_eq!(speed.value, [-0.5, -0.5]);
        assert!(signed("speed", &mut speed, None, None).is_err());
    }
}
