//! Intervals of constant torque command, usually called runs.

use crate::campaign::SurveySettings;
use crate::signal::Series;

/// An interval of constant command, or of quick changes (each held for less than 0.3 s) taken together.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Hold {
    /// When the command was first given [s].
    pub from_s: f64,
    /// When the next command was given [s].
    pub to_s: f64,
    /// Median command [N·m], vehicle frame.
    pub torque_nm: f64,
    /// Whether the command was one value throughout.
    pub steady: bool,
}

/// A shorter hold is one of several quick changes [s].
const QUICK_S: f64 = 0.3;

/// Cuts the command into holds; `largest_nm` scales the tolerance.
pub(crate) fn holds(command: &Series, settings: &SurveySettings) -> Vec<Hold> {
    let largest = command.value.iter().fold(0.0f64, |m, v| m.max(v.abs()));
    let tolerance = (settings.hold_tolerance * largest).max(1e-9);
    let mut holds: Vec<Hold> = Vec::new();
    for (t, v) in command.t_s.iter().zip(&command.value) {
        match holds.last_mut() {
            Some(hold) if (v - hold.torque_nm).abs() <= tolerance => hold.to_s = *t,
            Some(hold) => {
                hold.to_s = *t;
                holds.push(Hold { from_s: *t, to_s: *t, torque_nm: *v, steady: true });
            }
            None => holds.push(Hold { from_s: *t, to_s: *t, torque_nm: *v, steady: true }),
        }
    }
    merge_quick(&holds)
}

fn merge_quick(holds: &[Hold]) -> Vec<Hold> {
    let mut merged: Vec<Hold> = Vec::new();
    let mut i = 0;
    while i < holds.len() {
        let quick = |h: &Hold| h.to_s - h.from_s < QUICK_S;
        let mut j = i;
        while j < holds.len() && quick(&holds[j]) {
            j += 1;
        }
        if j > i + 1 {
            let torques: Vec<f64> = holds[i..j].iter().map(|h| h.torque_nm).collect();
            merged.push(Hold {
                from_s: holds[i].from_s,
                to_s: holds[j - 1].to_s,
                torque_nm: crate::signal::median(&torques),
                steady: false,
            });
            i = j;
        } else {
            merged.push(holds[i]);
            i += 1;
        }
    }
    merged
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_become_holds_and_quick_changes_one() {
        let t_s: Vec<f64> = (0..400).map(|k| f64::from(k) * 0.02).collect();
        let value = t_s
            .iter()
            .map(|t| {
                if *t < 2.0 {
                    0.0
                } else if *t < 5.0 {
                    20.0
                } else {
                    10.0 + 5.0 * ((t * 8.0).floor() % 3.0)
                }
            })
            .collect();
        let holds = holds(&Series { t_s, value }, &SurveySettings::default());
        assert_eq!(holds.len(), 3);
        assert!(holds[1].steady && (holds[1].torque_nm - 20.0).abs() < 1e-9 && (holds[1].to_s - 5.0).abs() < 0.03);
        assert!(!holds[2].steady);
    }
}
