//! Torque feedback against command where the drive has settled: the end of every long hold.

use crate::signal::{Series, noise_std};

/// Shortest hold that counts as settling [s].
const SHORTEST_HOLD_S: f64 = 0.8;
/// The end of a hold that is used [s]: from half a second after the step.
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

/// The settled ends of the command's holds. `early_s`: how much earlier than the command the feedback is stamped; 0 when it is late.
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
        // the last message with this value, or the first with the next one if it was held until then
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Steps every 2 s, and a drive that ramps at 20 N·m/s: the last hold of each six ends before its ramp; the zero after it is too short.
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
}
