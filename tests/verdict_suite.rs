//! A fixed part of the suite of wrong campaigns (`examples/verdicts.rs`) on one vehicle: no wrong map passes, and good campaigns do.
#![allow(clippy::unwrap_used)]

#[path = "common/verdicts/suite.rs"]
mod verdicts;

use verdicts::judge::judged;
use verdicts::mistakes::all;
use verdicts::table::figures;

/// Kinds and strengths of which no wrong map passes: it is refused, rejected, or right in spite of the mistake.
const CLEAN: [(&str, &str); 15] = [
    ("wheelbase", "× 1.08"),
    ("wheelbase and radius apart", "15 %"),
    ("sign of the torque", "command"),
    ("sign of the speed", "whole log"),
    ("rpm for rad/s", "log"),
    ("wrong field", "steering for speed"),
    ("two publishers of the command", "10 Hz"),
    ("speed stops", "at 20 %"),
    ("speed logged late from half-way", "1 s"),
    ("one of two logs: torque scale", "× 0.5"),
    ("one of two logs: load", "+ 80 %"),
    ("load changed half-way", "+ 20 %"),
    ("brake drags from half-way", "friction × 2"),
    ("two levels", "of driving"),
    ("no draws", "0"),
];

#[test]
fn no_wrong_map_of_the_fixed_set_passes() {
    let mistakes = all();
    let (mut passed, mut wrong) = (Vec::new(), 0);
    for (kind, strength) in CLEAN {
        let mistake = mistakes.iter().find(|m| m.kind == kind && m.strength == strength).unwrap();
        let outcome = judged(mistake.made("scrubber", 1).unwrap()).unwrap();
        wrong += usize::from(outcome.is_wrong());
        if outcome.is_false_pass() {
            passed.push(format!("{kind}, {strength}: {}", figures(&outcome)));
        }
    }
    assert!(passed.is_empty(), "{}", passed.join("\n"));
    assert!(wrong >= 6, "{wrong} maps are wrong: mistakes that spoil nothing show nothing");
}

#[test]
fn good_campaigns_pass_with_a_right_map() {
    for k in [0, 2] {
        let (form, case) = verdicts::good::driven_form("scrubber", k).unwrap();
        let outcome = judged(case).unwrap();
        assert!(outcome.passes() && !outcome.is_wrong(), "{form}: {}", figures(&outcome));
    }
}
