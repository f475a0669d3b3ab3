//! Slip by two witnesses: the encoder sees the wheel, the yaw rate sees the vehicle.

use crate::campaign::SurveySettings;
use crate::campaign::gates::Intervals;
use crate::signal::{Alignment, Series};

/// Where encoder and yaw speed part ways, and how they compare elsewhere.
///
/// The difference is averaged over ±0.06 s after scale and delay are taken out. It counts as slip from where it leaves a small band to
/// where it returns, whenever it exceeds the threshold in between.
pub(crate) fn slips(encoder: &Series, yaw: &Series, alignment: Alignment, settings: &SurveySettings) -> Intervals {
    let mut yaw_along = yaw.cursor();
    let difference: Vec<f64> = encoder
        .t_s
        .iter()
        .zip(&encoder.value)
        .map(|(t, v)| yaw_along.interpolated(t - alignment.delay_s).map_or(0.0, |y| v / alignment.scale - y))
        .collect();
    let smooth = Series { t_s: encoder.t_s.clone(), value: difference }.smoothed(0.06);
    let size = |i: usize| smooth[i].abs() / (settings.slip_mps + settings.slip_ratio * encoder.value[i].abs());
    let mut found: Intervals = Vec::new();
    let mut i = 0;
    while i < smooth.len() {
        if size(i) < 1.0 {
            i += 1;
            continue;
        }
        let calm = 0.4;
        let mut first = i;
        while first > 0 && size(first - 1) > calm {
            first -= 1;
        }
        let mut last = i;
        while last + 1 < smooth.len() && size(last + 1) > calm {
            last += 1;
        }
        let margin_s = 0.08;
        let (from, to) = (encoder.t_s[first] - margin_s, encoder.t_s[last] + margin_s);
        match found.last_mut() {
            Some(previous) if from <= previous.1 => previous.1 = to,
            _ => found.push((from, to)),
        }
        i = last + 1;
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wheel_that_races_ahead_for_half_a_second_is_found() {
        let t_s: Vec<f64> = (0..300).map(|k| f64::from(k) * 0.02).collect();
        let yaw = Series { t_s: t_s.clone(), value: vec![0.6; 300] };
        let value = t_s.iter().map(|t| if (2.0..2.5).contains(t) { 0.75 } else { 0.606 }).collect();
        let found = slips(&Series { t_s, value }, &yaw, Alignment { scale: 1.01, delay_s: 0.0 }, &SurveySettings::default());
        assert_eq!(found.len(), 1);
        assert!(found[0].0 < 2.0 && found[0].0 > 1.7 && found[0].1 > 2.5 && found[0].1 < 2.8, "{found:?}");
    }
}
