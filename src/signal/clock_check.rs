//! Offsets between the clocks of signals that must agree, found from their values.
//!
//! The stamps and the log's times are compared where the log is read. This file finds signals whose times agree with the log but are
//! wrong: from a relay that recorded late, or in a log joined from two. The feedback follows the command, the motion follows the torque,
//! and the yaw rate follows the wheel, each within some tenths of a second. A signal that agrees much better at another lag is moved.

use crate::signal::Series;
use crate::signal::response::{Accelerations, HeldMeans};

/// Lags of the motion behind its torque, and of the feedback behind the command, that a drive has [s].
const DRIVE_S: [f64; 2] = [-0.05, 0.45];
/// Lag that remains when a command is moved: that of a usual drive, dead time and lag together [s].
const USUAL_LAG_S: f64 = 0.1;
/// Range of a first search, and of a second one for signals that do not agree there [s].
const NEAR_S: f64 = 3.0;
const FAR_S: f64 = 70.0;
/// Least share of the acceleration that a torque of the same clock explains.
const AGREES: f64 = 0.4;
/// A torque that explains less than this is also compared at large lags.
const CLEAR: f64 = 0.8;
/// Another lag must explain this share of the unexplained rest.
const MUCH_BETTER: f64 = 0.35;
/// Lags of the yaw rate that a comparison of two speeds finds by itself [s].
const ALIGNED_S: f64 = 0.25;
/// Most points that are compared, and fewest.
const MOST_POINTS: usize = 2000;
const FEWEST_POINTS: usize = 100;

/// Time by which the torque must be moved so that the motion follows it [s]; `None` if it is right, or if nothing shows that it is wrong.
pub(crate) fn torque_offset_s(torque: &Series, motion: &Accelerations) -> Option<f64> {
    let means = HeldMeans::of(torque)?;
    let usual = motion.best(&means, DRIVE_S[0], DRIVE_S[1], 0.05);
    let mut best = motion.best(&means, -NEAR_S, NEAR_S, 0.1);
    if best.explained < CLEAR {
        let far = motion.best(&means, -FAR_S, FAR_S, 0.1);
        best = if far.explained > best.explained { far } else { best };
    }
    let best = motion.best(&means, best.lag_s - 0.1, best.lag_s + 0.1, 0.01);
    let is_usual = best.lag_s >= DRIVE_S[0] - 0.05 && best.lag_s <= DRIVE_S[1] + 0.05;
    let is_better = best.explained > AGREES && best.explained - usual.explained > MUCH_BETTER * (1.0 - usual.explained);
    (!is_usual && is_better).then_some(best.lag_s - USUAL_LAG_S)
}

/// Time by which the feedback must be moved so that it follows the command [s]; `None` as above.
pub(crate) fn feedback_offset_s(command: &Series, feedback: &Series) -> Option<f64> {
    let means = HeldMeans::of(command)?;
    let lag_s = lag_s(feedback, |t| Some(means.mean(t)), |_| true, DRIVE_S)?;
    Some(USUAL_LAG_S - lag_s)
}

/// Time by which the yaw rate must be moved so that it follows the wheel [s]; `None` as above. Only times for which `usable` holds count.
pub(crate) fn yaw_offset_s(encoder: &Series, yaw: &Series, usable: impl Fn(f64) -> bool) -> Option<f64> {
    let smooth = Series { t_s: encoder.t_s.clone(), value: encoder.smoothed(0.1) };
    let lag_s = lag_s(yaw, |t| smooth.interpolated(t), usable, [-ALIGNED_S, ALIGNED_S])?;
    Some(-lag_s)
}

