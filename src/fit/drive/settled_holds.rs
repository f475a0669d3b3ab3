//! Torque feedback against command where the drive has settled: the end of every long hold.

use crate::signal::{Series, median, noise_std};

/// A hold shorter than this is not believed to settle [s].
const SHORTEST_HOLD_S: f64 = 0.8;
/// The end of a hold that is looked at [s]: from half a second after the step on.
const WINDOW_S: f64 = 0.3;
/// Fewest readings in each half of it.
const FEWEST_OF_HALF: usize = 2;
/// The feedback has settled when the halves of a window differ by less than this share of the largest torque, beyond their noise.
const SETTLED: f64 = 0.02;

/// The settled end of a hold.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Settled {
    pub(crate) command_nm: f64,
    /// Mean of the feedback [N·m].
    pub(crate) feedback_nm: f64,
    /// The readings of the feedback.
    pub(crate) readings: std::ops::Range<usize>,
}

/// The settled ends of the command's holds. `early_s` is how much earlier than the command the feedback is stamped, 0 when it is late.
pub(crate) fn settled(command: &Series, feedback: &Series, early_s: f64) -> Vec<Settled> {
    let largest = command.value.iter().fold(0.0f64, |m, v| m.max(v.abs()));
    let noise = noise_std(&feedback.value);
    let mean = |range: std::ops::Range<usize>| feedback.value[range.clone()].iter().sum::<f64>() / range.len() as f64;
    let mut found = Vec::new();
    let mut from = 0;
    for k in 1..=command.len() {
        if k < command.len() && command.value[k] == command.value[from] {
            continue;
        }
        // the last time at which this value was told, or the next one's where it was held until then
        let to_s = command.t_s[k.min(command.len() - 1)];
        if to_s - command.t_s[from] >= SHORTEST_HOLD_S {
            let end_s = to_s - early_s;
            let (early, late) =
                (feedback.range(end_s - WINDOW_S, end_s - 0.5 * WINDOW_S), feedback.range(end_s - 0.5 * WINDOW_S, end_s - 1e-9));
            let late = late.start.max(early.end)..late.end.max(early.end);
            let fewest = early.len().min(late.len());
            if fewest >= FEWEST_OF_HALF {
                let readings = early.start..late.end;
                let allowed = SETTLED * largest + 3.0 * noise * (2.0 / fewest as f64).sqrt();
                if (mean(early) - mean(late)).abs() <= allowed {
                    found.push(Settled { command_nm: command.value[from], feedback_nm: mean(readings.clone()), readings });
                }
            }
        }
        from = k;
    }
    found
}

/// How the feedback reads the settled command.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct FeedbackReading {
    /// Feedback over command.
    pub(crate) scale: f64,
    /// Feedback at no command [N·m].
    pub(crate) offset_nm: f64,
    /// Share of the holds that settle further than 4 % of the largest torque from the command.
    pub(crate) astray: f64,
    /// A command that was held twice or more and that most of its holds miss by as much, with what they settle at [N·m]: a limited torque.
    pub(crate) missed: Option<(f64, f64)>,
}

/// A hold settles astray from here on, in shares of the largest torque: scale and offset may take 2 % each.
const ASTRAY: f64 = 0.04;

/// Holds that are enough to draw a line through.
const ENOUGH_HOLDS: usize = 200;
/// Torques nearer than this share of the largest tell no slope.
const APART: f64 = 0.2;

/// The line through the settled holds: the median of the slopes between any two (Theil & Sen), so that a limit that some of them meet does
/// not bend it. `None` with fewer than three holds, or where they are all at one torque.
pub(crate) fn reading(holds: &[Settled], largest_nm: f64) -> Option<FeedbackReading> {
    if holds.len() < 3 {
        return None;
    }
    let some: Vec<&Settled> = holds.iter().step_by(holds.len().div_ceil(ENOUGH_HOLDS)).collect();
    let mut slopes = Vec::new();
    for (k, a) in some.iter().enumerate() {
        for b in &some[..k] {
            let apart_nm = a.command_nm - b.command_nm;
            if apart_nm.abs() > APART * largest_nm {
                slopes.push((a.feedback_nm - b.feedback_nm) / apart_nm);
            }
        }
    }
    if slopes.is_empty() {
        return None;
    }
    let scale = median(&slopes);
    let offset_nm = median(&holds.iter().map(|h| h.feedback_nm - scale * h.command_nm).collect::<Vec<_>>());
    let is_astray = |h: &&Settled| (h.feedback_nm - h.command_nm).abs() > ASTRAY * largest_nm;
    let missed = holds.iter().filter(is_astray).find_map(|hold| {
        let level: Vec<&Settled> = holds.iter().filter(|h| h.command_nm == hold.command_nm).collect();
        let astray: Vec<f64> = level.iter().copied().filter(is_astray).map(|h| h.feedback_nm).collect();
        (astray.len() >= 2 && 2 * astray.len() > level.len()).then(|| (hold.command_nm, median(&astray)))
    });
    let astray = holds.iter().filter(is_astray).count();
    Some(FeedbackReading { scale, offset_nm, astray: astray as f64 / holds.len() as f64, missed })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    /// Steps every 2 s, and a drive that ramps at 20 N·m/s: the last hold of each six ends before its ramp, the zero after it is too short.
    fn driven(read: impl Fn(f64) -> f64) -> (Series, Series) {
        let (mut command, mut feedback) = (Series::default(), Series::default());
        let mut torque = 0.0f64;
        for k in 0..3000 {
            let t = f64::from(k) * 0.02;
            let hold = (t / 2.0).floor();
            let wanted = if t % 12.0 > 11.3 { 0.0 } else { [4.0, 12.0, -6.0, 0.0, -8.0, 20.0][hold as usize % 6] };
            torque += (wanted - torque).clamp(-0.4, 0.4);
            command.t_s.push(t);
            command.value.push(wanted);
            feedback.t_s.push(t);
            feedback.value.push(read(torque));
        }
        (command, feedback)
    }

    #[test]
    fn a_ramp_that_has_not_ended_is_not_settled_and_what_has_is_the_command() {
        let (command, feedback) = driven(|u| u);
        let holds = settled(&command, &feedback, 0.0);
        assert!((24..=26).contains(&holds.len()), "{}", holds.len());
        assert!(holds.iter().all(|h| (h.feedback_nm - h.command_nm).abs() < 1e-9), "{holds:?}");
    }

    #[test]
    fn scale_and_offset_are_found_and_a_limited_torque_is_astray() {
        let found = |read: fn(f64) -> f64| {
            let (command, feedback) = driven(read);
            reading(&settled(&command, &feedback, 0.0), 20.0).unwrap()
        };
        let high = found(|u| 1.1 * u - 0.3);
        assert!((high.scale - 1.1).abs() < 1e-6 && (high.offset_nm + 0.3).abs() < 1e-6, "{high:?}");
        let limited = found(|u| u.min(13.0));
        assert!(
            limited.astray > 0.15 && (limited.scale - 1.0).abs() < 1e-6 && limited.missed.is_some_and(|m| m.0 == 20.0 && m.1 < 13.1),
            "{limited:?}"
        );
        let sound = found(|u| u);
        assert!(sound.astray == 0.0 && sound.missed.is_none(), "{sound:?}");
    }
}