/// The lag of `signal` behind `reference`, by their correlation, if it lies outside `usual_s` and is clearly better than any inside.
fn lag_s(signal: &Series, reference: impl Fn(f64) -> Option<f64>, usable: impl Fn(f64) -> bool, usual_s: [f64; 2]) -> Option<f64> {
    let points: Vec<usize> = (0..signal.len()).filter(|&k| usable(signal.t_s[k])).collect();
    if points.len() < FEWEST_POINTS {
        return None;
    }
    let points: Vec<(f64, f64)> =
        points.iter().step_by(points.len().div_ceil(MOST_POINTS)).map(|&k| (signal.t_s[k], signal.value[k])).collect();
    let agreement = |lag_s: f64| correlation(points.iter().filter_map(|(t, v)| Some((*v, reference(t - lag_s)?)))).powi(2);
    let best = |from_s: f64, to_s: f64, step_s: f64| {
        let count = ((to_s - from_s) / step_s).round() as usize;
        (0..=count)
            .map(|k| from_s + k as f64 * step_s)
            .map(|lag_s| (agreement(lag_s), lag_s))
            .fold((0.0, 0.0), |a, b| if b.0 > a.0 { b } else { a })
    };
    let usual = best(usual_s[0], usual_s[1], 0.05);
    if usual.0 > 1.0 - MUCH_BETTER * 0.2 {
        return None;
    }
    let mut found = best(-NEAR_S, NEAR_S, 0.1);
    if found.0 < 1.0 - MUCH_BETTER {
        let far = best(-FAR_S, FAR_S, 0.1);
        found = if far.0 > found.0 { far } else { found };
    }
    let found = best(found.1 - 0.1, found.1 + 0.1, 0.01);
    let is_usual = found.1 >= usual_s[0] - 0.05 && found.1 <= usual_s[1] + 0.05;
    (!is_usual && found.0 > AGREES && found.0 - usual.0 > MUCH_BETTER * (1.0 - usual.0)).then_some(found.1)
}

/// Correlation of pairs: −1 to 1, 0 without variation.
fn correlation(pairs: impl Iterator<Item = (f64, f64)>) -> f64 {
    let (mut n, mut x, mut y, mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0);
    for (a, b) in pairs {
        n += 1.0;
        x += a;
        y += b;
        xx += a * a;
        xy += a * b;
        yy += b * b;
    }
    let (sx, sy) = (xx - x * x / n, yy - y * y / n);
    if n > 0.0 && sx > 1e-12 * xx && sy > 1e-12 * yy { (xy - x * y / n) / (sx * sy).sqrt() } else { 0.0 }
}

/// A series on another clock.
pub(crate) fn moved(series: &mut Series, offset_s: f64) {
    series.t_s.iter_mut().for_each(|t| *t += offset_s);
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::signal::response::tests::driven;

    #[test]
    fn a_torque_on_the_same_clock_stays_and_one_that_is_late_or_early_is_moved() {
        for (late_s, wanted_s) in [(0.1, None), (0.3, None), (0.6, Some(0.5)), (-2.0, Some(-2.1)), (25.0, Some(24.9))] {
            let (command, speed) = driven(late_s);
            let found_s = torque_offset_s(&command, &Accelerations::of(&speed).unwrap());
            assert_eq!(found_s.is_some(), wanted_s.is_some(), "{late_s}: {found_s:?}");
            assert!((found_s.unwrap_or(0.0) - wanted_s.unwrap_or(0.0)).abs() < 0.03, "{late_s}: {found_s:?}");
        }
    }

    #[test]
    fn a_feedback_and_a_yaw_rate_are_moved_onto_the_clock_of_what_they_follow() {
        let (command, speed) = driven(0.1);
        let mut feedback = command.clone();
        moved(&mut feedback, 0.05);
        assert_eq!(feedback_offset_s(&command, &feedback), None);
        moved(&mut feedback, -1.0);
        assert!((feedback_offset_s(&command, &feedback).unwrap() - 1.05).abs() < 0.02);
        let mut yaw = speed.clone();
        assert_eq!(yaw_offset_s(&speed, &yaw, |_| true), None);
        moved(&mut yaw, 12.0);
        assert!((yaw_offset_s(&speed, &yaw, |_| true).unwrap() + 12.0).abs() < 0.02);
    }
}
